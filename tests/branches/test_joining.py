"""Orbits of two periods beside a grazing: where they join those of one, and leave them."""

from dataclasses import replace

import numpy as np
import pytest

import vibsim
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.interpolant import shift
from vibsim.orbits.branches.node import Node
from vibsim.orbits.branches.tracing import trace

SPAN = "0.1172:0.1173 Hz"  # of the bilinear oscillator: graze, doubling and another graze within 5e-5 of it


def at(frequency):
    return load_case("gallery/bilinear-oscillator", {"drive.omega": f"{frequency} Hz"})


@pytest.fixture(scope="module")
def once():
    case = at(0.11728)  # clear of the stop: the linear motion
    orbit = find_orbit(case.scene(), {"x_mass": 0.99, "v_mass": 0.0}, 1, case=case)
    return vibsim.continue_branch(orbit, "drive.omega", SPAN)


@pytest.fixture(scope="module")
def twice():
    case = at(0.117298)
    orbit = find_orbit(case.scene(), {"x_mass": 0.999905, "v_mass": 0.024066}, 2, case=case)
    assert orbit.n == 2 and orbit.spelled == "be"
    return vibsim.continue_branch(orbit, "drive.omega", SPAN)


def apart(branch):
    """How far the orbit at each point is from itself one period later, scaled."""
    family = branch.plan.family()
    for point in branch.points:
        node = Node.of(family(np.array(point.unknowns)), np.array(point.tangent), 0)
        yield np.linalg.norm(shift(family, node, 1))


def test_a_branch_ends_where_it_joins_orbits_of_fewer_periods(once, twice):
    """Newton's method went over to these near their doubling, where no test value changes its sign."""
    assert dict(twice.lines())["ends"] == "joins the orbits of 1 period; end of the range"
    assert min(apart(twice)) > 1e-8
    doubling = once.special("PD1").parameter
    assert twice["parameter"][0] == pytest.approx(doubling, rel=1e-9)
    assert dict(twice.lines())["index check"] == "holds everywhere"


def test_a_switch_goes_to_the_branch_that_leaves_there(once, twice):
    """Not to orbits of two periods beyond the fold that is near the doubling."""
    left = vibsim.continue_branch(once, switch="PD1")
    assert abs(left["parameter"][0] / once.special("PD1").parameter - 1) < 1e-5
    assert [special.label for special in left.specials] == ["GR1", "F1"]
    for label in ("GR1", "F1"):
        assert left.special(label).parameter == pytest.approx(twice.special(label).parameter, rel=1e-11)


THREE = """
bodies: {a: 1.578 kg, b: 0.9967 kg, d: 1.9 kg}
links:
  l0: {between: [a, ground], k: 156.5 N/m, c: 1.068 N s/m}
  l1: {between: [b, a], k: 117.9 N/m, c: 1.176 N s/m}
  l2: {between: [d, b], k: 81.6 N/m, c: 0.5218 N s/m}
stops:
  s0: {between: [a, b], gap: 0.1911 m, acts: compression, k: 1692 N/m, c: 2.417 N s/m, release: force}
forces:
  p: {on: b, A: 17.83 N, omega: 0.4378 Hz, phase: 140.4 deg}
run: {t_end: 60 s, every: 20 ms}
"""


def test_the_last_orbit_is_not_one_of_those_that_are_joined():
    """Newton's method went over to one of them in the search for the last."""
    branch = vibsim.continue_branch(vibsim.orbit(load_case_text(THREE)), "stops.s0.gap", "0.0911:0.441 m")
    assert branch.plan.family().n == 2
    assert "joins the orbits of 1 period" in dict(branch.lines())["ends"]
    assert min(apart(branch)) > 1e-8


@pytest.mark.parametrize(
    ("earlier", "same_way", "ends"), [(11, True, True), (10, True, False), (11, False, False)]
)
def test_a_branch_that_comes_back_to_where_it_was_ends_there(earlier, same_way, ends):
    """Told by a bifurcation that it alone goes through, met again more than ten points later on one way: here
    the doubling of the ball, which is said to have been met before.
    """
    plan = vibsim.continue_branch("gallery/ball-on-shaken-table", "base.a", "0.5:1.2 mm").plan
    whole, again = BranchStore(plan), BranchStore(plan)
    trace(plan, whole)
    (doubling,) = whole.specials
    way = doubling.way if same_way else -doubling.way
    again.specials.append(replace(doubling, number=doubling.number - earlier, way=way))
    trace(plan, again)
    assert ("comes back to a doubling that it has passed" in [one.ended for one in again.points]) == ends
    assert (len(again.points) < len(whole.points)) == ends and len(again.specials) == 1 + (not ends)


@pytest.mark.slow
def test_a_step_onto_a_branch_beside_is_taken_again():
    """Symmetric orbits of the impact damper are born in folds with one more blow on both sides each, which
    bring the next branch point with them. Their map is that of half a period twice, so no real multiplier is
    below 0, but by rounding.
    """
    branch = vibsim.continue_branch("gallery/impact-damper", "drive.A", "0.1:6 N")
    assert branch.ends == ("end of the range", "end of the range")
    assert not [one for one in branch.specials if one.kind in ("unresolved", "doubling")]
    for word in branch["word"][:: len(branch) // 50]:
        assert word.count("b1") == word.count("b2")
    assert max(word.count("b1") for word in branch["word"]) == 5
    multipliers = branch["multipliers"]
    real = multipliers[multipliers.imag == 0].real
    assert real.min() > -1e-6
