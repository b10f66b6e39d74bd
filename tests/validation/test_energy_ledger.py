"""V11: work in = stored + dissipated, to round-off; and each entry where a closed form gives it."""

import math

import pytest
from hypothesis import given

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, MOTORS, harmonic, motor, paper, scene
from tests.trajectories import collect, opened

CASE_RESIDUAL = 1e-12  # relative; measured 3e-15 ... 4e-14
RANDOM_RESIDUAL = 1e-11  # a random scene may end with its entries cancelling to a tenth of their throughput


def totals(a_scene, engine="c"):
    return collect(opened(a_scene, engine, ledger=True)).totals


def methods(name):
    return ("taylor",) if name in MOTORS else ("closed_form", "taylor")


@pytest.mark.parametrize(("name", "method"), [(n, m) for n in CASE_NAMES for m in methods(n)])
def test_the_ledger_of_the_nine_cases_closes(name, method):
    assert totals(paper(name, t_end=300.0, method=method))["energy_residual_relative"] < CASE_RESIDUAL


@given(scenes())
def test_the_ledger_of_random_scenes_closes(a_scene):
    assert totals(a_scene)["energy_residual_relative"] < RANDOM_RESIDUAL


@given(scenes(radians=8.0))
def test_both_engines_keep_the_same_ledger(a_scene):
    c, python = totals(a_scene, "c"), totals(a_scene, "python")
    names = ("energy_start", "energy_end", "work_source", "loss_viscous", "loss_friction")
    assert [c[name] for name in names] == [python[name] for name in names]


def test_a_sliding_block_loses_its_kinetic_energy_to_friction():
    ledger = totals(scene(k1=0.0, c=0.0, k2=None, G=None, v2=0.05, t_end=10.0))
    assert ledger["loss_friction"] == pytest.approx(2.94 * 0.05**2 / 2, rel=1e-14)
    assert ledger["work_source"] == ledger["loss_viscous"] == 0.0


@pytest.mark.parametrize("c", [0.5, 14.6, 500.0])  # weak, near critical, far above critical
def test_a_damped_oscillator_loses_what_it_no_longer_has(c):
    bare = {"N": None, "k2": None, "G": None, "m2": None, "x2": None, "v2": None}
    ledger = totals(scene(**bare, c=c, x1=0.01, t_end=2.0))
    assert ledger["energy_start"] == pytest.approx(200 * 0.01**2 / 2, rel=1e-15)
    assert ledger["loss_viscous"] == pytest.approx(ledger["energy_start"] - ledger["energy_end"], rel=1e-13)


def test_the_source_does_the_work_of_a_driven_free_mass():
    """m x'' = A sin(w t) from rest: v = A (1 - cos w t) / (m w), work m v^2 / 2."""
    bare = {"N": None, "k2": None, "G": None, "m2": None, "x2": None, "v2": None, "k1": 0.0, "c": 0.0}
    ledger = totals(scene(harmonic(2.0, 0.3), **bare, t_end=0.7))
    speed = 0.3 * (1 - math.cos(4 * math.pi * 0.7)) / (0.297 * 4 * math.pi)
    assert ledger["work_source"] == pytest.approx(0.297 * speed**2 / 2, rel=1e-12)


def test_the_motor_spends_its_work_on_the_rotor_where_nothing_else_moves():
    """V9: phidot = Omega0 (1 - exp(-M0 t / (Omega0 (J + m3 e^2)))), work = (J + m3 e^2) phidot^2 / 2."""
    heavy = {
        "m1": 1e12,
        "N": None,
        "k2": None,
        "G": None,
        "m2": None,
        "x2": None,
        "v2": None,
        "k1": 0.0,
        "c": 0.0,
    }
    ledger = totals(scene(motor(5.5), **heavy, t_end=20.0))
    inertia, speed = 0.001 + 0.03 * 0.11**2, 2 * math.pi * 5.5
    reached = speed * -math.expm1(-0.005 * 20.0 / (speed * inertia))
    assert ledger["work_source"] == pytest.approx(inertia * reached**2 / 2, rel=1e-9)
