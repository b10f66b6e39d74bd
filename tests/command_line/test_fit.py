"""vibsim fit: what it prints, refuses, and keeps when it is interrupted."""

import json

import pytest

from tests.command_line.made import call, refused, told

QUICK = ["--t-end", "12s", "--every", "20ms", "--ensemble", "2", "--candidates", "8", "--fresh", "3"]
WANTED = ["--want", "passes 3 Hz before 6 s", "--want", "settles between 5.2 and 5.6 Hz"]


def fit(path, *more):
    return call("fit", "II-B", *WANTED, *QUICK, "-o", path, *more)


def test_the_ranking_is_printed_and_read_again(tmp_path):
    path = tmp_path / "fit.h5"
    result = fit(path, "--free", "M0=2:10mN.m", "--try", "J=0.002 kg m^2, c=0.002")
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    assert "  statement 1     passes 3 Hz before 6 s" in lines
    assert any(line.split()[:1] == ["best"] for line in lines)
    assert any("J = 0.002 kg m^2, c = 0.002" in line for line in lines)
    assert any(line.endswith("hold  penalty") for line in lines)
    info = call("info", path)
    assert info.exit_code == 0
    assert info.stdout.splitlines()[:-1] == lines[:-1]
    more = call("info", "-v", path).stdout.splitlines()
    assert set(lines[:-1]) < set(more) and any("fit_sha256 = " in line for line in more)


def test_json_has_every_statement_of_every_candidate(tmp_path):
    result = fit(tmp_path / "fit.h5", "--json", "--try", "J=0.002")
    found = json.loads(result.stdout)
    assert [each["origin"] for each in found["ranking"]] == ["as given", "reading"]
    first = found["ranking"][0]["statements"][0]
    assert first["text"] == "passes 3 Hz before 6 s" and first["of"] == 3
    assert first["holds"] == (first["count"] / 3 >= 0.8)
    assert found["complete"] == 1
    again = json.loads(call("info", "--json", tmp_path / "fit.h5").stdout)
    assert again["ranking"] == found["ranking"]


def test_what_a_statement_can_be_about_is_listed():
    result = told("fit", "--list")
    assert any(line.startswith("captured until the end ") for line in result.splitlines())
    listed = json.loads(call("--json", "fit", "--list").stdout)
    assert listed["passes"]["takes"] == "a range of time"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["fit"], "give at least one CASE"),
        (["fit", "II-B", "--free", "J=1:2g.m^2"], "give at least one statement"),
        (["fit", "II-B", "--free", "J"], "is not KEY=FROM:TO, such as J=0.5:20g.m^2"),
        (["fit", "II-B", "-s", "run.t_end=9s", "--t-end", "8s"], "--t-end and --set run.t_end say the same"),
        (["fit", "II-B", "--spread", "x1=1mm", "--spread", "x1=2mm"], "x1 is given twice"),
        (["fit", "II-B", "--free", "Jay=1:2", "--want", "captured"], "free Jay: unknown key"),
        (["fit", "II-B", "--try", "Jay=1", "--want", "captured"], "Jay: unknown key"),
        (["fit", "II-B", "--free", "c=5:1", "--want", "captured"], "a range must rise, got 5 to 1"),
        (["fit", "II-B", "--free", "J=1:2g.m^2", "--want", "captrued"], "did you mean captured?"),
        (["fit", "II-B", "--leave", "J=dear", "--want", "captured"], "is not KEY=PENALTY, such as J=0.05"),
        (
            ["fit", "II-B", "--free", "J=1:2", "--free", "J=1:3", "--want", "captured"],
            "--free: J is given twice",
        ),
        (
            ["fit", "II-B", "--free", "J=1:2g.m^2", "--want", "drifts above 0 m/s over 200 to 400 s"],
            "its span of time is not within the run, 0 to 300 s (run.t_end)",
        ),
        (["fit", "I-A", "--try", "c=1", "--want", "captured"], "capture needs a motor; I-A lacks it"),
    ],
)
def test_usage_errors_say_what_is_wrong(given, message):
    assert message in refused(*given)


def test_ends_that_a_case_does_not_allow_are_named():
    said = refused("fit", "II-B", "--free", "J=-1:2g.m^2", "--want", "captured", code=3)
    assert "--free excitation.J: must be" in said


def test_a_file_of_another_kind_is_file_trouble(tmp_path):
    assert fit(tmp_path / "fit.h5", "--try", "J=0.002").exit_code == 0
    other = fit(tmp_path / "fit.h5", "--try", "J=0.003")
    assert other.exit_code == 6
    assert "holds another fit, of other readings;" in other.stderr
    assert call("run", tmp_path / "fit.h5").exit_code == 6
