"""vibsim continue: what it prints, refuses, and keeps when it is interrupted."""

import json

import pytest

from tests.branches.made import orbit_of, parameter
from tests.command_line.made import call, refused, told
from vibsim.results import simulate_to_file
from vibsim.results.simulation import open_result

CASE = ["II-B", "-s", "c=0.03", "-s", "Omega0=5Hz", "-s", "run.t_end=60s"]
NS, FOLD = "II-B c=0.03 captured branch NS", "II-B c=0.03 captured branch fold"


def follow(path, *more, span="4.9:6"):
    return call("continue", *CASE, "--omega0", span, "-o", path, *more)


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    path = tmp_path_factory.mktemp("continue") / "captured.h5"
    return path, follow(path)


def test_a_line_per_special_point(followed):
    path, result = followed
    assert result.exit_code == 0, result.stderr
    lines = [line.split() for line in result.stdout.splitlines()]
    assert lines[0][:7] == ["branch", "II-B:", "orbits", "of", "1", "turn", "over"]
    assert lines[-3][:4] == ["NS1", "neimark-sacker", f"{parameter(NS):.12g}", "Hz"]
    assert lines[-2][:4] == ["F1", "fold", f"{parameter(FOLD):.12g}", "Hz"]
    assert ["index", "check", "holds", "everywhere"] in lines
    info = call("info", path).stdout.splitlines()
    assert info[:-1] == result.stdout.splitlines()[:-1]
    assert "nothing to compute" in follow(path).stdout


def test_a_locus_that_has_its_points_is_left_alone(followed, tmp_path):
    """The same command once more computed another point on each side."""
    words = ["continue", followed[0], "--locus", "F1", "--param", "c=0.02:0.04", "--max-points", "3"]
    first = told(*words, "-o", tmp_path / "folds.h5")
    again = call(*words, "-o", tmp_path / "folds.h5")
    assert "nothing to compute" in again.stdout
    assert again.stdout.splitlines()[:-1] == first.splitlines()[:-1]
    assert open_result(tmp_path / "folds.h5").attrs["points"] == 3


def test_json_lists_the_special_points(followed):
    path, _ = followed
    listed = json.loads(follow(path, "--json").stdout)
    assert listed == json.loads(call("info", "--json", path).stdout)
    torus, fold = listed["special_points"]
    assert torus["kind"] == "neimark-sacker" and fold["kind"] == "fold"
    assert torus["parameter"] == "excitation.Omega0" and listed["unit"] == "Hz"
    assert fold["value"] == pytest.approx(parameter(FOLD), rel=1e-12)
    assert fold["word"] == "brerbrer" and fold["period"] == pytest.approx(0.270682515329, rel=1e-10)
    assert listed["parameter_to"] == fold["value"] and not listed["closed"]


def test_from_a_stored_orbit_and_from_a_run(tmp_path, followed):
    orbit, run = tmp_path / "orbit.h5", tmp_path / "run.h5"
    assert call("orbit", *CASE, "-o", orbit).exit_code == 0
    simulate_to_file(orbit_of("II-B c=0.03 captured n=1 (2 impacts/turn)").case, run)
    for source in (orbit, run):
        result = call("continue", source, "--omega0", "4.9:6", "-o", tmp_path / f"b-{source.name}", "--json")
        assert result.exit_code == 0, result.stderr
        fold = json.loads(result.stdout)["special_points"][-1]
        assert fold["value"] == pytest.approx(parameter(FOLD), rel=1e-12)


@pytest.mark.parametrize(
    ("given", "code", "message"),
    [
        (["continue", *CASE], 2, "give one range to follow: --omega0, --omega, --energy or --param"),
        (["continue", *CASE, "--omega0", "3:9", "--param", "c=0:1"], 2, "give one range to follow"),
        (["continue", *CASE, "--omega0", "3:9:1"], 2, "--omega0: 3:9:1 is not FROM:TO"),
        (["continue", *CASE, "--omega", "3:9"], 2, "--omega: the source of II-B is motor; use --omega0 3:9"),
        (["continue", *CASE, "--omega0", "6:9"], 2, "outside the range 6:9; begin from an orbit within it"),
        (["continue", *CASE, "--param", "c=-1:1"], 2, "coupling.c must be >= 0, got -1 N s/m"),
        (["continue", *CASE, "--param", "cc=0:1"], 2, "--param: cc: unknown key"),
        (["continue", *CASE, "--omega0", "3:9", "-o", "b.txt"], 2, "results are HDF5 files"),
    ],
)
def test_what_is_refused(given, code, message):
    assert message in refused(*given, code=code)


def test_a_branch_is_no_orbit(followed):
    result = call("continue", followed[0], "--omega0", "3:9")
    assert result.exit_code == 2 and "holds a branch; --switch PD1 or --locus NS1" in result.stderr


def test_a_file_that_holds_another_branch_is_kept(followed):
    path, _ = followed
    before = path.read_bytes()
    result = follow(path, span="4.5:6")
    assert result.exit_code == 6 and "holds another branch; kept" in result.stderr
    assert path.read_bytes() == before
