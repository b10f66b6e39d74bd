"""vibsim run --ramp, inside this process."""

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from vibsim.cases.ramps import no_load_speed


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Every test runs in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words, code=0):
    done = call("run", *words)
    assert done.exit_code == code, done.output
    return done


@pytest.mark.parametrize(
    ("more", "end"),
    [((), 2.0), (("--t-end", "3s"), 3.0), (("-s", "run.t_end=1 s"), 1.0), (("-s", "t_end=1 s"), 1.0)],
)
def test_the_ramp_ends_the_run_unless_told_otherwise(more, end):
    run("II-B", "--ramp", "Omega0=3:7Hz", "--over", "2s", *more)
    result = vibsim.open_result("II-B.h5")
    assert result.time[-1] == end
    assert no_load_speed(result.case, np.array([1.0, 5.0])) == pytest.approx([5, 7])


def test_there_and_back_takes_the_time_twice():
    run("II-B", "--ramp", "Omega0=3:7:3Hz", "--over", "2s", "-o", "both.h5")
    assert vibsim.open_result("both.h5").time[-1] == 4


def test_torque_and_no_load_speed_as_a_voltage_drives_them():
    run("II-B", "--ramp", "Omega0=2:6Hz", "--ramp", "M0=2:6 N mm", "--over", "2s")
    case = vibsim.open_result("II-B.h5").case
    assert str(case.quantity("M0_to")) == "6 N mm"
    assert no_load_speed(case, np.array([1.0])) == pytest.approx([4])


def test_a_run_from_a_file_gets_another_ramp():
    run("II-B", "--ramp", "Omega0=3:7Hz", "--over", "1s", "-o", "up.h5")
    run("up.h5", "--ramp", "Omega0=7:3Hz", "--over", "2s", "-o", "down.h5")
    down = vibsim.open_result("down.h5")
    assert down.time[-1] == 2
    assert no_load_speed(down.case, np.array([0.0, 2.0])) == pytest.approx([7, 3])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--ramp", "Omega0=3:7Hz"), "--ramp needs --over"),
        (("--over", "3s"), "--over needs a --ramp"),
        (("--ramp", "Omega0=3:7Hz", "--over", "3 kg"), "--over must be a time in s"),
        (("--ramp", "Omega0", "--over", "3s"), "'Omega0' is not KEY=FROM:TO, such as Omega0=3:7Hz"),
        (("--ramp", "Omega0=3:3Hz", "--over", "3s"), "goes from a value to the same"),
        (("--ramp", "m1=3:4kg", "--over", "3s"), "blocks.m1 takes no formula; here these can have a ramp"),
        (("--ramp", "Omega0=3:4Hz", "--ramp", "Omega0=4:5Hz", "--over", "3s"), "Omega0 is given twice"),
        (("--ramp", "Omega0=3:4Hz", "-s", "excitation.Omega0=4 Hz", "--over", "3s"), "give one value"),
    ],
)
def test_what_is_refused(words, message, folder):
    done = run("II-B", *words, code=2)
    assert message in " ".join(done.stderr.split())
    assert not list(folder.iterdir())
