"""The command: its options, interruption, and (slow) the whole report."""

import json
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from tests.command_line.made import call, refused, told
from tests.docs.paper_page import stored_numbers
from tests.evidence.reports.test_pages import assert_accessible, assert_stands_alone, finding_in, read
from vibsim.analysis import judge_capture
from vibsim.analysis.capture import Capture
from vibsim.analysis.cycles import Hold, Span
from vibsim.cases import load_case
from vibsim.engine.errors import REASONS, EngineError, State
from vibsim.evidence.reports import measurements
from vibsim.evidence.reports.claims import FAILS, HOLDS
from vibsim.evidence.reports.figures import EVIDENCE
from vibsim.evidence.reports.measurements import (
    EVERY,
    PAPER_RUNS,
    MeasurementInterrupted,
    member_outcome,
    obtain_run,
    outcome_of,
    run_all,
    stored_run,
)
from vibsim.evidence.reports.paper_document import judge_claims, paper_claims, readings_table
from vibsim.evidence.reports.paper_figures import paper_figures
from vibsim.results import simulate
from vibsim.results.simulation import open_result

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("formats", ["gif", "png,tiff", ","])
def test_unknown_formats_are_usage_errors(tmp_path, formats):
    assert "formats are png, pdf, svg" in refused("paper", "-o", tmp_path, "--format", formats)
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_is_a_usage_error(tmp_path):
    """And a folder that cannot be made is trouble with files."""
    (tmp_path / "taken").write_text("")
    assert call("paper", "-o", tmp_path / "taken").exit_code == 2
    assert "cannot write" in refused("paper", "-o", tmp_path / "taken" / "paper", code=6)


def test_an_interrupted_report_keeps_what_was_done(tmp_path):
    """Ctrl-C while the runs are measured: the trajectories are there, and are used by the next call."""
    command = [sys.executable, "-m", "vibsim", "paper", "-o", tmp_path / "paper"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as running:
        for line in running.stderr:
            if line.startswith("measuring"):
                running.send_signal(signal.SIGINT)
                break
        last = running.stderr.read()
        code = running.wait(timeout=100)
    assert code == 130
    assert last.endswith("the same command resumes it\n")
    runs = sorted(path.stem for path in (tmp_path / "paper" / "runs").iterdir())
    assert runs == sorted(PAPER_RUNS)
    assert "facts" in json.loads((tmp_path / "paper" / "numbers.json").read_text())
    assert not (tmp_path / "paper" / "report.html").exists()


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The whole report."""
    folder = tmp_path_factory.mktemp("report") / "paper"
    result = told("--json", "paper", "-o", folder, "--format", "png")
    return folder, json.loads(result)["claims"]


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_report_is_whole(report):
    folder, claims = report
    page = read((folder / "report.html").read_text(encoding="utf-8"))
    assert_stands_alone(page)
    assert_accessible(page)
    assert len(page.all("img")) == len(paper_figures()) + 3 + len(EVIDENCE)
    assert len(claims) == len(page.all("article")) == len(paper_claims())
    assert (folder / "figures" / "all-figures.png").is_file()
    assert sorted(path.stem for path in (folder / "runs").glob("*.h5")) == sorted(PAPER_RUNS)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_findings_are_those_of_the_page_on_the_paper(report):
    _, claims = report
    found = {claim.key: finding.verdicts for claim, finding in judge_claims(stored_numbers())}
    assert claims == {key: [verdict.word for verdict in verdicts] for key, verdicts in found.items()}


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_readings_are_those_of_the_page_on_the_paper(report):
    """Row by row: what is changed, from how many starts each statement holds, and the price."""
    folder, _ = report
    ranking = json.loads((folder / "numbers.json").read_text())["readings"]["numbers"]["ranking"]
    rows = []
    for name, kept, *cells, _, price in readings_table(ranking).rows:
        shown = name.removesuffix(", as printed") + ("" if kept == "kept" else " (against Table 1)")
        counts = [cell.partition("/")[0] for cell in cells[:6]]
        rows.append(f"| {' | '.join([shown, *counts, price])} |")
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    assert "\n".join(f"   {row}" for row in rows) in page


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_a_second_call_uses_what_is_there_and_follows_the_numbers(report):
    """A wrong number planted in numbers.json turns its verdict, in the page as well; nothing is measured."""
    folder, claims = report
    path = folder / "numbers.json"
    table = json.loads(path.read_text())
    assert claims["impacts"] == [HOLDS, HOLDS]
    table["runs"]["numbers"]["I-C"]["cycles"]["verdict"] = "some cycles"
    path.write_text(json.dumps(table))
    written = {run: run.stat().st_mtime_ns for run in (folder / "runs").iterdir()}
    again = call("--json", "paper", "-o", folder, "--format", "png")
    assert json.loads(again.stdout)["claims"] == {**claims, "impacts": [FAILS, HOLDS]}
    assert {run: run.stat().st_mtime_ns for run in (folder / "runs").iterdir()} == written
    assert json.loads(path.read_text()) == table
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert FAILS in finding_in(page, '<article id="impacts">')


# A trajectory is taken over where it is of the same case, whole, and judged; else it is made again.


SHORT = {"run.t_end": "2 s"}


@pytest.fixture
def case():
    return load_case("I-A", SHORT)


def test_a_run_is_simulated_once(tmp_path, case):
    first, anew = obtain_run(case, tmp_path)
    written = (tmp_path / "I-A.h5").read_bytes()
    again, once_more = obtain_run(case, tmp_path)
    assert (anew, once_more) == (True, False)
    assert (tmp_path / "I-A.h5").read_bytes() == written
    assert again["x1"].tolist() == first["x1"].tolist()
    assert obtain_run(case, tmp_path, fresh=True)[1]


def test_a_run_of_another_version_is_replaced(tmp_path, case, monkeypatch):
    obtain_run(case, tmp_path)
    monkeypatch.setattr(measurements, "__version__", "0.0")
    assert stored_run(case, tmp_path / "I-A.h5") is None


LEFT = {  # in the place of the run
    "another case": lambda path: obtain_run(load_case("I-A", {**SHORT, "c": "0.002"}), path.parent),
    "no trust horizon": lambda path: simulate(load_case("I-A", SHORT), trust=False).save(path),
    "a damaged file": lambda path: path.write_text("no HDF5"),
}


@pytest.mark.parametrize("leave", LEFT.values(), ids=LEFT)
def test_what_is_no_such_run_is_replaced(tmp_path, case, leave):
    leave(tmp_path / "I-A.h5")
    found, anew = obtain_run(case, tmp_path)
    assert anew and (found.case.number("coupling.c"), found.trust_horizon) == (0.001, 2.0)


def test_an_interrupted_run_is_not_taken_over(tmp_path, case):
    long = load_case("I-A", {"run.t_end": "100000 s"})
    with pytest.raises(MeasurementInterrupted):
        obtain_run(long, tmp_path, watch=lambda t: False)
    assert not open_result(tmp_path / "I-A.h5").complete
    assert stored_run(long, tmp_path / "I-A.h5") is None


# Many short looks at runs: the same verdicts as a run of its own, in order, and stoppable.


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
    reason, state = next(iter(REASONS)), State(1.0, [0.0, 0.0], [0.0, 0.0], 0.0, 0.0, 0.0)

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
