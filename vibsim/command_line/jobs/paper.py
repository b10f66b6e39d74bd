"""What `vibsim paper` does: write the report with progress and interruption, then say what came of it."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path

from vibsim.command_line.errors import told
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import Progress
from vibsim.command_line.text.going_on import goes_on
from vibsim.command_line.text.quantities import size
from vibsim.command_line.text.summary import print_lines
from vibsim.evidence.reports.measured.paper_runs import Interrupted
from vibsim.evidence.reports.pages.document import verdicts_of
from vibsim.evidence.reports.paper import Report, write_paper
from vibsim.files.signals import interrupted_with


def write_report(folder: str, formats: tuple[str, ...], fresh: bool, settings: Settings) -> int:
    """Write the report into the folder; returns the exit code."""
    began = time.perf_counter()
    steps = Progress(not settings.quiet, listed=True)
    remedy = goes_on(folder)
    with Interruption() as interruption, interrupted_with(lambda: remedy):

        def tell(step: str, done: int, total: int) -> bool:
            steps.show(step, done, total)
            return interruption.signum is None

        try:
            report = write_paper(folder, formats, tell, fresh)
        except Interrupted:
            return told(f"interrupted: {remedy}", interruption.exit_code, settings.json)
        finally:
            steps.close()
    _print_report(report, folder, time.perf_counter() - began, settings)
    return 0


def _print_report(report: Report, folder: str, took: float, settings: Settings) -> None:
    if settings.json:
        claims = {
            claim.key: [verdict.word for verdict in finding.verdicts] for claim, finding in report.findings
        }
        print_json({"folder": folder, "report": str(report.html), "text": str(report.text), "claims": claims})
        return
    if settings.quiet:
        return
    count = Counter(verdict.word for _, finding in report.findings for verdict in finding.verdicts)
    for number, (claim, finding) in enumerate(report.findings, start=1):
        words = "; ".join(f"{about.lower()}: {verdict.word}" for about, verdict in verdicts_of(finding))
        say(f"{number:3}. {claim.statement}\n     {words}")
    verdicts = "; ".join(f"{number} × {verdict}" for verdict, number in count.items())
    runs = f"{report.simulated} simulated" if report.simulated else "all there already"
    print_lines(
        [
            ("claims", f"{len(report.findings)}: {verdicts}"),
            ("runs", f"{Path(folder) / 'runs'}: {runs}"),
            ("report", f"{report.html} ({size(report.html)}), {report.text}; {took:.1f} s"),
        ]
    )
