"""vibsim verify: known cases and hard ones, computed afresh and held against what they should be."""

import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import groupby
from math import isfinite
from typing import Any

import click

from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.command_line.main import RUN_FAILED
from vibsim.command_line.options import CHECK, Settings, examples
from vibsim.command_line.terminal import Progress, print_json, say, style
from vibsim.evidence.verification.catalogue import all_checks, rows_of, selected
from vibsim.evidence.verification.checks import Check, CheckPoint, CheckRow
from vibsim.signals import Interruption


@click.command(
    "verify",
    short_help="Verify this installation against known cases.",
    epilog=examples(
        "vibsim verify                        # everything",
        "vibsim verify V3 V7                  # the bilinear oscillator, Coulomb friction",
        "vibsim verify hard/stiff -v          # and where the bounds come from",
        "vibsim verify --list",
        "vibsim verify hard --json | jq '.rows[] | select(.verdict != \"ok\")'",
        "vibsim run hard/stiff-stop           # a hard case as any other",
        before="Expected are closed forms, published figures, conservation laws, and for the hard cases runs "
        "of 40 digits that come with vibsim. Bounds follow from rounding and from the conditioning of each "
        "motion.",
    ),
)
@click.argument("names", metavar="[NAME]...", nargs=-1, type=CHECK)
@click.option("--list", "list_checks", is_flag=True, help="List the checks, or those named, and stop.")
@click.pass_context
def command(
    ctx: click.Context,
    names: tuple[str, ...],
    list_checks: bool,
) -> int:
    """Compute cases with known results, V1 to V32 and the hard ones, and print expected, obtained, error and
    bound of each.

    NAME is a check or how it begins; without any, all are computed. Exit code 4 where an error is not within
    its bound.
    """
    from vibsim.evidence.verification import UnknownCheckError

    try:
        chosen = selected(all_checks(), names)
    except UnknownCheckError as error:
        raise click.UsageError(str(error)) from error
    if list_checks:
        print_list(chosen, ctx.obj)
        return 0
    return print_verification(chosen, ctx.obj)


# The verification as a table for people, and as JSON for programs.


HEADER = ("", "expected", "obtained", "error", "bound", "verdict")


def print_list(checks: Sequence[Check], settings: Settings) -> None:
    """Name and title of each check."""
    if settings.json:
        print_json([{"name": check.name, "title": check.title} for check in checks])
        return
    width = max(len(check.name) for check in checks)
    for check in checks:
        say(f"{check.name:{width}}  {check.title}")


def print_verification(checks: Sequence[Check], settings: Settings) -> int:
    """Compute the checks and print their rows; returns the exit code. Interrupted, it prints what it has."""
    began = time.perf_counter()
    with Interruption() as interruption:
        rows = list(_computed(checks, interruption, Progress(not settings.quiet)))
    took = time.perf_counter() - began
    if settings.json:
        print_json(_described(rows, took))
    else:
        print_table(rows, {check.name: check.title for check in checks}, settings)
        _print_verdict(rows, took, settings)
    if interruption.signum is not None:
        done = len({row.check for row in rows})
        say(
            f"interrupted after {done} of {counted(len(checks), 'check')}; more: vibsim verify NAME...",
            err=True,
        )
        return interruption.exit_code
    return 0 if all(row.passed for row in rows) else RUN_FAILED


def _computed(checks: Sequence[Check], interruption: Interruption, progress: Progress) -> Iterator[CheckRow]:
    """The rows of the checks, with a bar, until an interruption; a check that is under way is given up."""
    with suppress(KeyboardInterrupt), progress:
        for done, check in enumerate(checks):
            progress.show("verifying", done, len(checks))
            if interruption.signum is not None:
                return
            yield from rows_of([check])
        progress.show("verifying", len(checks), len(checks))


def print_table(rows: Sequence[CheckRow], titles: dict[str, str], settings: Settings) -> None:
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


def _cells(row: CheckRow) -> tuple[str, ...]:
    verdict = "ok" if row.passed else "FALLS SHORT"
    return row.what, row.expected, row.obtained, number(row.error, 2), number(row.bound, 2), verdict


def _line(cells: Sequence[str], widths: Sequence[int], row: CheckRow | None = None) -> str:
    what, *numbers, verdict = cells
    aligned = [number.rjust(width) for number, width in zip(numbers, widths[1:-1], strict=True)]
    if row is not None:
        verdict = style(verdict, fg="green" if row.passed else "red")
    return "  ".join(["", what.ljust(widths[0]), *aligned, verdict])


def _print_verdict(rows: Sequence[CheckRow], took: float, settings: Settings) -> None:
    wrong = sum(not row.passed for row in rows)
    if wrong:
        text = f"{wrong} of {counted(len(rows), 'number')} fall short of their bounds"
        say(f"{style(text, fg='red')} ({took:.1f} s)")
    elif not settings.quiet:
        text = f"{counted(len(rows), 'number')}, all within their bounds"
        say(f"{style(text, fg='green')} ({took:.1f} s)")


def _described(rows: Sequence[CheckRow], took: float) -> dict[str, Any]:
    """The verification as JSON; what is no number is null."""
    return {
        "rows": [_described_row(row) for row in rows],
        "passed": sum(row.passed for row in rows),
        "fallen_short": [row.name for row in rows if not row.passed],
        "seconds": took,
    }


def _described_row(row: CheckRow) -> dict[str, Any]:
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


def _described_point(point: CheckPoint) -> dict[str, Any]:
    numbers = ("expected", "obtained", "error", "bound")
    return {
        "what": point.what,
        **{name: _number(getattr(point, name)) for name in numbers},
        "unit": point.unit,
    }


def _number(value: float) -> float | None:
    return float(value) if isfinite(value) else None
