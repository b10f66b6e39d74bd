"""Branches of one mass before a stop, against closed forms: grazing, and how maps change there."""

from dataclasses import replace
from math import hypot, pi

import numpy as np
import pytest

import vibsim
from vibsim.cases import load_case
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.correction import Pace
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.interpolant import MovedFamily, quiet_share
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.newton import solve

BILINEAR = """
name: bilinear
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m, c: 0.02 N s/m}}
stops: {wall: {between: [m, ground], gap: 1 m, acts: compression, law: elastic, k: 29 N/m}}
forces: {drive: {on: m, A: 0.3 N, omega: 0.8 rad/s}}
run: {t_end: 2000 s, every: 0.5 s}
"""
GRAZING = hypot(1 - 0.64, 0.02 * 0.8)  # amplitude at which the linear motion just reaches the stop: V12 [N]
FORCED = 0.9 * 0.64 / 1.26  # PWSDDE-cont's demo: there the motion of period 2 is seen [N]


@pytest.fixture(scope="module")
def branch(tmp_path_factory):
    path = tmp_path_factory.mktemp("bilinear") / "bilinear.yaml"
    path.write_text(BILINEAR)
    return continue_branch(load_case(str(path)), "A", "0.25:0.6 N")


def test_it_grazes_where_the_linear_motion_reaches_the_stop(branch):
    special = branch.special("GR1")
    assert special.kind == "grazing" and special.parameter == pytest.approx(GRAZING, rel=1e-13)
    assert special.before == () and len(special.after) == 2 and special.jump == 0


def test_multipliers_without_contact_are_those_of_the_oscillator(branch):
    """det = exp(-c T), below the grazing the same for all amplitudes."""
    linear = branch["multipliers"][branch["parameter"] < GRAZING]
    assert len(linear) > 3
    np.testing.assert_allclose(np.prod(linear, axis=1), np.exp(-0.02 * 2 * np.pi / 0.8), rtol=1e-12)


def test_the_period_1_orbit_is_unstable_beside_the_period_2_one(branch):
    """V12: one impact in two periods, in at 1.073267857664968 m/s by an independent solver.

    It is stable, and lies on the branch that leaves the doubling behind the grazing, beside an unstable orbit
    of one period.
    """
    at = int(np.argmin(abs(branch["parameter"] - FORCED)))
    assert branch["index"][at] == 1 and branch["multipliers"][at][0].real < -1
    doubled = continue_branch(branch, switch="PD1", max_points=60)
    near = int(np.argmin(abs(doubled["parameter"] - FORCED)))
    start = doubled.points[near].orbit
    orbit = solve(doubled.plan.family().map(FORCED), np.array(start.state)).end
    assert doubled.plan.n == 2 and doubled["stable"][near]
    assert [kind for kind, _ in orbit.events] in (
        ["contact_begin", "contact_end"],
        ["contact_end", "contact_begin"],
    )
    begin = [kind for kind, _ in orbit.carried.events].index("contact_begin")
    assert abs(orbit.carried.states[begin, 1]) == pytest.approx(1.073267857664968, rel=1e-12)


def test_the_map_changes_like_the_root_of_the_distance(branch):
    """An elastic stop has a 3/2 map at a grazing: its derivative leaves that without contact like d^0.5."""
    family = branch.plan.family()
    start = branch.special("GR1")
    distances = np.geomspace(1e-9, 1e-5, 9)
    traces = [trace_at(family, start, GRAZING + d) for d in distances]
    free = trace_at(family, start, GRAZING - 1e-6)
    slope = np.polyfit(np.log(distances), np.log(np.abs(np.array(traces) - free)), 1)[0]
    assert slope == pytest.approx(0.5, abs=0.02)


def trace_at(family, special, amplitude):
    """Trace of the derivative of the map at the orbit of an amplitude [N]."""
    return float(np.trace(solve(family.map(amplitude), np.array(special.orbit.state)).end.derivative))


def test_the_fold_of_budd_and_dux():
    """V13: one impact in two periods at a rigid stop; its closed form has a double root at the fold."""
    case = load_case("gallery/impact-oscillator")
    found = continue_branch(case, "stops.wall.gap", "0:0.4 m", max_points=250)
    fold = found.special("F1")
    assert found.plan.n == 2 and fold.kind == "fold"
    assert fold.parameter == pytest.approx(0.34514712445281, rel=1e-13)
    products = np.prod(found["multipliers"], axis=1)
    flat = np.abs(found["multipliers"]).max(axis=1) < 10
    np.testing.assert_allclose(products[flat], 0.64, rtol=1e-11)  # e^2: nothing else takes energy


@pytest.fixture(scope="module")
def coco():
    return continue_branch(load_case("gallery/impact-oscillator-coco"), "A", "0.05:1.1 N")


def test_a_branch_ends_where_a_rigid_stop_is_grazed(coco):
    """V14: the motion with an impact ends in the grazing at A = 0.1, behind a fold 3e-5 below.

    On the branch the root of the map balances a linear term: the depth goes with the square of the distance,
    and the multiplier with 1 / sqrt(depth), so with 1 / distance.
    """
    assert coco.ends[0] == "a multiplier grows without bound: a rigid stop is grazed near by"
    assert coco["parameter"][0] == pytest.approx(0.1, abs=5e-6)
    graze = coco.special("GR1")
    assert graze.parameter == pytest.approx(0.1, rel=1e-14)
    assert (graze.before, graze.after) == ((), (("impact", 0),))
    assert graze.orbit.state == pytest.approx((0.0, 1.0), abs=1e-13)
    behind = coco.points[1].orbit
    start = {"state": behind.state, "period": behind.period, "parameter": behind.parameter}
    fine = BranchStore(replace(coco.plan, pace=Pace(1e-4, 1e-9, 1e-4), span=(0.09999, 0.1), **start))
    finely, _ = complete(fine, 80)
    largest = np.abs(finely["multipliers"]).max(axis=1)
    near = largest > 50
    slope = np.polyfit(np.log(0.1 - finely["parameter"][near]), np.log(largest[near]), 1)[0]
    assert near.sum() > 4 and slope == pytest.approx(-1, abs=0.05)


def test_a_rigid_stop_makes_a_square_root(coco):
    """Nordmark's: beside the grazing orbit x = sin t the derivative goes like depth^-0.5."""
    of = coco.plan.family().map(0.1)
    depths = np.geomspace(1e-9, 1e-5, 9)
    sizes = [np.linalg.norm(of(np.array([0.0, 1.0 + depth])).derivative) for depth in depths]
    slope = np.polyfit(np.log(depths), np.log(sizes), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.02)


@pytest.fixture(scope="module")
def bounces():
    return continue_branch(load_case("gallery/ball-on-shaken-table"), "base.a", "0.3:1.2 mm")


def test_a_ball_on_a_shaken_table(bounces):
    """V15: one bounce a period doubles where a w^2/g = sqrt(b^2 + (2 (1 + e^2) / (1 + e)^2)^2).

    b = pi (1 - e)/(1 + e). At a = 2 b g/w^2 the bounce passes the section, at the phase of 60 degrees; the
    orbits are born in a fold at a = b g/w^2, where the table throws with all its speed.
    """
    born = pi * (1 - 0.8) / (1 + 0.8)
    assert bounces.special("PD1").parameter == pytest.approx(hypot(born, 2 * 1.64 / 1.8**2), rel=1e-12)
    assert bounces.special("F1").parameter == pytest.approx(born, rel=1e-13)
    assert [one.kind for one in bounces.specials] == ["fold", "doubling"]
    assert bounces.ends == ("end of the range", "end of the range")
    v = bounces["v_ball"]
    jump = int(np.argmax(np.abs(np.diff(v))))  # the velocity is reversed where the bounce passes the section
    assert (
        bounces["parameter"][jump] < 2 * born < bounces["parameter"][jump + 1] and v[jump] > 0 > v[jump + 1]
    )
    assert {one.orbit.word for one in bounces.points} == {(("impact", 0),)}
    assert (np.diff(bounces["arclength"]) > 0).all()


def test_orbits_within_chaos_are_followed_with_multipliers_of_any_size():
    """Beyond 200 a multiplier may be that of a graze, and a graze is looked for; here there is none. Each
    bounce takes areas by e^2, so the two multipliers of four bounces multiply to e^8.
    """
    once = continue_branch(load_case("gallery/ball-on-shaken-table"), "base.a", "0.7:2.4 mm")
    twice = continue_branch(once, switch="PD1")
    four = continue_branch(twice, switch="PD1")
    assert four.ends == ("leaves another branch", "end of the range")
    assert four["parameter"].max() == 2.4 and abs(four["multipliers"]).max() > 500
    np.testing.assert_allclose(np.prod(four["multipliers"], axis=1).real, 0.8**8, rtol=1e-9)


def test_over_an_impact_on_the_section_it_goes_on_where_it_was_stopped(bounces, tmp_path):
    path = tmp_path / "bounces.h5"
    jump = int(np.argmax(np.abs(np.diff(bounces["v_ball"]))))
    forwards = sum(point.way > 0 for point in bounces.points)
    at = forwards + bounces.points[jump].number  # points there are when the impact has just been passed
    part, done = complete(BranchStore(bounces.plan, path), 5000, watch=lambda count, _: count < at)
    assert not done and len(part) == at
    rest, _ = complete(BranchStore(bounces.plan, path), 5000)
    assert rest.points == bounces.points and rest.specials == bounces.specials


@pytest.mark.parametrize("name", ["I-C", "II-B"])
def test_orbits_on_a_section_at_another_phase(name):
    """There and back the same orbit, with the same multipliers on both sections."""
    orbit = vibsim.orbit(name)
    key = {"I-C": "omega", "II-B": "Omega0"}[name]
    plan = plan_from(orbit, *read_span(orbit.case, key, "1:10 Hz"))
    family = plan.family()
    node = plan.start(family)
    moved = MovedFamily(family, node, quiet_share(node))
    there = moved.start
    np.testing.assert_allclose(there.multipliers, node.multipliers, atol=1e-9)
    np.testing.assert_allclose(moved.given_back(there).z, node.z, atol=1e-11)
