"""The hard cases are found by name, as the paper's are."""

import pytest

from tests.command_line.made import told
from vibsim.cases import CaseError, hard_case_names, load_case


@pytest.mark.parametrize("name", hard_case_names())
def test_a_hard_case_is_found_by_name(name):
    case = load_case(name)
    assert case.source.endswith(f"{name.partition('/')[2]}.yaml")


def test_a_name_that_is_nearly_right_gets_a_hint():
    with pytest.raises(CaseError, match=r"no such file \(did you mean hard/stiff-stop\?\)"):
        load_case("hard/stif-stop")


def test_a_file_of_the_same_name_is_reached_by_its_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hard").mkdir()
    (tmp_path / "hard/stiff-stop").write_text("extends: I-A\nname: mine\n")
    assert load_case("./hard/stiff-stop").name == "mine"
    assert load_case("hard/stiff-stop").name == "stiff-stop"


def test_a_hard_case_runs_by_name(tmp_path):
    told("run", "hard/stiff-stop", "--t-end", "0.1s", "-o", tmp_path / "stiff.h5")
