"""Orbits of two periods beside a grazing: where they join those of one, and leave them."""

import numpy as np
import pytest

import vibsim
from vibsim.branches.joining import shift
from vibsim.branches.node import Node
from vibsim.cases import load_case
from vibsim.orbits import find_orbit

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
