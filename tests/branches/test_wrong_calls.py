"""Calls of `continue_branch` that cannot be followed, or of which a part would be ignored: clear words."""

import pytest

from vibsim.orbits.branches.branch import SpecialPoint
from vibsim.orbits.branches.continuing import continue_branch, continue_locus
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.locus_result import locus_plan
from vibsim.orbits.branches.plan import BranchError
from vibsim.orbits.search import orbit

CASE = "gallery/friction-oscillator"


@pytest.fixture(scope="module")
def branch():
    return continue_branch(orbit(CASE), "drive.A", "1.4:1.6 N", max_points=4)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"ranges": 3}, "name what is to vary"),
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


def test_why_no_locus_of_branch_points_is_followed(branch, monkeypatch):
    special = SpecialPoint.__new__(SpecialPoint)
    object.__setattr__(special, "kind", "branch point")
    monkeypatch.setattr(type(branch), "special", lambda self, label: special)
    with pytest.raises(BranchError, match=r"BP1 is a branch point.*only a symmetry of the scene"):
        locus_plan(branch, "BP1", ("mass.m",), "kg", (0.5, 2.0))


def test_why_no_locus_of_an_order_is_followed(branch, monkeypatch):
    special = SpecialPoint.__new__(SpecialPoint)
    object.__setattr__(special, "kind", "order")
    monkeypatch.setattr(type(branch), "special", lambda self, label: special)
    with pytest.raises(
        BranchError, match="OR1 is a change of the order of events alone; loci are followed of"
    ):
        locus_plan(branch, "OR1", ("mass.m",), "kg", (0.5, 2.0))
    with pytest.raises(BranchError, match="OR1 is a change of the order of events alone: branches leave"):
        continue_branch(branch, switch="OR1")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((3, {"c": "1:2"}, {"label": "PD1"}), r"a locus needs a branch or the file of one, got 3"),
        (
            (None, {"bodies.mass": (0.5, 2)}, {"label": "ZZ9"}),
            "ZZ9 is not on this branch; its special points are",
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
