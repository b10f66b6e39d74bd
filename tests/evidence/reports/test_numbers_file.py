"""The table of numbers on file: measured once, measured again when what it is made of changes."""

import json

import pytest

from vibsim.evidence.reports import measurements
from vibsim.evidence.reports.measurements import NumbersFile


class Measure:
    """Counts how often it is asked."""

    def __init__(self, value=1.5):
        self.value, self.calls = value, 0

    def __call__(self):
        self.calls += 1
        return self.value


def test_a_section_is_measured_once(tmp_path):
    path, measure = tmp_path / "numbers.json", Measure({"a": [1.5, None]})
    assert NumbersFile(path).section("runs", "of this", measure) == {"a": [1.5, None]}
    assert NumbersFile(path).section("runs", "of this", measure) == {"a": [1.5, None]}
    assert measure.calls == 1


def test_a_section_of_something_else_is_measured_again(tmp_path):
    path, measure = tmp_path / "numbers.json", Measure()
    NumbersFile(path).section("runs", {"I-A": "sha"}, measure)
    NumbersFile(path).section("runs", {"I-A": "other"}, measure)
    assert measure.calls == 2


def test_a_section_of_another_version_is_measured_again(tmp_path, monkeypatch):
    path, measure = tmp_path / "numbers.json", Measure()
    NumbersFile(path).section("runs", 1, measure)
    monkeypatch.setattr(measurements, "__version__", "0.0")
    NumbersFile(path).section("runs", 1, measure)
    assert measure.calls == 2


def test_what_was_measured_before_a_failure_is_kept(tmp_path):
    path, measure = tmp_path / "numbers.json", Measure()
    file = NumbersFile(path)
    file.section("facts", 1, measure)
    with pytest.raises(ZeroDivisionError):
        file.section("runs", 2, lambda: 1 / 0)
    assert list(json.loads(path.read_text())) == ["facts"]
    NumbersFile(path).section("facts", 1, measure)
    assert measure.calls == 1


def test_a_planted_number_is_taken_as_it_stands(tmp_path):
    """The verdicts follow from the numbers on file, so that they can be held against others."""
    path = tmp_path / "numbers.json"
    NumbersFile(path).section("runs", 1, Measure(1.5))
    path.write_text(path.read_text().replace("1.5", "2.5"))
    assert NumbersFile(path).section("runs", 1, Measure(1.5)) == 2.5
    assert NumbersFile(path, fresh=True).section("runs", 1, Measure(1.5)) == 1.5


@pytest.mark.parametrize("text", ["no json", "[1, 2]", '{"runs": 3}'])
def test_a_file_that_is_something_else_is_replaced(tmp_path, text):
    path = tmp_path / "numbers.json"
    path.write_text(text)
    assert NumbersFile(path).section("runs", 1, Measure(4)) == 4
    assert json.loads(path.read_text())["runs"]["numbers"] == 4
