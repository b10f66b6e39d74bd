"""Ranges of branches, calls that are refused, and curves that close."""

from math import exp, pi

import numpy as np
import pytest

import vibsim
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.branch import SpecialPoint
from vibsim.orbits.branches.continuing import continue_branch, continue_locus
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import BranchError, read_span
from vibsim.orbits.branches.walk import landed
from vibsim.orbits.search import orbit

COCO, PERIOD = "gallery/impact-oscillator-coco", 2 * pi  # [s]; damping 0.1 N s/m of 1 kg, restitution 0.8
RATIO = 1.1  # of the frequencies: at 1 the impact without damping is where the section is


@pytest.mark.parametrize(
    ("key", "span", "end", "bound", "product"),
    [("wall.e", "0.7:1", -1, 1.0, exp(-0.1 * PERIOD / RATIO)), ("spring.c", "0:0.12 N s/m", 0, 0.0, 0.8**2)],
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


# Calls of `continue_branch` that cannot be followed, or of which a part would be ignored: clear words.


CASE = "gallery/friction-oscillator"


@pytest.fixture(scope="module")
def branch():
    return continue_branch(orbit(CASE), "drive.A", "1.4:1.6 N", max_points=4)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"ranges": 3}, "name what is to vary"),
        ({"ranges": "drive.A", "span": 3}, "a range is a text"),
        ({"ranges": "drive.A", "span": (3, "x", 4)}, "a range is a text"),
        ({"energy": 3}, r'a range is a text such as "0\.01:1 J", \(0\.01, 1\)'),
        ({"ranges": "drive.A", "span": "1.4:1.6 N", "out": 3}, "out is the name of a file"),
        ({"switch": "PD1", "ranges": "drive.A"}, "leave ranges out"),
        ({"switch": "PD1", "ranges": {"drive.A": (1, 2)}}, "leave ranges and span out"),
        ({"switch": "PD1", "energy": "1:2 J"}, "leave energy out"),
        ({"energy": "1:2 J", "span": (1, 2)}, "leave span out"),
        ({"switch": "PD1"}, r"switch needs a branch or the file of one, got <Orbit [^\n]*$"),
    ],
)
def test_of_an_orbit(arguments, words):
    with pytest.raises(BranchError, match=words):
        continue_branch(orbit(CASE), **arguments)


def test_a_branch_is_no_orbit(branch):
    with pytest.raises(BranchError, match="a branch is no orbit"):
        continue_branch(branch, "drive.A", "1.4:1.6 N")


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("branch point", "XX1 is a branch point.*only a symmetry of the scene"),
        ("order", "XX1 is a change of the order of events alone; loci are followed of"),
    ],
)
def test_why_no_locus_is_followed(branch, kind, words, monkeypatch):
    special = SpecialPoint.__new__(SpecialPoint)
    object.__setattr__(special, "kind", kind)
    monkeypatch.setattr(type(branch), "special", lambda self, label: special)
    with pytest.raises(BranchError, match=words):
        locus_plan(branch, "XX1", ("mass.m",), "kg", (0.5, 2.0))
    if kind == "order":
        with pytest.raises(BranchError, match="XX1 is a change of the order of events alone: branches leave"):
            continue_branch(branch, switch="XX1")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((3, {"c": "1:2"}, {"label": "PD1"}), r"a locus needs a branch or the file of one, got 3"),
        (
            (None, {"bodies.mass": (0.5, 2)}, {"label": "ZZ9"}),
            "ZZ9 is not on this branch; its special points",
        ),
        ((None, {"c": None}, {"label": "PD1"}), r'a range is a text such as "3:9 Hz"'),
        ((None, {"": "1:2"}, {"label": "PD1"}), "name what is to vary"),
        ((None, {"bodies.mass": (0.5, 2)}, {"label": "PD1", "out": 3}), "out is the name of a file"),
        ((None, {"bodies.mass": (0.5, 2)}, {"label": "PD1", "max_points": 1}), "max_points must be"),
    ],
)
def test_of_a_locus(branch, arguments, words):
    start, ranges, options = arguments
    with pytest.raises(ValueError, match=words):
        continue_locus(branch if start is None else start, ranges, **options)


def test_what_is_not_found_is_a_branch_error(branch, monkeypatch):
    def lost(*_):
        raise ContinuationError("Newton's method came to no end")

    monkeypatch.setattr("vibsim.orbits.branches.branch.trace", lost)
    with pytest.raises(BranchError, match="Newton's method came to no end"):
        continue_branch(orbit(CASE), "drive.A", "1.4:1.6 N")


# Branches that close: orbits of the paper's machine that no other branch leads to.


def test_the_plateau_at_three_quarters_is_an_isola():
    """II-B at c = 0.001 N s/m: three turns, four impacts. Once round, the orbits begin a turn later."""
    start = orbit(load_case("II-B"), {"c": "0.001", "excitation.Omega0": "5.9 Hz"})
    assert start.n == 3 and start.spelled.count("b") == 4
    branch = continue_branch(start, "excitation.Omega0", "5:9 Hz", max_points=400)
    assert branch.closed and branch.ends == ("closed", "closed")
    assert abs(branch["parameter"][-1] - 5.9) < 1e-8
    assert abs(branch["period"][-1] / branch["period"][0] - 1) < 1e-9
    once = branch.plan.family().map(branch["parameter"][0]).of(1)
    X, images = np.array(branch.points[0].orbit.state), []
    for _ in range(3):
        images.append(X)
        X = landed(once, X).image
    last = np.array(branch.points[-1].orbit.state)
    assert min(np.abs(last - image).max() for image in images) < 1e-6
    assert 5.9423 < branch["parameter"].max() < 5.9424 and 5.2298 < branch["parameter"].min() < 5.2299


# Events that cross the section: the orbits go on, though the state on the section has a kink there.


def test_a_stick_that_comes_to_the_section():
    """PWSDDE-cont's friction demo, slowly driven: at 0.3439 rad/s a stick begins at phase 0 of the force, and
    from there on the velocity on the section is exactly 0.
    """
    case = load_case("gallery/friction-oscillator", {"drive.omega": "0.37 rad/s"})
    branch = continue_branch(case, "drive.omega", "0.33:0.37 rad/s")
    assert branch.ends == ("end of the range", "end of the range") and branch.specials == []
    at_rest = branch["v_mass"] == 0
    first = branch["parameter"][at_rest].max()
    assert at_rest.any() and np.all(branch["v_mass"][branch["parameter"] > first] > 0)
    assert 0.3438 < first < branch["parameter"][~at_rest].min() < 0.344
    assert set(branch["word"]) == {"susu"} and branch["residual"].max() < 1e-12


def test_contacts_with_damped_stops_pass_the_section():
    """The velocity has a kink where a contact begins, which Newton's method did not get across: the branch of
    the impact damper ended where one came to the section, at 0.97005 and at 1.32668 Hz.
    """
    branch = continue_branch("gallery/impact-damper", "drive.omega", "0.95:1.35 Hz")
    assert branch["parameter"].min() == pytest.approx(0.95, rel=1e-14)
    fold = next(one for one in branch.specials if one.kind == "fold")
    assert fold.parameter > 1.327
    changes = np.diff(branch["index"])
    for special in branch.specials:
        changes[special.between[0]] -= special.jump
    assert not changes.any()
