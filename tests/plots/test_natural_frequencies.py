"""Frequencies against the figures of the paper's parameters (common values, closed forms)."""

import math

import pytest

from vibsim.cases import load_case
from vibsim.plots.samples import fractions, natural_frequencies, shortest_period, source_period


def named(case):
    return {frequency.name: frequency.hz for frequency in natural_frequencies(case.scene())}


def test_ideal_source():
    found = named(load_case("I-C"))
    assert found["held"] == pytest.approx(4.130, abs=5e-4)
    assert found["free-free"] == pytest.approx(4.3337, abs=5e-5)
    assert found["bilinear"] == pytest.approx(7.6975, abs=5e-5)


def test_motor_counts_m3_to_block_1():
    found = named(load_case("II-B"))
    assert found["free-free"] == pytest.approx(4.149, abs=5e-4)
    assert found["bilinear"] == pytest.approx(7.37, abs=5e-3)
    assert found["half bilinear"] == pytest.approx(3.69, abs=6e-3)


def test_without_stop_there_is_no_bilinear_frequency(subject):
    assert set(named(subject("bare").case)) == {"held", "free-free"}


def test_fractions_are_those_of_a_motion_with_impacts(subject):
    found = {frequency.name: frequency.hz for frequency in fractions(load_case("II-B").scene())}
    assert found["⅔ bilinear"] == pytest.approx(2 / 3 * 7.37, abs=4e-3)
    assert found["½ free-free"] == pytest.approx(4.149 / 2, abs=3e-4)
    assert fractions(subject("bare").scene) == []


def test_fixed_block(subject):
    found = named(subject("fixed").case)
    assert found["held"] == pytest.approx(4.130, abs=5e-4)
    assert "free-free" not in found


def test_periods():
    scene = load_case("I-C").scene()
    assert source_period(scene) == pytest.approx(1 / 6.5)
    assert shortest_period(scene) == pytest.approx(1 / 34.397, rel=1e-4)
    motor = load_case("II-B").scene()
    assert source_period(motor) == pytest.approx(1 / 5.5)
    assert source_period(motor, phidot=2 * math.pi * 4) == pytest.approx(0.25)
