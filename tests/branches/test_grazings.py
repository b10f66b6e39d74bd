"""Grazings, at rigid stops too, and followed in two parameters, against closed forms."""

from math import hypot, pi

import numpy as np
import pytest

from tests.branches.made import KEYS, PERIOD_5, nearest, orbit_of
from tests.branches.test_closed_forms import GRAZING
from tests.command_line.made import call
from vibsim.cases import load_case
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.inspection import inspect
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan, read_locus
from vibsim.orbits.branches.node import node_at
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.search import orbit
from vibsim.physics.parts import GROUND

LAWS = {"elastic": {}, "rigid": {"wall.law": "rigid", "wall.e": "0.8"}}


@pytest.fixture(scope="module")
def branches(tmp_path_factory):
    """Of the linear motion in front of an elastic and a rigid stop, and beyond the graze."""
    folder = tmp_path_factory.mktemp("grazings")
    made = {}
    for law, changes in LAWS.items():
        case = load_case("gallery/bilinear-oscillator", {"drive.A": "0.3 N", **changes})
        out = folder / f"{law}.h5"
        made[law] = continue_branch(case, "drive.A", "0.29:0.4 N", max_points=90, out=out)
    return made


def locus_of(branch, key, span, path=None, label="GR1", most=None):
    plan = locus_plan(branch, label, *read_span(branch.case, key, span))
    return complete(LocusStore(plan, path), most)[0]


def test_a_branch_ends_at_the_graze_of_a_rigid_stop(branches):
    """Its last special point is the graze itself; what the motion does beyond has an infinite multiplier."""
    branch = branches["rigid"]
    graze = branch.special("GR1")
    assert graze.parameter == pytest.approx(GRAZING, rel=1e-14)
    assert (graze.before, graze.after) == ((), (("impact", 0),)) and graze.jump == 0
    assert branch.ends[1].startswith("a rigid stop is grazed: beyond")
    assert np.prod(graze.multipliers).real == pytest.approx(np.exp(-0.02 * 2 * pi / 0.8), rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_grazings_over_amplitude_and_frequency(branches, law):
    """The amplitude of the linear motion is the gap: A = G sqrt((k - m w^2)^2 + (c w)^2)."""
    locus = locus_of(branches[law], "drive.omega", "0.79:0.81 rad/s")
    w = locus["second"]
    assert locus.kind == "grazing" and locus.ends == ("end of the range", "end of the range")
    assert (w[0], w[-1]) == pytest.approx((0.79, 0.81), rel=1e-14)
    np.testing.assert_allclose(locus["parameter"], np.hypot(1 - w**2, 0.02 * w), rtol=1e-12)


def test_grazings_over_the_gap_on_file(branches, tmp_path):
    """Amplitudes in proportion; gone on with, the same bits."""
    whole = locus_of(branches["rigid"], "wall.gap", "0.98:1.02 m", tmp_path / "locus.h5")
    gaps = whole["second"]
    np.testing.assert_allclose(whole["parameter"], gaps * hypot(1 - 0.64, 0.02 * 0.8), rtol=1e-13)
    again = LocusStore(whole.plan, tmp_path / "again.h5")
    part, finished = complete(again, watch=lambda count: count < 3)
    assert not finished and len(part) == 3
    rest, finished = complete(LocusStore(whole.plan, tmp_path / "again.h5"))
    assert finished and rest.points == whole.points == read_locus(tmp_path / "locus.h5").points
    assert call("plot", tmp_path / "locus.h5", "-o", tmp_path / "locus.png").exit_code == 0


MOTOR = """
name: rotor
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 40 N/m, c: 1 N s/m}}
stops: {wall: {between: [m, ground], gap: 20 mm, acts: compression, law: elastic, k: 400 N/m}}
motor: {on: m, m3: 0.1 kg, e: 50 mm, J: 0.001 kg m^2, M0: 0.1 N m, Omega0: 0.7 Hz}
run: {t_end: 60 s, every: 10 ms}
"""


def greatest(case):
    """The greatest displacement of a settled run [m]."""
    run = open_trajectory(case.scene().without_samples(), extremes=([(0, GROUND)], 50.0))
    for _ in run.blocks():
        pass
    return float(run.extremes[1][0])


@pytest.mark.slow
def test_grazings_under_a_motor():
    """The gap is what the machine without the stop swings out to, by runs that know of no locus."""
    case = load_case(MOTOR)
    branch = continue_branch(case, "motor.Omega0", "0.6:1.2 Hz")
    locus = locus_of(branch, "wall.gap", "10:30 mm")
    assert len(locus) > 5
    for i in range(0, len(locus), 4):
        speed = f"{float(locus['parameter'][i])!r} Hz"
        free = case.with_values({"motor.Omega0": speed, "stops.wall.gap": "10 m"})
        assert locus["second"][i] / 1e3 == pytest.approx(greatest(free), rel=1e-9)


@pytest.mark.slow
def test_a_graze_among_other_contacts():
    """The known graze of I-A's orbits of five periods: three other contacts in the word, one stop."""
    branch = continue_branch(orbit_of(PERIOD_5), KEYS["I"], "3.47:3.53 Hz")
    graze = nearest(branch, "grazing", 3.50596783345624)
    locus = locus_of(branch, "c", "0.0009:0.0011", label=graze.label, most=30)
    start = int(np.argmin(abs(locus["second"] - 0.001)))
    assert locus["parameter"][start] == pytest.approx(3.50596783345623924804, rel=1e-13)


@pytest.mark.slow
def test_a_locus_ends_at_the_end_of_the_first_range_too():
    """Amplitudes to 12.4 N, four times those of the branch: the last point was up to a step beyond."""
    case = load_case("gallery/impact-oscillator-coco", {"drive.A": "3.1 N", "drive.omega": "2 rad/s"})
    branch = continue_branch(case, "drive.A", "3:3.1 N")
    locus = locus_of(branch, "drive.omega", "1.99:30 rad/s")
    amplitude, w = locus["parameter"][-1], locus["second"][-1]
    assert amplitude == pytest.approx(12.4, rel=1e-15) and locus.ends[1] == "end of the range"
    assert amplitude == pytest.approx(hypot(1 - w * w, 0.1 * w), rel=1e-12)


@pytest.mark.slow
def test_a_bend_beside_a_graze_is_followed():
    """The drifting capsule's branch bends by 160 degrees within 1e-6 Hz as a contact with its anvil goes. A
    step went over the bend, took the way back for the way on, and told four places that were not resolved.
    """
    branch = continue_branch("gallery/drifting-capsule", "push.omega=reaction.omega", "2:5.1 Hz")
    assert "unresolved" not in {one.kind for one in branch.specials}
    (graze,) = [one for one in branch.specials if one.kind == "grazing" and 2.045 < one.parameter < 2.048]
    assert graze.parameter == pytest.approx(2.0465430544027, rel=1e-11) and graze.jump == 0
    assert len(graze.before) != len(graze.after)


# A step of a branch that leads across a graze of a rigid stop.


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


LOST = {8: 2.184256262374388, 7: 2.1843229669115924, 6: 2.184666585838982}  # by the impacts in front: below


@pytest.mark.slow
@pytest.mark.parametrize(
    ("begun", "span", "counts"),
    [("2.18427 mm", "2.1842:2.18427 mm", (8,)), ("2.1845 mm", "2.184:2.1847 mm", (8, 7, 6))],
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
