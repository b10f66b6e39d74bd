"""The command analyse: verdicts as lines and as JSON, windows, and what is refused."""

import json

import pytest

from tests.command_line.made import call, told
from tests.results.made import short_case, short_run

LABELS = ["run", "judged", "capture", "drift", "impacts", "regime", "frequencies"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("analyse")
    short_run("II-B", "120 s").save(folder / "motor.h5")
    short_run("I-A", "120 s").save(folder / "ideal.h5")
    short_run("I-A", "0.1 s").save(folder / "short.h5")
    return folder


def labels(text):
    """The labels in front of the verdicts."""
    return [line[2:18].strip() for line in text.splitlines() if line.startswith("  ") and line[2] != " "]


def test_a_block_of_verdicts_for_each_file(folder):
    found = told("analyse", folder / "motor.h5", folder / "ideal.h5")
    assert labels(found) == LABELS + [label for label in LABELS if label != "capture"]
    assert "passed: lingered" in found
    assert "at 3.688 Hz from 10.87 to 23.09 s, near half bilinear 3.685 Hz" in found
    assert "which ends beyond the trust horizon" in found
    assert "periodic, period 5" in found


def test_a_case_is_run_first_and_values_can_be_changed(folder, here):
    words = ("analyse", "-s", "c=0.03 N s/m", "-s", "run.t_end=120 s", "--what", "capture")
    for source in ("II-B", folder / "motor.h5"):
        found = call(*words, source)
        assert "captured: held to the end" in found.stdout
        assert labels(found.stdout) == ["run", "capture"]
    assert list(here.iterdir()) == []


def test_json_has_every_number(folder):
    found = json.loads(call("analyse", folder / "motor.h5", "--json").stdout)
    assert found["file"] == str(folder / "motor.h5")
    assert found["case"] == "II-B"
    assert found["capture"]["verdict"] == "passed"
    assert found["capture"]["holds"][0]["delay"] == pytest.approx(10.6, abs=0.1)
    assert found["drift"]["half_width"] > 0
    assert sum(found["impacts"]["impact_counts"].values()) == found["impacts"]["cycles"]
    assert found["regime"]["span"]["trust_horizon"] < 120
    assert found["frequencies"]["lines"][0].keys() == {"hz", "amplitude", "order"}
    files = (folder / "motor.h5", folder / "ideal.h5")
    lines = call("analyse", *files, "--what", "impacts", "--json").stdout.splitlines()
    assert [json.loads(line)["case"] for line in lines] == ["II-B", "I-A"]


@pytest.mark.parametrize(
    ("options", "steady"),
    [
        ((), (60, 120)),
        (("--discard", "100s"), (100, 120)),
        (("--window", "20:80"), (20, 80)),
        (("--window", "20:80", "--discard", "50%"), (50, 80)),
        (("--window", "20:", "--discard", "0.25"), (45, 120)),
    ],
)
def test_windows_and_transients(folder, options, steady):
    found = json.loads(call("analyse", folder / "ideal.h5", "--json", *options).stdout)
    assert (found["steady"]["begin"], found["steady"]["end"]) == steady
    assert found["regime"]["span"] == found["steady"]


def test_verbose_lists_holds_and_words(folder):
    found = call("analyse", folder / "motor.h5", "-v")
    assert "times a free run-up" in found.stdout
    assert "words" in labels(found.stdout)


def test_too_short_a_run_is_undecided_and_no_failure(folder):
    found = told("analyse", folder / "short.h5")
    assert found.count("undecided") == 4


def test_nothing_is_printed_when_quiet(folder):
    assert call("analyse", folder / "motor.h5", "-q").output == ""


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [(["motor.h5", "--window", "200:300"], 2, "motor.h5: the window 200:300 s lies outside the run"),
     (["motor.h5", "--window", "20:10"], 2, "is not A:B with A < B"),
     (["motor.h5", "--discard", "200s"], 2, "leaves nothing of 0 to 120 s"),
     (["motor.h5", "--discard", "4"], 2, "a time needs its unit"),
     (["motor.h5", "--what", "drfit"], 2, "'drfit': did you mean drift?"),
     (["motor.h5", "--what", "xyzzy"], 2, "allowed: capture, drift, impacts, regime, frequencies"),
     (["motor.h5", "--what", ","], 2, "allowed: capture"), (["missing.h5"], 6, "missing.h5: No such file"),
     (["text.h5"], 6, "text.h5: is not an HDF5 file"),
     (["sweep.h5"], 6, "sweep.h5: holds no single run; analyse takes runs and cases"),
     (["motor.h5", "missing.h5"], 6, "missing.h5"), (["II-X"], 3, "II-X: is no shipped case"),
     (["II-B", "-s", "cc=1"], 3, "cc"), ([], 2, "Missing argument")],
)  # fmt: skip
def test_what_is_refused(folder, monkeypatch, words, code, message):
    monkeypatch.chdir(folder)
    (folder / "text.h5").write_text("no HDF5")
    if "sweep.h5" in words and not (folder / "sweep.h5").exists():
        import vibsim

        vibsim.sweep(short_case("II-B", "2 s"), {"excitation.Omega0": "3:4:1 Hz"}, out=folder / "sweep.h5")
    found = call("analyse", *words)
    assert found.exit_code == code
    assert message in found.stderr
    assert found.stdout == ""


def test_a_verdict_asked_for_that_there_is_none_of_is_said(folder):
    lines = call("analyse", "gallery/van-der-pol", "-s", "run.t_end=1s", "--what", "capture,impacts").stdout
    assert "capture         none: the case has no motor" in lines
    assert "impacts         none: the case has no stop" in lines
