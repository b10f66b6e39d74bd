"""Branches of one mass before a stop, against closed forms: grazing, and how maps change there."""

import re
from dataclasses import replace
from functools import cache
from math import hypot, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import vibsim
from tests.branches.made import free_frequency, machine_rates
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.correction import Pace
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.interpolant import MovedFamily, quiet_share
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.coordinates import case_on_orbit
from vibsim.orbits.newton import solve

GRAZING = hypot(1 - 0.64, 0.02 * 0.8)  # amplitude at which the linear motion just reaches the stop: V12 [N]
FORCED = 0.9 * 0.64 / 1.26  # PWSDDE-cont's demo: there the motion of period 2 is seen [N]


@pytest.fixture(scope="module")
def branch():
    start = load_case("gallery/bilinear-oscillator", {"drive.A": "0.3 N"})
    return continue_branch(start, "drive.A", "0.25:0.6 N")


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
    assert sorted(kind for kind, _ in orbit.events) == ["contact_begin", "contact_end"]
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
    found = continue_branch("gallery/impact-oscillator", "stops.wall.gap", "0:0.4 m", max_points=250)
    fold = found.special("F1")
    assert found.plan.n == 2 and fold.kind == "fold"
    assert fold.parameter == pytest.approx(0.34514712445281, rel=1e-13)
    flat = np.abs(found["multipliers"]).max(axis=1) < 10
    products = np.prod(found["multipliers"][flat], axis=1)
    np.testing.assert_allclose(products, 0.64, rtol=1e-11)  # e^2: nothing else takes energy


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
    v, a = bounces["v_ball"], bounces["parameter"]
    jump = int(np.argmax(np.abs(np.diff(v))))  # the velocity is reversed where the bounce passes the section
    assert a[jump] < 2 * born < a[jump + 1] and v[jump] > 0 > v[jump + 1]
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


# The impact pair: its symmetric motion, where that loses its symmetry, and the motions that leave there. A
# ball strikes each wall of a box once in a period, with the speed u between them; X = A sin(w t) is the
# box, b half of the play, e the restitution, tau = pi / w a flight. The linearised half period from behind
# a blow (dt, dv) to behind the next one, mirrored, has the trace 2 e - X'' tau (1 + e)^2 / (2 u) and the
# determinant e^2, with X'' = w^2 (pi u / (2 w) - b) at the blow. Symmetry is lost where one of its
# multipliers is -1: there X'' = 2 u / tau, and A = b sqrt((2 / pi)^2 + ((1 - e) / (1 + e))^2) / (pi / 2 - 2
# / pi).


W, B, E = 10 * pi, 10.0, 0.7  # [rad/s], [mm]
TAU, RATIO = pi / W, (1 - E) / (1 + E)
BROKEN = B * sqrt((2 / pi) ** 2 + RATIO**2) / (pi / 2 - 2 / pi)  # [mm]


@pytest.fixture(scope="module")
def symmetric():
    return vibsim.continue_branch("gallery/impact-pair", "base.a", "4:9 mm")


@pytest.fixture(scope="module")
def broken(symmetric):
    return vibsim.continue_branch(symmetric, switch="BP1")


def half_period(amplitude):
    """Trace of the mirrored half period at an amplitude of the box [mm]."""
    square = (pi / (2 * W)) ** 2 + (RATIO / W) ** 2
    u = (pi * B / W + sqrt((pi * B / W) ** 2 - 4 * square * (B**2 - amplitude**2))) / (2 * square)
    return 2 * E - W**2 * (pi * u / (2 * W) - B) * TAU * (1 + E) ** 2 / (2 * u)


def test_it_loses_its_symmetry_where_mechanics_says(symmetric):
    (special,) = symmetric.specials
    assert special.kind == "branch point" and special.jump == 1
    assert special.parameter == pytest.approx(BROKEN, rel=1e-12)


def test_its_multipliers(symmetric):
    """Those of the half period squared: trace t^2 - 2 e^2, product e^4."""
    traces = np.array([half_period(amplitude) for amplitude in symmetric["parameter"]])
    sums, products = (of(symmetric["multipliers"], axis=1).real for of in (np.sum, np.prod))
    np.testing.assert_allclose(sums, traces**2 - 2 * E**2, rtol=0, atol=1e-11)
    np.testing.assert_allclose(products, E**4, rtol=1e-11)


def test_beyond_it_one_flight_is_longer(broken):
    """The branch begins at the special point, stable, towards larger amplitudes, and its flights part."""
    assert broken["parameter"][0] == pytest.approx(BROKEN, rel=1e-4) and broken["parameter"][0] > BROKEN
    assert broken["stable"].all() and broken["parameter"][-1] == pytest.approx(9.0, rel=1e-14)
    np.testing.assert_allclose(np.prod(broken["multipliers"], axis=1).real, E**4, rtol=1e-10)
    family, last = broken.plan.family(), broken.points[-1]
    carried = family(np.array(last.unknowns)).end.carried
    blows = [t for (kind, _), t in zip(carried.events, carried.times, strict=True) if kind == "impact"]
    assert len(blows) == 2 and abs(blows[1] - blows[0] - TAU) > 0.1 * TAU


def test_seen_from_a_prong_it_is_a_branch_point():
    """The branch of unequal flights turns round there, among its own mirror images, with a multiplier that
    touches 1: that was listed as a fold and a branch point side by side.
    """
    orbit = vibsim.orbit("gallery/impact-pair", {"base.a": "7.6 mm", "initial.ball.v": "0.25 m/s"})
    branch = vibsim.continue_branch(orbit, "base.a", "7:8 mm")
    (special,) = branch.specials
    assert special.kind == "branch point" and special.jump == 0
    assert special.parameter == pytest.approx(BROKEN, rel=1e-11)
    assert dict(branch.lines())["index check"] == "holds everywhere"
    assert dict(branch.lines())["ends"] == "end of the range"
    np.testing.assert_allclose(branch["parameter"][[0, -1]], 8.0, rtol=1e-14)
    back = vibsim.continue_branch(branch, switch=special.label)
    (crossed,) = back.specials  # the branch goes through there, and is followed both ways
    assert crossed.kind == "branch point" and abs(crossed.jump) == 1
    assert crossed.parameter == pytest.approx(BROKEN, rel=1e-12)
    np.testing.assert_allclose(back["parameter"][[0, -1]], [7.0, 8.0], rtol=1e-14)
    sums = np.sum(back["multipliers"], axis=1).real
    np.testing.assert_allclose(sums, [half_period(a) ** 2 - 2 * E**2 for a in back["parameter"]], atol=1e-9)


# The table of docs/branches.md on the inertia of the rotor: every number of it, computed anew.


PAGE = Path(__file__).parents[2] / "docs" / "branches.md"
STARTS = {  # turns: x1, v1, v2, phidot near the stable orbit at c = 0.03 N s/m, whose x2 is 0
    1: (0.0506539, 0.746678, -0.0819032, 22.164),
    2: (0.0204283, 0.890209, -0.0985671, 32.192),
    3: (0.0226424, -0.842419, 0.0946212, 38.0079),
}
M1 = 0.297 + 0.03  # with the unbalanced mass [kg]
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
    share, (w1, w2) = int(over) / int(under), machine_rates(M1)
    bilinear = share * w1 * w2 / (w1 + w2) / pi
    assert 1e3 * a == rounded(amplitude) and share * free_frequency(a, m1=M1) == rounded(free)
    assert bilinear == rounded(fraction)
    assert share * free_frequency(a, m1=M1) < bilinear < speed
