"""Cases changed and written out again: replace, to_yaml, and the commented file of `vibsim new`."""

from pathlib import Path

import pytest

import vibsim
from tests.command_line.made import call
from vibsim.cases import gallery_case_names, hard_case_names, shipped_case_names
from vibsim.cases.case import load_case_text
from vibsim.command_line.commands.new import commented_text

NAMES = [*shipped_case_names(), *gallery_case_names(), *hard_case_names()]


@pytest.mark.parametrize("name", NAMES)
def test_what_is_written_reads_back_to_the_same_case(name):
    case = vibsim.load_case(name)
    again = load_case_text(case.to_yaml())
    assert again.sha256 == case.sha256
    assert (again.name, again.title, again.values) == (case.name, case.title, case.values)
    assert load_case_text(commented_text(case, "x.yaml")).sha256 == case.sha256


@pytest.mark.parametrize("name", ["II-B", "I-A-eq211", "gallery/drifting-capsule", "gallery/pile-driver"])
def test_changed_values_are_written(name):
    case = vibsim.load_case(name)
    changed = case.replace({"run.t_end": "1/3 min"}, every="7 ms")
    assert str(case.quantity("run.t_end")) != "1/3 min" and changed.sha256 != case.sha256
    again = load_case_text(changed.to_yaml())
    assert again.sha256 == changed.sha256 and str(again.quantity("run.every")) == "7 ms"
    assert changed.text == case.text


def test_a_case_that_extends_another_is_written_in_full(tmp_path):
    (tmp_path / "mine.yaml").write_text("extends: II-B\ncoupling: {c: 0.03 N s/m}\n")
    case = vibsim.load_case(tmp_path / "mine.yaml")
    assert "extends" not in case.to_yaml() and load_case_text(case.to_yaml()).sha256 == case.sha256


def test_replace_refuses_what_a_file_may_not_say():
    case = vibsim.load_case("II-B")
    with pytest.raises(vibsim.CaseError, match="did you mean"):
        case.replace(Omega="6 Hz")
    with pytest.raises(vibsim.CaseError, match="must be > 0, got -1 Hz"):
        case.replace(Omega0="-1 Hz")


def test_a_case_shows_itself_in_a_line():
    assert repr(vibsim.load_case("II-B")) == "<Case II-B: 2 bodies, 1 stop, source motor at 5.5 Hz, 300 s>"
    assert repr(vibsim.load_case("gallery/stack-of-blocks")).startswith("<Case stack-of-blocks: ")


def test_new_begins_a_case_that_is_right(here):
    done = call("new", "capsule")
    assert (done.exit_code, done.stderr) == (0, "")
    assert done.stdout == "capsule.yaml written; vibsim check capsule.yaml says whether it is right\n"
    assert call("check", "capsule.yaml").exit_code == 0
    case = vibsim.load_case("capsule.yaml")
    assert case.sha256 == vibsim.load_case("gallery/drifting-capsule").sha256 and case.name == "capsule"
    text = Path("capsule.yaml").read_text()
    assert "# e: 0.8" in text and "coefficient of restitution" in text


def test_the_table_of_cases_has_frequencies_of_six_digits():
    table = call("cases").stdout
    assert "54.7723 rad/s" in table and "54.772255750516614" not in table
    assert "5.5 Hz " in table and "constant  - " in table


def test_new_tells_what_keys_mean_to_the_end(here):
    """Long descriptions go on in the next line; they ended in three dots."""
    for start in ("gallery/drifting-capsule", "II-B"):
        assert call("new", "mine", "--from", start, "--force", "-q").exit_code == 0
        text = Path("mine.yaml").read_text()
        assert "..." not in text and max(map(len, text.splitlines())) < 140
        assert vibsim.load_case("mine.yaml").sha256 == vibsim.load_case(start).sha256
        comments = " ".join(text.replace("#", " ").split())
        assert "closed_form: the same, but refused with a motor; taylor: series in every mode" in comments


def test_new_from_a_case_of_the_users(here):
    Path("base.yaml").write_text("extends: II-C\nrun: {t_end: 7 s}\n")
    assert call("new", "mine.yml", "--from", "base.yaml").exit_code == 0
    assert vibsim.load_case("mine.yml").sha256 == vibsim.load_case("base.yaml").sha256
    assert "stiffness of the impact spring" in Path("mine.yml").read_text()


def test_new_keeps_what_is_there(here):
    Path("mine.yaml").write_text("precious")
    done = call("new", "mine")
    assert done.exit_code == 6 and "mine.yaml: exists; kept" in done.stderr
    assert Path("mine.yaml").read_text() == "precious"
    assert call("new", "mine", "--force", "-q").exit_code == 0
    assert call("new", "other", "--from", "nosuch").exit_code == 3 and not Path("other.yaml").exists()


@pytest.mark.parametrize("name", ("", " ", ".", ".."))
def test_new_needs_a_name(here, name):
    done = call("new", name)
    said = "a file needs a name, such as capsule; got" if name else "Error: NAME is empty: give it a value\n"
    assert done.exit_code == 2 and said in done.stderr
    assert not any(here.iterdir())
