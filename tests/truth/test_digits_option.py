"""--digits on the command line: what it refuses, and how."""

import pytest

import vibsim
from tests.command_line.made import call
from tests.truth.made import case
from vibsim.physics import precision


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--digits", "0"], "0 is not in the range 20 to 1000"),
        (["--digits", "-5"], "-5 is not in the range 20 to 1000"),
        (["--digits", "5000"], "5000 is not in the range 20 to 1000"),
        (["--digits", "many"], "must be a whole number or auto, got 'many'"),
        (["--digits", "80", "--engine", "c"], "the C engine has at most 71 digits, got 80"),
    ],
)
def test_wrong_usage(words, message, tmp_path):
    done = call("run", "I-A", "-o", tmp_path / "out.h5", *words)
    assert done.exit_code == 2
    assert message in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_missing_library_names_the_extra(monkeypatch, tmp_path):
    monkeypatch.setattr(precision, "KITS", {})
    done = call("run", "I-A", "--digits", "60", "-o", tmp_path / "out.h5")
    assert done.exit_code == 2
    assert "pip install 'vibsim[reference]'" in done.stderr
    with pytest.raises(ImportError, match="reference"):
        vibsim.simulate(case("I-A", "1 s"), digits=30)


def test_simulate_refuses_too():
    with pytest.raises(ValueError, match="20 to 1000"):
        vibsim.simulate(case("I-A", "1 s"), digits=10)
    with pytest.raises(ValueError, match="at most 71 digits"):
        vibsim.simulate(case("I-A", "1 s"), digits=80, engine="c")


def test_method_taylor_is_obeyed(tmp_path):
    path = tmp_path / "out.h5"
    words = ["run", "I-A", "--digits", "30", "--method", "taylor", "--t-end", "0.5 s", "-o", path]
    done = call(*words)
    assert done.exit_code == 0
    assert "C on 128-bit numbers, taylor series of order 36" in done.stdout
    assert vibsim.open_result(path).attrs["method"] == "taylor"
