"""Orbits of vibsim's own in 40 digits (own_digits.json), held to laws that know of no orbit."""

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest

import vibsim
from vibsim.orbits.orbit_digits import refine

STORED = {one["case"]: one for one in json.loads(Path(__file__).with_name("own_digits.json").read_text())}
QUICK = ["gallery/impact-oscillator-coco", "gallery/ball-on-shaken-table"]
# what the multipliers of a period multiply to: exp(-c T / m), times e^2 at each impact
LAWS = {
    "gallery/bilinear-oscillator": lambda T: mpmath.exp(-T / 50),
    "gallery/impact-oscillator-coco": lambda T: mpmath.mpf("0.64") * mpmath.exp(-T / 10),
    "gallery/impact-oscillator": lambda T: mpmath.mpf("0.64"),
    "gallery/ball-on-shaken-table": lambda T: mpmath.mpf("0.64"),
}


def number(text):
    return mpmath.mpf(text)


@pytest.mark.parametrize("name", LAWS)
def test_multipliers_multiply_as_liouville_says(name):
    stored = STORED[name]
    with mpmath.workdps(50):
        (re, im), (other, minus) = [[number(text) for text in pair] for pair in stored["multipliers"]]
        product = re * other - im * minus
        assert abs(product / LAWS[name](number(stored["period"])) - 1) < mpmath.mpf("1e-38")


def test_budd_and_duxs_orbit_in_closed_form():
    """V13: the trace of the matrix, with the speed of the impact from the closed form, in 40 digits."""
    stored = STORED["gallery/impact-oscillator"]
    with mpmath.workdps(50):
        w, e = mpmath.mpf("3.7"), mpmath.mpf("0.8")
        T, gain = 4 * mpmath.pi / w, 1 / (1 - w**2)
        a, b = mpmath.sin(T) / (1 - mpmath.cos(T)) * (1 + e), (1 - e) / w
        V = 2 * mpmath.sqrt(gain**2 * (a**2 + b**2)) / (a**2 + b**2)
        load = a * V / 2 / gain
        trace = -2 * e * mpmath.cos(T) + (1 + e) * load * mpmath.sin(T) / V
        assert abs(number(stored["period"]) / T - 1) < mpmath.mpf("1e-39")
        assert abs(sum(number(re) for re, _ in stored["multipliers"]) / trace - 1) < mpmath.mpf("1e-37")


@pytest.mark.parametrize("name", QUICK)
def test_doubles_and_digits(name):
    met(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in STORED if name not in QUICK])
def test_doubles_and_digits_of_the_others(name):
    met(name)


def met(name):
    """The orbit in doubles is the stored one to rounding, and its digits are the stored ones."""
    stored, orbit = STORED[name], vibsim.orbit(name)
    assert (orbit.n, orbit.spelled) == (stored["n"], stored["events"])
    assert orbit.period == pytest.approx(float(stored["period"]), rel=1e-14)
    size = max(abs(orbit.X))
    for value, text in zip(orbit.X, stored["coordinates"].values(), strict=True):
        assert value == pytest.approx(float(text), abs=1e-12 * size)
    told = refine(orbit, 40)
    with mpmath.workdps(50):
        for name_of, text in stored["coordinates"].items():
            assert abs(number(told.coordinates[name_of]) - number(text)) < mpmath.mpf("1e-38") * size
    exact = [complex(float(re), float(im)) for re, im in stored["multipliers"]]
    np.testing.assert_allclose(orbit.multipliers, exact, rtol=0, atol=1e-11)
