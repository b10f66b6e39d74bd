"""Ctrl-C, SIGTERM and the progress bar, in processes of their own."""

import os
import pty
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import vibsim

ENDLESS = [sys.executable, "-m", "vibsim", "run", "II-B", "--t-end", "1000000s"]


def running(folder, *words, **options):
    """A run that would take an hour, once it writes."""
    run = subprocess.Popen(
        [*ENDLESS, *words], cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE, **options
    )
    while not (folder / "II-B.h5.partial").exists() and run.poll() is None:
        time.sleep(0.01)
    time.sleep(0.3)
    return run


@pytest.mark.parametrize(("signum", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_run_is_finished_as_incomplete(tmp_path, signum, code):
    run = running(tmp_path)
    run.send_signal(signum)
    _, errors = run.communicate(timeout=60)
    assert run.returncode == code
    assert os.listdir(tmp_path) == ["II-B.h5"]
    result = vibsim.open_result(tmp_path / "II-B.h5")
    assert not result.complete
    assert errors.decode() == f"interrupted: II-B.h5 holds the run until {result.t_reached:g} s\n"
    assert 0 < result.t_reached < 1e6
    assert result.time[-1] <= result.t_reached
    start = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "20 s"}))
    count = min(len(start), len(result))
    for name in result:
        assert np.array_equal(result[name][:count], start[name][:count])


def test_the_cases_after_an_interrupted_one_do_not_run(tmp_path):
    run = running(tmp_path, "I-A")
    run.send_signal(signal.SIGINT)
    run.communicate(timeout=60)
    assert run.returncode == 130
    assert os.listdir(tmp_path) == ["II-B.h5"]


def test_an_interruption_with_force_replaces_the_old_file_by_the_part(tmp_path):
    (tmp_path / "II-B.h5").write_text("old")
    run = running(tmp_path, "--force")
    run.send_signal(signal.SIGINT)
    run.communicate(timeout=60)
    assert not vibsim.open_result(tmp_path / "II-B.h5").complete


def on_a_terminal(folder, command, seconds):
    """What a command writes to a terminal in so many seconds, before it gets a Ctrl-C."""
    terminal, its_end = pty.openpty()
    with subprocess.Popen(
        command, cwd=folder, stdout=its_end, stderr=its_end, env={**os.environ, "TERM": "xterm"}
    ) as run:
        os.close(its_end)
        time.sleep(seconds)
        run.send_signal(signal.SIGINT)
        text = b""
        while True:
            try:
                piece = os.read(terminal, 4096)
            except OSError:  # the terminal's other end is closed
                break
            if not piece:
                break
            text += piece
    os.close(terminal)
    return text.decode()


def test_a_long_run_on_a_terminal_shows_its_progress(tmp_path):
    text = on_a_terminal(tmp_path, ENDLESS, seconds=5)
    assert "II-B  [" in text
    assert "of 1e+06 s" in text
    assert "interrupted: II-B.h5 holds the run until" in text


def test_no_progress_without_a_terminal_and_none_when_quiet(tmp_path):
    assert "[-" not in on_a_terminal(tmp_path, [*ENDLESS, "-q"], seconds=4)
    (tmp_path / "II-B.h5").unlink()
    run = running(tmp_path)
    time.sleep(1.5)
    run.send_signal(signal.SIGINT)
    assert b"[" not in run.communicate(timeout=60)[1]


def test_a_second_signal_interrupts_at_once():
    from vibsim.command_line.interruption import Interruption

    with Interruption() as interruption:
        assert interruption.exit_code == 0
        signal.raise_signal(signal.SIGTERM)
        assert interruption.exit_code == 143
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
