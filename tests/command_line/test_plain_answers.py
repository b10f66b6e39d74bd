"""What is printed is what was meant: no empty output, no signed zero, no file that was not judged."""

import json
import math

import pytest

from tests.command_line.made import call
from tests.results.made import short_run
from vibsim.command_line.text import case_lines, metres, seconds


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return short_run("II-B").save(tmp_path_factory.mktemp("answers") / "II-B.h5")


def test_a_run_with_changes_is_not_said_to_be_the_file(file):
    found = call("analyse", file, "-s", "c=0.03", "--what", "impacts")
    assert f"{file} run with c=0.03, not saved" in found.stdout
    assert "run with" not in call("analyse", file, "--what", "impacts").stdout
    read = json.loads(call("analyse", file, "-s", "c=0.03", "--what", "impacts", "--json").stdout)
    assert read["changes"] == {"c": "0.03"}


@pytest.mark.parametrize("window", ["500:600", "2.001:2.002"])
@pytest.mark.parametrize("name", ["out.csv", "out.mat"])
def test_nothing_is_no_export(file, tmp_path, window, name):
    found = call("export", file, "--window", window, "-o", tmp_path / name)
    assert found.exit_code == 2 and f"--window {window}: nothing of" in found.stderr
    assert not list(tmp_path.iterdir())


def test_a_stretch_without_events_has_none(file, tmp_path):
    assert call("export", file, "--events", "--window", "0.1:0.2", "-o", tmp_path / "a.csv").exit_code == 0
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 1


def test_nothing_is_no_picture(file, tmp_path):
    found = call("plot", file, "--window", "2.001:2.0011", "-o", tmp_path / "a.png")
    assert found.exit_code != 0 and "too short" in found.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("tolerance", ["nan", "inf", "-1"])
def test_a_tolerance_is_a_number(file, tolerance):
    found = call("compare", file, file, "--tolerance", tolerance)
    assert found.exit_code == 2 and "--tolerance" in found.stderr


def test_lengths_and_durations_in_words():
    assert [metres(x) for x in (-0.0, 0.0, -2e-6, math.nan)] == ["0 m", "0 m", "-2 um", "nan nm"]
    texts = [seconds(t) for t in (0.0, 1.0, 0.005, 2e-6, 3e-9, 1e-20)]
    assert texts == ["0 s", "1 s", "5 ms", "2 us", "3 ns", "1e-20 s"]
    (span,) = (text for label, text in case_lines(short_run("I-A", "1 ms").case) if label == "span")
    assert span == "1 ms, a sample every 5 ms: 1 sample"
