"""Branches and loci up to values beyond which a case has no sense: no damping, a restitution of 1."""

from math import exp, pi

import numpy as np
import pytest

import vibsim
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import read_span

COCO, PERIOD = "gallery/impact-oscillator-coco", 2 * pi  # [s]; damping 0.1 N s/m of 1 kg, restitution 0.8
RATIO = 1.1  # of the frequencies: at 1 the impact without damping is where the section is


@pytest.mark.parametrize(
    ("key", "span", "end", "bound", "product"),
    [
        ("wall.e", "0.7:1", -1, 1.0, exp(-0.1 * PERIOD / RATIO)),
        ("spring.c", "0:0.12 N s/m", 0, 0.0, 0.8**2),
    ],
)
def test_a_branch_comes_to_the_end_of_what_its_case_allows(key, span, end, bound, product):
    """The last point has that very value; multipliers multiply to e^2 exp(-c T / m) of it."""
    branch = vibsim.continue_branch(vibsim.orbit(COCO, {"drive.omega": f"{RATIO} rad/s"}), key, span)
    assert dict(branch.lines())["ends"] == "end of the range" and branch["parameter"][end] == bound
    assert np.prod(branch["multipliers"][end]).real == pytest.approx(product, rel=1e-10)


def test_a_branch_may_begin_there():
    """The way outwards ends at the start; the way back is followed all the same."""
    branch = vibsim.continue_branch(vibsim.orbit(COCO, {"wall.e": "1"}), "wall.e", "0.9:1")
    assert dict(branch.lines())["ends"] == "end of the range"
    assert (branch["parameter"][0], branch["parameter"][-1]) == (0.9, 1.0)


@pytest.mark.parametrize("start", [0.0, 0.004])
def test_a_locus_comes_to_the_end_of_what_its_case_allows(start):
    """Doublings of the bilinear oscillator over the damping of its stop, begun at none and at some."""
    case = load_case("gallery/bilinear-oscillator", {"drive.omega": "0.118 Hz", "wall.c": f"{start} N s/m"})
    orbit = find_orbit(case.scene(), {"x_mass": 1.0, "v_mass": 0.02}, 1, case=case)
    branch = vibsim.continue_branch(orbit, "drive.omega", "0.1172:0.1181 Hz")
    plan = locus_plan(branch, "PD1", *read_span(branch.case, "wall.c", "0:0.01 N s/m"))
    locus, finished = complete(LocusStore(plan))
    assert finished and locus.ends == ("end of the range", "end of the range")
    assert (locus["second"][0], locus["second"][-1]) == (0.0, 0.01)
    assert abs(locus["multipliers"] + 1).min(axis=1).max() < 1e-8
