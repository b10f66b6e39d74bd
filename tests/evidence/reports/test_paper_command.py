"""The command: its options, interruption, and (slow) the whole report."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command_line.made import call
from tests.docs.paper_page import stored_numbers
from tests.evidence.reports.test_pages import assert_accessible, assert_stands_alone, finding_in, read
from vibsim.evidence.reports.claims import FAILS, HOLDS
from vibsim.evidence.reports.figures import EVIDENCE
from vibsim.evidence.reports.measurements import PAPER_RUNS
from vibsim.evidence.reports.paper_document import judge_claims, paper_claims, readings_table
from vibsim.evidence.reports.paper_figures import paper_figures

ROOT = Path(__file__).resolve().parents[3]


def test_help_ends_with_examples():
    result = call("paper", "--help")
    assert result.exit_code == 0
    assert "vibsim paper -o audit" in result.stdout


@pytest.mark.parametrize("formats", ["gif", "png,tiff", ","])
def test_unknown_formats_are_usage_errors(tmp_path, formats):
    result = call("paper", "-o", tmp_path, "--format", formats)
    assert result.exit_code == 2
    assert "formats are png, pdf, svg" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_is_a_usage_error(tmp_path):
    (tmp_path / "taken").write_text("")
    assert call("paper", "-o", tmp_path / "taken").exit_code == 2


def test_a_folder_that_cannot_be_made_is_file_trouble(tmp_path):
    (tmp_path / "taken").write_text("")
    result = call("paper", "-o", tmp_path / "taken" / "paper")
    assert result.exit_code == 6
    assert "cannot write" in result.stderr


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
    assert list(json.loads((tmp_path / "paper" / "numbers.json").read_text())) == ["facts"]
    assert not (tmp_path / "paper" / "report.html").exists()


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The whole report."""
    folder = tmp_path_factory.mktemp("report") / "paper"
    result = call("--json", "paper", "-o", folder, "--format", "png")
    assert result.exit_code == 0
    return folder, json.loads(result.stdout)["claims"]


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
