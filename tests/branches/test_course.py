"""What pictures draw between the points of a branch, against the same branch followed in short steps."""

from dataclasses import replace

import numpy as np
import pytest

import vibsim
from tests.branches.made import CAPTURED, branch_of, orbit_of
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.correction import Pace
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.interpolant import shift
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.node import Node
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.branches.tracing import FINE, Arc, curve_of, drawn, stretches, trace
from vibsim.orbits.search import orbit
from vibsim.plots.branch_curves import amplitude_of, mean_speed_of, parameter_of, pieces, ranges
from vibsim.plots.branches_over_sweeps import magnitudes_along
from vibsim.plots.load_curves import torque_of

SHORT = Pace(first=0.006, most=0.006)


def followed(start, key, span, pace):
    plan = plan_from(start, *read_span(start.case, key, span))
    return complete(BranchStore(replace(plan, pace=pace)), 2000)[0]


def motor():
    return orbit_of(CAPTURED), "excitation.Omega0", "4.2:6 Hz", mean_speed_of, torque_of


def friction():
    case = load_case("gallery/friction-oscillator", {"floor.static": "1.1", "drive.omega": "0.76 rad/s"})
    return orbit(case), "drive.omega", "0.71:0.8 rad/s", parameter_of, amplitude_of


def farthest(curve, places):
    """The greatest distance of places (m, d) from a polygon (n, d)."""
    starts, sides = curve[:-1], np.diff(curve, axis=0)
    squares = np.maximum((sides**2).sum(axis=1), 1e-300)
    shares = [np.clip(((place - starts) * sides).sum(axis=1) / squares, 0, 1) for place in places]
    feet = [starts + share[:, None] * sides for share in shares]
    distances = [np.linalg.norm(foot - place, axis=1).min() for foot, place in zip(feet, places, strict=True)]
    return max(distances)


@pytest.mark.parametrize("made", [motor, pytest.param(friction, marks=pytest.mark.slow)])
def test_a_curve_lies_where_short_steps_lead(made):
    """To the 1e-4 of the picture that it is drawn to, in both directions; its points alone miss it by more.

    The friction oscillator begins to stick within its range: the curve has a corner there.
    """
    start, key, span, across, up = made()
    branch, fine = (followed(start, key, span, pace) for pace in (Pace(), SHORT))

    def places(one):
        return np.array([(across(one)(p.orbit), up(one)(p.orbit)) for p in one.points])

    size = ranges(places(fine))
    curve = [np.column_stack([piece.x, piece.y]) for piece in pieces(branch, across(branch), up(branch))]
    assert len(branch) < 0.4 * len(fine)
    assert farthest(np.concatenate(curve) / size, places(fine) / size) < 1.5 * FINE
    assert farthest(places(branch) / size, places(fine) / size) > 4 * FINE
    nearer_than_their_polygon(branch, fine)


def nearer_than_their_polygon(branch, fine):
    """Magnitudes of multipliers, which are the more sensitive the steeper they go."""
    line, (points, places) = magnitudes_along(branch), (magnitudes_at(one) for one in (branch, fine))
    size = np.array([np.ptp(places[:, 0]), np.ptp(places[:, 1:])])
    for k in range(1, places.shape[1]):
        drawn_line, polygon, exact = (one[:, [0, k]] / size for one in (line, points, places))
        assert farthest(drawn_line, exact) < 0.5 * farthest(polygon, exact)


def magnitudes_at(branch):
    """The parameter and magnitudes at the points alone."""
    parameter = parameter_of(branch)
    return np.array([(parameter(p.orbit), *np.abs(p.orbit.multipliers)) for p in branch.points])


def test_a_locus_is_drawn_where_its_points_are_found():
    """Followed in steps of a fifth of their length: the others lie on the curve."""
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    plan = locus_plan(branch, "F1", *read_span(branch.case, "c", "0.02:0.04"))
    locus = complete(LocusStore(plan), 9)[0]
    curve = curve_of(locus)
    places = np.column_stack([locus["parameter"], locus["second"]])
    size = np.ptp(places, axis=0)
    assert len(curve) > 1.5 * len(places) and farthest(curve / size, places / size) < 1e-12
    sparse = curve_of(type(locus)(plan, locus.points[::2]))
    assert farthest(sparse / size, places / size) < 2 * FINE < farthest(places[::2] / size, places / size)


def test_an_arc_with_tangents_of_a_circle_is_one():
    """A cubic keeps to a circle of radius 1 within angle^6 / 20000; here that angle is 0.3."""
    angle = 0.3
    start, end = (np.array([np.cos(a), np.sin(a)]) for a in (0.0, angle))
    arc = Arc(start, end, np.array([0.0, 1.0]), -np.array([-np.sin(angle), np.cos(angle)]))  # either way
    radii = [np.linalg.norm(arc(share)) for share in np.linspace(0, 1, 21)]
    assert np.abs(np.array(radii) - 1).max() < angle**6 / 20000


def test_an_arc_without_tangents_of_its_own_is_straight():
    """As where the state on the section jumps; with one alone it is a parabola that has it."""
    start, end, across = np.zeros(2), np.array([1.0, 0.0]), np.array([0.0, 1.0])
    assert not any(Arc(start, end, across, across)(share)[1] for share in (0.2, 0.5, 0.9))
    up = np.array([1.0, 0.1]) / np.hypot(1.0, 0.1)
    assert Arc(start, end, up, across)(1e-6)[1] == pytest.approx(1e-7 / np.hypot(1.0, 0.1), rel=1e-5)


def test_a_curve_is_drawn_through_an_s():
    """The middle of an S lies on its chord."""
    line = drawn(lambda s: s, (0.0, 1.0), lambda s: (s, s * (1 - s) * (1 - 2 * s)), np.ones(2))
    assert len(line) > 20 and np.ptp(line[:, 1]) == pytest.approx(2 * 0.0962250, rel=1e-3)


def test_a_graze_beyond_the_end_of_a_branch_is_not_drawn_into_it():
    """COCO's impact oscillator, A down to the graze, which no step reaches: parameters rise all along."""
    start = orbit(load_case("gallery/impact-oscillator-coco"))
    branch = followed(start, "A", "0.05:1.05 N", Pace())
    fold, graze = branch.special("F1"), branch.special("GR1")
    ends = [(each.one.parameter, each.other.parameter) for each in stretches(branch)]
    assert graze.parameter > fold.parameter and graze.between == (0, 1)
    assert all((one > fold.parameter - 1e-12) and other > fold.parameter - 1e-12 for one, other in ends)
    assert not any(graze.orbit in (each.one, each.other) for each in stretches(branch))


# Orbits of two periods beside a grazing: where they join those of one, and leave them.


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
