"""vibsim paper: every figure and claim of the paper, reproduced and audited."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path
from typing import Any

import click

from vibsim.command_line.main import told
from vibsim.command_line.options import Settings, examples
from vibsim.command_line.terminal import Progress, print_json, say
from vibsim.command_line.text import goes_on, print_lines, size
from vibsim.evidence.reports.measurements import MeasurementInterrupted
from vibsim.evidence.reports.pages import verdicts_of
from vibsim.evidence.reports.paper import Report, write_paper
from vibsim.signals import Interruption, interrupted_with

FORMATS = ("png", "pdf", "svg")


class Formats(click.ParamType):
    """Formats of pictures, separated by commas."""

    name = "formats"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        if isinstance(value, tuple):
            return value
        names = tuple(name.strip().lower() for name in value.split(",") if name.strip())
        unknown = [name for name in names if name not in FORMATS]
        if unknown or not names:
            self.fail(f"{', '.join(unknown) or value!r}: formats are {', '.join(FORMATS)}", param, ctx)
        return names


@click.command(
    "paper",
    short_help="Reproduce and audit the paper.",
    epilog=examples(
        "vibsim paper",
        "vibsim paper -o audit --format png,svg",
        "vibsim paper --fresh --json | jq .claims",
        before="Runs and numbers that are in the folder already are used again, as far as they are of the "
        "same cases and version.",
    ),
)
@click.option(
    "-o", "--output", "folder", type=click.Path(file_okay=False, readable=False), default="paper",
    show_default=True, metavar="DIR", help="Folder for the report; made where it is missing.",
)  # fmt: skip
@click.option(
    "--format", "formats", type=Formats(), default="png,pdf", show_default=True, metavar="FORMAT[,FORMAT..]",
    help="Of the figures: png, pdf, svg. PNG is always written.",
)  # fmt: skip
@click.option("--fresh", is_flag=True, help="Simulate and measure everything again.")
@click.pass_context
def command(ctx: click.Context, folder: str, formats: tuple[str, ...], fresh: bool) -> int:
    """Draw every figure of the paper, judge every claim, and write a report.

    DIR then holds report.html (one file, opens offline) and report.txt, the figures, the trajectories as HDF5
    files, and numbers.json, from which the verdicts follow. The exit code is 0 whatever the verdicts are.
    """

    return write_report(folder, formats, fresh, ctx.obj)


# What `vibsim paper` does: write the report with progress and interruption, then say what came of it.


def write_report(folder: str, formats: tuple[str, ...], fresh: bool, settings: Settings) -> int:
    """Write the report into the folder; returns the exit code."""
    began, remedy = time.perf_counter(), goes_on(folder)
    steps = Progress(not settings.quiet, listed=True)
    with Interruption() as interruption, interrupted_with(lambda: remedy), steps:

        def tell(step: str, done: int, total: int) -> bool:
            steps.show(step, done, total)
            return interruption.signum is None

        try:
            report = write_paper(folder, formats, tell, fresh)
        except MeasurementInterrupted:
            return told(f"interrupted: {remedy}", interruption.exit_code, settings.json)
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
        say(f"{number:3}. {claim.statement}")
        say(f"     {words}")
    verdicts = "; ".join(f"{number} × {verdict}" for verdict, number in count.items())
    runs = f"{report.simulated} simulated" if report.simulated else "all there already"
    print_lines(
        [
            ("claims", f"{len(report.findings)}: {verdicts}"),
            ("runs", f"{Path(folder) / 'runs'}: {runs}"),
            ("report", f"{report.html} ({size(report.html)}), {report.text}; {took:.1f} s"),
        ]
    )
