"""Bifurcations of the captured orbits of II-B in two parameters, against branches at other values."""

import json

import numpy as np
import pytest

from tests.branches.made import CAPTURED, KEYS, branch_of, orbit_of, parameter
from tests.command_line.made import refused, told
from tests.orbits.truths import TRUTHS
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan, read_locus
from vibsim.orbits.branches.plan import BranchError, read_span
from vibsim.results.simulation import open_result

pytestmark = pytest.mark.slow  # curves in two parameters, followed whole


def plan_of(label, span):
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    return locus_plan(branch, label, *read_span(branch.case, "c", span))


@pytest.fixture(scope="module")
def folds():
    return complete(LocusStore(plan_of("F1", "0.0205:0.032")))[0]


@pytest.fixture(scope="module")
def tori():
    return complete(LocusStore(plan_of("NS1", "0.0205:0.032")))[0]


def branch_at(c):
    """The captured branch at another damping [N s/m], from scratch."""
    case = load_case("II-B", {"c": repr(c), "excitation.Omega0": "5 Hz"})
    start = find_orbit(case.scene(), TRUTHS[CAPTURED].state, 1, case=case)
    return continue_branch(start, KEYS["II"], "4.99:6.2 Hz")


def test_they_begin_at_the_special_points_of_the_branch(folds, tori):
    for locus, name in ((folds, "fold"), (tori, "NS")):
        start = int(np.argmin(abs(locus["second"] - 0.03)))
        assert locus["second"][start] == pytest.approx(0.03, rel=1e-15)
        value = parameter(f"II-B c=0.03 captured branch {name}")
        assert locus["parameter"][start] == pytest.approx(value, rel=1e-11)


def test_they_end_where_another_branch_has_its_special_points(folds, tori):
    branch = branch_at(0.032)
    for locus, label in ((folds, "F1"), (tori, "NS1")):
        assert locus.ends[1] == "end of the range" and locus["second"][-1] == 0.032
        assert locus["parameter"][-1] == pytest.approx(branch.special(label).parameter, rel=1e-11)


def test_the_neimark_sacker_points_end_at_the_fold(folds, tori):
    """Below c = 0.021 N s/m the capture ends in the fold alone: there two multipliers are 1."""
    assert "real axis" in tori.ends[0]
    c, value = tori["second"][0], tori["parameter"][0]
    assert c == pytest.approx(0.02097, abs=2e-5)
    assert np.interp(c, folds["second"], folds["parameter"]) == pytest.approx(value, abs=2e-4)
    outside = folds["index"][folds["second"] > c + 1e-5]
    inside = folds["index"][folds["second"] < c - 1e-5]
    assert (outside == 1).all() and (inside == 0).all() and inside.size


def test_the_critical_multipliers_stay_on_the_circle(folds, tori):
    assert np.abs(folds["multipliers"] - 1).min(axis=1).max() < 1e-8
    assert np.abs(np.abs(tori["multipliers"]) - 1).min(axis=1).max() < 1e-9


def test_on_file_and_gone_on_with(tmp_path, folds):
    path = tmp_path / "locus.h5"
    part, finished = complete(LocusStore(folds.plan, path), watch=lambda count: count < 4)
    assert not finished and len(part) == 4
    rest, finished = complete(LocusStore(folds.plan, path))
    assert finished and rest.points == folds.points
    assert read_locus(path).points == open_result(path).points == folds.points


def test_the_command(tmp_path):
    branch, path = tmp_path / "branch.h5", tmp_path / "l.h5"
    continue_branch(orbit_of(CAPTURED), KEYS["II"], "4.99:6 Hz", out=branch)
    words = ["continue", branch, "--locus", "F1"]
    listed = json.loads(told(*words, "--param", "c=0.0299:0.0301", "-o", path, "--json"))
    assert listed["kind"] == "fold" and listed["keys"] == ["excitation.Omega0", "coupling.c"]
    assert listed["points"][-1][1] == pytest.approx(0.0301, rel=1e-12)
    assert told("info", path).startswith("  locus           II-B: fold F1")
    told("plot", path, "-o", tmp_path / "l.png")
    assert "needs the second parameter: --param KEY=FROM:TO" in refused(*words)
    second = ("--locus", "F1", "--param", "c=0:1")
    assert "II-B is no branch; give the file of one" in refused("continue", "II-B", *second)
    for options in (second, ("--switch", "PD1")):
        said = refused("continue", tmp_path / "none.h5", *options, code=6)
        assert "none.h5: No such file" in said


@pytest.mark.parametrize(
    ("label", "key", "span", "message"),
    [
        ("NS7", "c", "0.02:0.04", "NS7 is not on this branch; its special points are NS1, F1"),
        ("F1", "Omega0", "3:9 Hz", "is the parameter of the branch; a locus needs another"),
        ("F1", "run.tol", "1e-18:1e-10", "no orbit depends on run.tol"),
        ("F1", "c", "0.04:0.05", "the branch is at coupling.c = 0.03 N s/m, outside the range 0.04:0.05"),
    ],
)
def test_what_cannot_be_followed(label, key, span, message):
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    with pytest.raises(BranchError, match=message):
        locus_plan(branch, label, *read_span(branch.case, key, span))
