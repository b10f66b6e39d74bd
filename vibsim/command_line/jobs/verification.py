"""The verification as a table for people, and as JSON for programs."""

import time
from collections.abc import Iterator, Sequence
from contextlib import closing, suppress
from itertools import groupby
from math import isfinite
from typing import Any

from vibsim.cases.number import number
from vibsim.command_line.errors import RUN_FAILED
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say, style
from vibsim.command_line.terminal.progress import Progress
from vibsim.command_line.text.quantities import counted
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Point, Row
from vibsim.evidence.verification.verifying import rows_of

HEADER = ("", "expected", "obtained", "error", "bound", "verdict")
ENGINES = {"c": "C engine", "python": "Python engine"}


def print_list(checks: Sequence[Check], settings: Settings) -> None:
    """Name and title of each check."""
    if settings.json:
        print_json([{"name": check.name, "title": check.title} for check in checks])
        return
    width = max(len(check.name) for check in checks)
    for check in checks:
        say(f"{check.name:{width}}  {check.title}")


def print_verification(
    checks: Sequence[Check], left_out: Sequence[Check], engine: str, settings: Settings
) -> int:
    """Compute the checks and print their rows; returns the exit code. Interrupted, it prints what it has."""
    began = time.perf_counter()
    with Interruption() as interruption:
        rows = list(_computed(checks, engine, interruption, Progress(not settings.quiet)))
    took = time.perf_counter() - began
    if settings.json:
        print_json(_described(rows, left_out, engine, took))
    else:
        print_table(rows, {check.name: check.title for check in checks}, settings)
        _print_verdict(rows, left_out, engine, took, settings)
    if interruption.signum is not None:
        done = len({row.check for row in rows})
        say(
            f"interrupted after {done} of {counted(len(checks), 'check')}; more: vibsim verify NAME...",
            err=True,
        )
        return interruption.exit_code
    return 0 if all(row.passed for row in rows) else RUN_FAILED


def _computed(
    checks: Sequence[Check], engine: str, interruption: Interruption, progress: Progress
) -> Iterator[Row]:
    """The rows of the checks, with a bar, until an interruption; a check that is under way is given up."""
    with suppress(KeyboardInterrupt), closing(progress):
        for done, check in enumerate(checks):
            progress.show("verifying", done, len(checks))
            if interruption.signum is not None:
                return
            yield from rows_of([check], engine)
        progress.show("verifying", len(checks), len(checks))


def print_table(rows: Sequence[Row], titles: dict[str, str], settings: Settings) -> None:
    """Each check with its title, its rows below; with -q those rows only that fall short, with -v reasons."""
    shown = [row for row in rows if not (settings.quiet and row.passed)]
    if not shown:
        return
    cells = [_cells(row) for row in shown]
    widths = [max(len(line[i]) for line in [HEADER, *cells]) for i in range(len(HEADER))]
    say(_line(HEADER, widths))
    for name, group in groupby(zip(shown, cells, strict=True), key=lambda pair: pair[0].check):
        say(f"{style(name, bold=True)}  {titles.get(name, '')}")
        for row, line in group:
            say(_line(line, widths, row))
            if settings.verbose:
                say(f"      {style(row.because, dim=True)}")


def _cells(row: Row) -> tuple[str, ...]:
    verdict = "ok" if row.passed else "FALLS SHORT"
    return row.what, row.expected, row.obtained, number(row.error, 2), number(row.bound, 2), verdict


def _line(cells: Sequence[str], widths: Sequence[int], row: Row | None = None) -> str:
    what, *numbers, verdict = cells
    aligned = [number.rjust(width) for number, width in zip(numbers, widths[1:-1], strict=True)]
    if row is not None:
        verdict = style(verdict, fg="green" if row.passed else "red")
    return "  ".join(["", what.ljust(widths[0]), *aligned, verdict])


def _print_verdict(
    rows: Sequence[Row], left_out: Sequence[Check], engine: str, took: float, settings: Settings
) -> None:
    wrong = sum(not row.passed for row in rows)
    where = f"{ENGINES[engine]}, {took:.1f} s"
    if left_out:
        names = ", ".join(dict.fromkeys(check.name.rpartition("/")[0] for check in left_out))
        say(f"left out, minutes each on the Python engine; name them to have them: {names}", err=True)
    if wrong:
        text = f"{wrong} of {counted(len(rows), 'number')} fall short of their bounds"
        say(f"{style(text, fg='red')} ({where})")
    elif not settings.quiet:
        text = f"{counted(len(rows), 'number')}, all within their bounds"
        say(f"{style(text, fg='green')} ({where})")


def _described(rows: Sequence[Row], left_out: Sequence[Check], engine: str, took: float) -> dict[str, Any]:
    """The verification as JSON; what is no number is null."""
    return {
        "engine": engine,
        "rows": [_described_row(row) for row in rows],
        "passed": sum(row.passed for row in rows),
        "fallen_short": [row.name for row in rows if not row.passed],
        "left_out": [check.name for check in left_out],
        "seconds": took,
    }


def _described_row(row: Row) -> dict[str, Any]:
    return {
        "check": row.check,
        "name": row.what,
        "expected": row.expected,
        "obtained": row.obtained,
        "error": _number(row.error),
        "bound": _number(row.bound),
        "unit": row.unit,
        "verdict": "ok" if row.passed else "falls short",
        "because": row.because,
        "points": [_described_point(point) for point in row.points],
    }


def _described_point(point: Point) -> dict[str, Any]:
    numbers = ("expected", "obtained", "error", "bound")
    return {
        "what": point.what,
        **{name: _number(getattr(point, name)) for name in numbers},
        "unit": point.unit,
    }


def _number(value: float) -> float | None:
    return float(value) if isfinite(value) else None
