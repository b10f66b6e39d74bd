"""Many short looks at runs: the same verdicts as a run of its own, in order, and stoppable."""

import subprocess
import sys
import threading
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import pytest

from vibsim.analysis import judge_capture
from vibsim.analysis.capture import Capture
from vibsim.analysis.cycles import Hold, Span
from vibsim.cases import load_case
from vibsim.engine.errors import REASONS, EngineError
from vibsim.evidence.reports import measurements
from vibsim.evidence.reports.measurements import (
    EVERY,
    MeasurementInterrupted,
    member_outcome,
    outcome_of,
    run_all,
)
from vibsim.results import simulate


def test_an_outcome_is_the_verdict_on_the_run():
    """The motor without a stop is captured near its natural frequency, 4.0 to 4.1 Hz."""
    case = load_case("II-B", {"stop.G": "1000 m", "run.t_end": "150 s"})
    found = outcome_of(simulate(case.with_values({"run.every": EVERY}), trust=False))
    fine = judge_capture(simulate(case, trust=False))
    assert found["verdict"] == fine.verdict == "captured"
    assert found["speed_hz"] == pytest.approx(fine.speed_hz, rel=2e-3)
    assert 3.95 < found["speed_hz"] < 4.15


def test_a_hold_counts_whether_or_not_the_speed_settles_behind_it(monkeypatch):
    """A motor that is held until 60 s and still hunts at 300 s has been let go."""
    result = simulate(load_case("II-A", {"run.t_end": "20 s"}), trust=False)
    holds = tuple(Hold(20.0, 20.0 + 10 * delay, 3.7, 40.0, 0.4, delay, False) for delay in (3.0, 4.0))
    capture = Capture("undecided", "the speed is still changing", Span(0.0, 20.0), 6.5, 6.1, holds=holds)
    monkeypatch.setattr(measurements, "judge_capture", lambda result: capture)
    told = outcome_of(result)
    assert (told["verdict"], told["since"], told["until"], told["speed_hz"]) == ("undecided", 20.0, 60.0, 3.7)
    monkeypatch.setattr(measurements, "judge_capture", lambda result: replace(capture, verdict="not met"))
    assert outcome_of(result)["since"] is None


def test_outcomes_come_in_order():
    cases = [load_case("II-A", {"run.t_end": f"{t} s"}) for t in (30, 20, 10)]
    told = run_all([partial(member_outcome, case) for case in cases], lambda done, total: True)
    assert told == [member_outcome(case) for case in cases]


def test_a_run_that_fails_is_an_outcome_too(monkeypatch):
    reason, state = next(iter(REASONS)), SimpleNamespace(t=1.0, x=[0.0, 0.0], v=[0.0, 0.0])

    def fail(*given, **options):
        raise EngineError(reason, state)

    monkeypatch.setattr(measurements, "simulate", fail)
    assert member_outcome(load_case("II-A")) == {"failed": str(EngineError(reason, state))}


def test_work_stops_when_told():
    """Of nine jobs seven would not end by themselves."""
    seen, never = [], threading.Event()

    def advance(done, total):
        seen.append((done, total))
        return done < 2

    with pytest.raises(MeasurementInterrupted):
        run_all([lambda: {}] * 2 + [lambda: {"waited": never.wait(60)}] * 7, advance)
    never.set()
    assert seen[-1] == (2, 9)


INTERRUPTED_WITH_A_FILE_IN_USE = """
import time
from threading import Event
from h5py._objects import phil
from vibsim.evidence.reports.measurements import run_all
from vibsim.evidence.reports.measurements import MeasurementInterrupted as Interrupted

held = Event()

def job():
    with phil:  # as every call of h5py
        held.set()
        time.sleep(0.5)
    return {}

try:
    run_all([job], lambda done, total: not held.is_set())
except Interrupted:
    print("interrupted")
"""


def test_a_process_ends_though_a_job_under_way_uses_a_file():
    """Python ended the job's thread within h5py, whose lock nobody gave back: the process never ended."""
    command = [sys.executable, "-c", INTERRUPTED_WITH_A_FILE_IN_USE]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted\n", "")
