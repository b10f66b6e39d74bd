"""Ctrl-C, SIGTERM and the progress bar, in processes of their own."""

import os
import pty
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import vibsim
from tests.command_line.made import SLOW_SOURCE, begun, call, own_handlers
from vibsim.cases.case import load_case_text
from vibsim.command_line.main import exit_code_of
from vibsim.command_line.terminal import SlowRun
from vibsim.physics.rates import fastest_damping
from vibsim.signals import Interruption, Terminated, heard_from_now_on

ENDLESS = [sys.executable, "-m", "vibsim", "run", "II-B", "--t-end", "1000000s"]


def running(folder, *words):
    """A run that would take an hour, once it has written samples."""
    run = subprocess.Popen([*ENDLESS, *words], cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    partial = folder / "II-B.h5.partial"
    while not (partial.exists() and partial.stat().st_size > 1e6) and run.poll() is None:
        time.sleep(0.01)
    return run


@pytest.mark.parametrize(
    ("signum", "code", "words"), [(signal.SIGINT, 130, ["--force"]), (signal.SIGTERM, 143, ["I-A"])]
)
def test_an_interrupted_run_is_finished_as_incomplete(tmp_path, signum, code, words):
    """With --force in the place of an older file; the cases behind it do not run."""
    if words == ["--force"]:
        (tmp_path / "II-B.h5").write_text("old")
    run = running(tmp_path, *words)
    run.send_signal(signum)
    _, errors = run.communicate(timeout=60)
    assert run.returncode == code
    assert os.listdir(tmp_path) == ["II-B.h5"]
    result = vibsim.open_result(tmp_path / "II-B.h5")
    assert not result.complete
    assert errors.decode().endswith(f"interrupted: II-B.h5 holds the run until {result.t_reached:g} s\n")
    assert 0 < result.t_reached < 1e6
    assert result.time[-1] <= result.t_reached
    start = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "20 s"}))
    count = min(len(start), len(result))
    for name in result:
        assert np.array_equal(result[name][:count], start[name][:count])


def test_a_long_run_on_a_terminal_shows_its_progress(tmp_path):
    terminal, its_end = pty.openpty()
    environment = {**os.environ, "TERM": "xterm"}
    with subprocess.Popen(ENDLESS, cwd=tmp_path, stdout=its_end, stderr=its_end, env=environment) as run:
        os.close(its_end)
        text = b""
        while b"of 1e+06 s" not in text:
            text += os.read(terminal, 4096)
        run.send_signal(signal.SIGINT)
        while True:
            try:
                piece = os.read(terminal, 4096)
            except OSError:  # the terminal's other end is closed
                break
            if not piece:
                break
            text += piece
    os.close(terminal)
    assert b"II-B  [" in text
    assert b"interrupted: II-B.h5 holds the run until" in text


@pytest.mark.parametrize(("terminal", "words", "bar"), [(1, (), True), (1, ("-q",), False), (0, (), False)])
def test_no_progress_without_a_terminal_and_none_when_quiet(tmp_path, monkeypatch, terminal, words, bar):
    monkeypatch.setattr("vibsim.command_line.commands.run.PROGRESS_AFTER", 0.0)
    monkeypatch.setattr("click.testing._NamedTextIOWrapper.isatty", lambda _: bool(terminal), raising=False)
    done = call("run", "II-B", "--t-end", "20s", "-o", tmp_path / "a.h5", *words)
    assert done.exit_code == 0 and ("II-B  [" in done.stderr) == bar


def test_a_second_signal_interrupts_at_once():
    with Interruption() as interruption:
        assert interruption.exit_code == 0
        signal.raise_signal(signal.SIGTERM)
        assert interruption.exit_code == 143
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


MET_AS_IT_ENDS = """
import signal, sys
from vibsim.command_line import main

ended, calls = main.ended_by_signals, []

def ended_by_signals():
    calls.append(0)
    if len(calls) == 1:  # as the handler of Python does at the call
        signal.raise_signal(signal.SIGINT)
    ended()

main.ended_by_signals = ended_by_signals
sys.argv[1:] = ["--version"]
main.main()
"""


def test_a_signal_that_meets_a_command_as_it_ends_changes_nothing():
    """It left a traceback, and the alarm that raises it again ended the process by SIGALRM."""
    done = subprocess.run([sys.executable, "-c", MET_AS_IT_ENDS], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "") and done.stdout.startswith("vibsim ")


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no alarms there")
def test_no_alarm_goes_off_behind_a_command_that_a_signal_met_as_it_began(capsys):
    """It was raised again 0.2 s later, in whatever ran by then."""
    with own_handlers():
        heard_from_now_on()
        try:
            code = exit_code_of(lambda: signal.raise_signal(signal.SIGINT))
            assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    assert code == 130 and capsys.readouterr().err == "interrupted\n"


def test_a_slow_run_is_told_with_its_rate_and_an_estimate(tmp_path):
    (tmp_path / "slow.yaml").write_text(SLOW_SOURCE)
    with begun("run", "slow.yaml", cwd=tmp_path, stdout=subprocess.DEVNULL) as child:
        line = child.stderr.readline()
        child.send_signal(signal.SIGINT)
        child.communicate(timeout=100)
    said = r"slow: slow: [\d.e-]+ s of the motion per second, about .* more; Ctrl-C ends it\n"
    assert re.fullmatch(said, line)


def noted(marks, t_end, capsys, **options):
    """What is said of a run worked out to t [s] at so many seconds on the clock: marks (clock, t)."""
    clock = iter([0.0, *(seconds for seconds, _ in marks)])
    slow = SlowRun("case", t_end, clock=lambda: next(clock), **options)
    for _, t in marks:
        slow.note(t)
    return capsys.readouterr().err


def test_what_is_said_of_a_slow_run(capsys):
    said = "case: slow: 2 s of the motion per second, about 30 minutes more; Ctrl-C ends it\n"
    assert noted([(0.5, 0.1), (2.0, 4.0), (4.0, 8.0)], 3604.0, capsys) == said
    assert "no further than t = 3 s" in noted([(1.5, 3.0), (3.0, 3.0)], 50.0, capsys)
    assert noted([(2.0, 3.0), (3.5, 6.0)], 50.0, capsys) == ""  # over in half a minute
    assert noted([(2.0, 3e4), (3.5, 6e4)], 1e9, capsys) == ""  # as fast as its span suggests
    # first it stands, then it is fast
    assert noted([(2.0, 500.0), (3.5, 505.0)], 1e9, capsys).startswith("case: slow: 3.3 s of")


def test_slow_run_tells_of_a_stiff_damper(capsys):
    stiff = noted([(2.0, 0.01)], 10.0, capsys, damping=("joint", 2e8))
    assert "; the damper of joint (c / m = 2e+08 1/s) asks for steps of some 4e-08 s: with a smaller" in stiff
    assert "damper" not in noted([(2.0, 0.01)], 10.0, capsys, damping=("joint", 2e4))
    state = noted([(2.0, 0.01)], 10.0, capsys, damping=("i", 2e8), states=["i"])
    assert "; the state i, which comes to rest at 2e+08 1/s, asks for steps of some 4e-08 s:" in state


def test_a_run_that_gets_far_slower_is_told_again(capsys):
    marks = [(2.0, 10.0), (4.0, 12.0), (6.0, 12.1), (8.0, 12.11)]
    told = noted(marks, 1000.0, capsys, lossless=["floor", "wall"]).splitlines()
    assert [line.split(";")[0] for line in told] == [
        "case: slow: 5 s of the motion per second, about 3.3 minutes more",
        "case: slow: 0.05 s of the motion per second, about 5.5 hours more",
    ]
    hops = "hops on floor, wall (e = 1) that die out come ever faster and never end; with e < 1 they end"
    assert told[-1].endswith(f"; {hops}")


BODIES = "bodies: {a: 1 kg, b: 3 kg}\n"
LINKS = """
links:
  held: {between: [a, ground], k: 0 N/m, c: 4 N s/m}
  joint: {between: [a, b], k: 0 N/m, c: 6 N s/m}
"""
STOP = "stops: {wall: {between: [b, ground], gap: 0 m, acts: compression, k: 1 N/m, c: 30 N s/m}}\n"


@pytest.mark.parametrize(
    ("parts", "fastest"), [("", ("", 0.0)), (LINKS, ("joint", 8.0)), (LINKS + STOP, ("wall", 10.0))]
)
def test_fastest_damper_is_that_of_the_lightest_ends(parts, fastest):
    assert fastest_damping(load_case_text(BODIES + parts).scene()) == fastest


def test_work_that_does_not_ask_is_interrupted_after_a_while(monkeypatch):
    monkeypatch.setattr("vibsim.signals.PATIENCE_FOR_END", 0.2)
    for signum, raised in ((signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)):
        with pytest.raises(raised), Interruption():
            signal.raise_signal(signum)
            time.sleep(60)
    monkeypatch.setattr("vibsim.signals.PATIENCE_FOR_END", 60.0)
    with Interruption() as interruption:
        signal.raise_signal(signal.SIGINT)
        assert signal.getitimer(signal.ITIMER_REAL)[0] > 0
        assert interruption.signum == signal.SIGINT
        assert signal.getitimer(signal.ITIMER_REAL)[0] == 0  # told, so it may end in peace


FOR_EVER = """
import sys
from vibsim.results import hdf5_reading as reading
def deaf(path):
    print("opening", flush=True)
    import ctypes
    ctypes.PyDLL(None).sleep(600)  # holds the GIL, as HDF5 does
reading.open_hdf5 = deaf
sys.argv = ["vibsim", "info", "run.h5"]
from vibsim.command_line.main import main
main()
"""


def test_a_file_that_hdf5_does_not_come_back_from(tmp_path):
    command = [sys.executable, "-c", FOR_EVER]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=tmp_path) as process:
        assert process.stdout.readline() == b"opening\n"
        process.send_signal(signal.SIGINT)
        assert process.wait(100) == -signal.SIGINT
