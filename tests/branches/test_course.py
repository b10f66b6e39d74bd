"""What pictures draw between the points of a branch, against the same branch followed in short steps."""

from dataclasses import replace

import numpy as np
import pytest

from tests.branches.made import CAPTURED, branch_of, orbit_of
from vibsim.cases import load_case
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.correction import Pace
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.branches.tracing import FINE, Arc, curve_of, drawn, stretches
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
