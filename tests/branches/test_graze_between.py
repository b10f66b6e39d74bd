"""A step of a branch that leads across a graze of a rigid stop."""

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.inspection import inspect
from vibsim.orbits.branches.node import node_at
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.search import orbit

SCENE = """
name: across
bodies: {a: 0.8746 kg}
links: {l0: {between: [a, ground], k: 69.52 N/m, c: 1.406 N s/m}}
stops: {s0: {between: [a, ground], gap: 0.2423 m, acts: extension, law: rigid, e: 0.49}}
friction:
  f0: {between: [a, ground], N: 0.443 N, belt: 0.762 m/s, law: stribeck hyperbolic, mu_s: 0.4995,
    mu_d: 0.2049, d: 1.884 s/m}
forces:
  p:
    on: a
    terms: [{A: 7.015 N, omega: 0.991 Hz, phase: 119.8 deg}, {A: 4.667 N, omega: 1.982 Hz, phase: 44.72 deg}]
run: {t_end: 60 s, every: 20 ms}
"""
GRAZE = 0.4974312717  # restitution; there a DOP853 of its own turns 5e-9 m before the stop


def test_a_graze_is_told_where_a_step_leads_across_it():
    """Orbits with a second, slow blow have a multiplier of -79 behind it: brackets of orbits do not close in
    on the graze, where it is infinite, and the change was listed as unresolved.
    """
    case = load_case(SCENE, {"s0.e": "0.4967508313181038"})
    there = find_orbit(case.scene(), {"x_a": 0.046492991, "v_a": -0.64445775}, 2, case=case)
    plan = plan_from(there, *read_span(case, "s0.e", "0.4:0.6"))
    family = plan.family()
    one = plan.start(family)
    z = family.unknowns(np.array([0.045826674, -0.64414805]), there.period, 0.5274591806299982)
    other = node_at(family, z, None, one, 0.1)
    assert (len(one.word), len(other.word), one.index, other.index) == (5, 6, 0, 1)
    (graze,) = inspect(family, one, other)
    assert graze.kind == "grazing" and graze.jump == 1
    assert graze.node.parameter == pytest.approx(GRAZE, abs=1e-9)
    near = load_case(SCENE, {"s0.e": f"{graze.node.parameter - 1e-9!r}"})
    X = graze.node.point.end.X
    beside = {"x_a": X[0] + 1e-7, "v_a": X[1]}  # the graze itself has no derivative
    assert 0 < find_orbit(near.scene(), beside, 2).margin < 1e-10


LOST = {
    8: 2.184256262374388,
    7: 2.1843229669115924,
    6: 2.184666585838982,
}  # by the impacts in front, see below


@pytest.mark.parametrize(
    ("begun", "span", "counts"),
    [
        pytest.param("2.18427 mm", "2.1842:2.18427 mm", (8,), marks=pytest.mark.slow),
        pytest.param("2.1845 mm", "2.184:2.1847 mm", (8, 7, 6), marks=pytest.mark.slow),
    ],
)
def test_a_chatter_that_is_complete_no_more_loses_one_impact_after_the_other(begun, span, counts):
    """A ball thrown up by a table bounces ever less until it is thrown again. Each impact is lost in a graze,
    with a multiplier without bound on the side that has it; the last ones, between which there is no room for
    doubles, are told as one. Known from flights of a ball alone: parabolas and a sine, solved by MINPACK for
    a period with a turn of the gap at zero.
    """
    set_up = {"stops.table.e": "0.2", "base.phase": "0 deg", "base.a": begun, "initial.ball.x": "10 mm"}
    start = orbit(load_case("gallery/ball-on-shaken-table", set_up), period=1)
    branch = continue_branch(start, "base.a", span)
    lost = {branch.spelled(one.before): one.parameter for one in branch.specials if one.kind == "grazing"}
    assert lost["cho"] == pytest.approx(2.184239668, rel=1e-9)
    for count in counts:
        assert lost["i" * count] == pytest.approx(LOST[count], rel=1e-12)


PARAMETRIC = """
name: parametric
bodies: {a: 1 kg}
links:
  s: {between: [a, base], force: "k*d*(1 + q*cos(w*t)) + c*v", k: 100 N/m, c: 2 N s/m, q: 0.2, w: 1 Hz}
stops: {wall: {between: [a, ground], gap: 25 mm, acts: extension, law: rigid, e: 0.6}}
base: {a: 15 mm, omega: 1 Hz}
run: {t_end: 9 s, every: 10 ms}
"""


def test_a_graze_of_an_orbit_that_a_stiffness_in_time_drives():
    """Up to the stop the motion is linear, so its amplitude grows as the base does; windows about the touch
    began with the formulas as they are at the section, not as they are there.
    """
    case = load_case(PARAMETRIC)
    there = orbit(case)
    graze = 15e-3 * 25e-3 / (25e-3 - there.margin)
    branch = continue_branch(there, "base.a", "14.9:25 mm")
    (touch,) = [one for one in branch.specials if one.kind == "grazing"]
    assert touch.parameter == pytest.approx(1e3 * graze, rel=1e-9)
