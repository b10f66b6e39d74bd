"""vibsim edge: what it prints, stores and refuses."""

import json

import pytest

from tests.command_line.made import call, refused, told
from vibsim.results.simulation import open_result

CASE = "gallery/cantilever"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A sweep with both motions of the cantilever, and each of them stored as an orbit."""
    folder = tmp_path_factory.mktemp("edge")
    sweep = folder / "basins.h5"
    axes = ["--param", "tip.x=-4:4/6mm", "--param", "tip.v=-450:450/6mm/s"]
    told("sweep", CASE, *axes, "--section", "0", "--compute", "attractor", "-j", "1", "-o", sweep)
    for name, change in (("clear", "tip.v=0"), ("strikes", "tip.v=400mm/s")):
        path = folder / f"{name}.h5"
        assert call("orbit", CASE, "-s", change, "-o", path).exit_code == 0
    return folder


def test_a_saddle_by_numbers_and_by_orbits_stored_and_continued(files, tmp_path):
    saddle = tmp_path / "saddle.h5"
    shown = told("edge", files / "basins.h5", "--between", "0,1", "-o", saddle)
    lines = {line.split()[0]: line for line in shown.splitlines() if line.strip()}
    assert "period 1 (at x_tip" in lines["between"] and "unstable: 1 multiplier outside" in lines["stability"]
    stored = open_result(saddle)
    assert stored.orbit is not None and stored.attrs["orbit_stable"] == 0
    names = f"{files / 'clear.h5'},{files / 'strikes.h5'}"
    facts = json.loads(call("edge", CASE, "--between", names, "--json").stdout)
    assert facts["multipliers"][0][0] == pytest.approx(stored.orbit["multiplier_real"][0], rel=1e-9)
    assert {end["kind"] for end in facts["sides"]} == {"periodic"} and facts["runs"] > 20
    told("continue", saddle, "--param", "base.omega=12.9:13.1Hz", "-o", tmp_path / "branch.h5")
    assert "exists" in call("edge", files / "basins.h5", "--between", "0,1", "-o", saddle).stderr


@pytest.mark.slow
def test_a_shock_in_one_value_and_in_all(files):
    one = json.loads(call("edge", files / "basins.h5", "--shock", "1", "--along", "tip.v", "--json").stdout)
    every = json.loads(call("edge", files / "basins.h5", "--shock", "1", "--json").stdout)
    assert one["along"] == "v_tip" and one["shock"]["x_tip"] == 0
    assert one["shock"]["v_tip"] > 0 > one["other_way"]
    assert every["size"] < one["size"] == pytest.approx(one["shock"]["v_tip"], rel=1e-12)
    text = call("edge", CASE, "--shock", files / "clear.h5", "--along", "tip.v").stdout
    assert "m/s in v_tip" in text and "ends on" in text


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ([CASE, "--between", "0,1"], 2, "0 is the number of an attractor, which a sweep with"),
        ([CASE, "--between", "0"], 2, "'0' is not A,B"),
        ([CASE], 2, "give one of --between A,B, --shock A and --changes"),
        ([CASE, "--between", "II-B,I-A"], 2, "has no x_tip, v_tip, which the case has"),
        ([CASE, "--between", f"{CASE},{CASE}"], 4, "both starts end on the same attractor"),
        ([CASE, "--between", "a,b", "--along", "tip.v"], 2, "--along is the direction of --shock"),
        ([CASE, "--shock", CASE, "--along", "tip.z"], 2, "no such initial value; this case has tip.x, tip.v"),
        ([CASE, "--changes", "-s", "base.a=1mm"], 2, "--changes reads SWEEP alone"),
        ([CASE, "--shock", CASE, "-o", "x.h5"], 2, "--shock finds no orbit"),
    ],
)
def test_what_cannot_be_asked_for(words, code, message):
    assert message in refused("edge", *words, code=code)


def test_changes_go_with_starts(files):
    done = call("edge", files / "basins.h5", "--between", "0,1", "-s", "base.a=0.6mm")
    assert done.exit_code == 2 and "changes go with starts" in done.stderr


def test_births_and_deaths_are_printed(tmp_path):
    """The stick-slip cycle on a belt ends at 1.836600972207926 m/s (an independent solver's number)."""
    path = tmp_path / "belt.h5"
    words = ["--ensemble", "12", "--spread", "block.x=-2:2m", "--spread", "block.v=0:2m/s", "--section", "0"]
    more = ["--t-end", "300s", "--compute", "attractor", "-j", "1", "-o", path]
    call("sweep", "gallery/belt-oscillator", "--param", "belt.belt=1.75,1.9m/s", *words, *more)
    text = call("edge", path, "--changes").stdout
    assert "dies" in text and "at 1.836600972 m/s: a corner" in text
    (change,) = json.loads(call("edge", path, "--changes", "--json").stdout)["changes"]
    assert change["parameter"] == pytest.approx(1.836600972207926, abs=1e-9) and not change["birth"]


@pytest.mark.parametrize("words", [["--changes"], ["--between", "0,1"], ["--shock", "0"]])
def test_a_sweep_without_attractors_is_refused(words, tmp_path):
    """It says how to make one; no traceback."""
    out = tmp_path / "plain.h5"
    told("sweep", "gallery/van-der-pol", "--param", "damper.mu=1,2 N s/m", "--t-end", "1s", "-o", out)
    assert "this sweep has no attractors (sweep with --compute attractor)" in refused("edge", out, *words)
