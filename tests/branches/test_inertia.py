"""The table of docs/branches.md on the inertia of the rotor: every number of it, computed anew."""

import re
from functools import cache
from math import acos, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import vibsim
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.coordinates import case_on_orbit

PAGE = Path(__file__).parents[2] / "docs" / "branches.md"
STARTS = {  # turns: x1, v1, v2, phidot near the stable orbit at c = 0.03 N s/m, whose x2 is 0
    1: (0.0506539, 0.746678, -0.0819032, 22.164),
    2: (0.0204283, 0.890209, -0.0985671, 32.192),
    3: (0.0226424, -0.842419, 0.0946212, 38.0079),
}
NUMBER = r"(\d+\.?\d*)"
ROW = re.compile(
    rf"\| (\d) turns? \| {NUMBER} Hz \| {NUMBER} Hz, {NUMBER} % \| {NUMBER} Hz \| {NUMBER} Hz \({NUMBER} mm\)"
    rf" \| (\d)/(\d): {NUMBER} Hz \|"
)
TABLE = [match.groups() for match in ROW.finditer(PAGE.read_text(encoding="utf-8"))]


@cache
def ends(turns, no_load):
    """(inertia, speed [Hz], its swing over it, free amplitude [m]) at both ends of the branch over J."""
    case = load_case("II-B", {"c": "0.03", "Omega0": f"{no_load} Hz"})
    names = ("x1", "v1", "v2", "phidot")
    state = dict(zip(names, STARTS[turns], strict=True)) | {"x2": 0.0, "phi": 0.0}
    orbit = find_orbit(case.scene(), state, turns, case=case)
    branch = vibsim.continue_branch(orbit, "J", "0.001:0.1 kg m^2")
    return [_measured(branch, turns, i) for i in (0, -1)]


def _measured(branch, turns, i):
    """From samples 0.5 ms apart: extremes are off by (w h)^2 / 8 at most, 1e-4 of them at 60 rad/s."""
    point = branch.points[i].orbit
    state = branch.map.coordinates.state(np.array(point.state))
    case = case_on_orbit(branch.plan.family().at(point.parameter), state, point.period)
    run = vibsim.simulate(case.with_values({"run.every": "0.5 ms"}))
    speed = turns / point.period
    return point.parameter, speed, np.ptp(run["phidot"]) / (2 * pi * speed), np.max(run["x1"] - run["x2"])


def machine():
    """Natural rates without and with the stop [rad/s], and the gap, k1, k2 of II-B."""
    m1, m2, k1, k2, gap = 0.297 + 0.03, 2.94, 200.0, 12400.0, 1e-3  # with the unbalanced mass
    reduced = m1 * m2 / (m1 + m2)
    return sqrt(k1 / reduced), sqrt((k1 + k2) / reduced), gap, k1, k2


def free_frequency(a):
    """f(a) = 1 / (2 (t1 + t2)) of docs/branches.md [Hz], a the amplitude on the free side [m]."""
    w1, w2, gap, k1, k2 = machine()
    d, V = gap * k1 / (k1 + k2), a * w1 * sqrt(1 - (gap / a) ** 2)
    t1, t2 = acos(-gap / a) / w1, acos(d / sqrt(d * d + (V / w2) ** 2)) / w2
    return 1 / (2 * (t1 + t2))


def bilinear_frequency():
    w1, w2, *_ = machine()
    return w1 * w2 / (w1 + w2) / pi


def rounded(text):
    """The value of a number in the page, and half a unit of its last place."""
    places = len(text.partition(".")[2])
    return pytest.approx(float(text), abs=0.5001 * 10.0**-places)


def test_all_rows_are_read():
    assert [row[0] for row in TABLE] == ["1", "2", "3"]


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row[0]} turns")
def test_a_row(row):
    turns, no_load, light, swing, heavy, free, amplitude, over, under, fraction = row
    (first, speed, swings, _), (last, slow, steady, a) = ends(int(turns), no_load)
    assert (first, last) == pytest.approx((0.001, 0.1), rel=1e-12)
    assert speed == rounded(light) and 100 * swings == rounded(swing)
    assert slow == rounded(heavy) and steady < 0.006
    share = int(over) / int(under)
    assert 1e3 * a == rounded(amplitude) and share * free_frequency(a) == rounded(free)
    assert share * bilinear_frequency() == rounded(fraction)
    assert share * free_frequency(a) < share * bilinear_frequency() < speed
