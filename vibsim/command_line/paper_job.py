"""What `vibsim paper` does: write the report with progress and interruption, then say what came of it."""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import click

from vibsim.command_line.errors import told
from vibsim.command_line.interruption import Interruption
from vibsim.command_line.quantity_text import size
from vibsim.command_line.settings import Settings
from vibsim.command_line.summary import print_lines
from vibsim.command_line.terminal import print_json, say
from vibsim.evidence.reports.paper import Report, write_paper
from vibsim.evidence.reports.paper_runs import Interrupted


def write_report(folder: str, formats: tuple[str, ...], fresh: bool, settings: Settings) -> int:
    """Write the report into the folder; returns the exit code."""
    began = time.perf_counter()
    steps = Steps(wanted=not settings.quiet)
    with Interruption() as interruption:

        def tell(step: str, done: int, total: int) -> bool:
            steps.show(step, done, total)
            return interruption.signum is None

        try:
            report = write_paper(folder, formats, tell, fresh)
        except Interrupted:
            what = f"interrupted: {folder} holds what was done; the same command goes on from there"
            return told(what, interruption.exit_code, settings.json)
        finally:
            steps.close()
    _print_report(report, folder, time.perf_counter() - began, settings)
    return 0


def _print_report(report: Report, folder: str, took: float, settings: Settings) -> None:
    if settings.json:
        claims = {claim.key: finding.verdict for claim, finding in report.findings}
        print_json({"folder": folder, "report": str(report.html), "text": str(report.text), "claims": claims})
        return
    if settings.quiet:
        return
    count = Counter(finding.verdict for _, finding in report.findings)
    for number, (claim, finding) in enumerate(report.findings, start=1):
        say(f"{number:3}. {finding.verdict:14} {claim.statement}")
    verdicts = ", ".join(f"{number} {verdict}" for verdict, number in count.items())
    runs = f"{report.simulated} simulated" if report.simulated else "all there already"
    print_lines(
        [
            ("claims", f"{len(report.findings)}: {verdicts}"),
            ("runs", f"{Path(folder) / 'runs'}: {runs}"),
            ("report", f"{report.html} ({size(report.html)}), {report.text}; {took:.1f} s"),
        ]
    )


class Steps:
    """What is being done, on stderr: a bar for each step on a terminal, one line for each step elsewhere."""

    def __init__(self, wanted: bool):
        self._wanted = wanted
        self._step = ""
        self._bar: Any = None

    def show(self, step: str, done: int, total: int) -> None:
        """Say how far a step is."""
        if not self._wanted:
            return
        if step != self._step:
            self.close()
            self._step = step
            self._begin(total)
        if self._bar is not None and done > self._bar.pos:
            self._bar.update(done - self._bar.pos)

    def close(self) -> None:
        """Leave the terminal line as the bar left it."""
        if self._bar is not None:
            self._bar.render_finish()
            self._bar = None

    def _begin(self, total: int) -> None:
        if not sys.stderr.isatty():
            say(self._step, err=True)
            return
        self._bar = click.progressbar(length=total, label=f"{self._step:28}", file=sys.stderr, show_pos=True)
        self._bar.render_progress()
