"""What `vibsim fit` does: make the plan, run it with progress and interruption, say what came of it."""

import time
from collections.abc import Iterable, Sequence
from typing import Any

import click

from vibsim.command_line.jobs.run_plan import read_case
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import Progress
from vibsim.command_line.text.going_on import goes_on
from vibsim.command_line.text.quantities import size
from vibsim.command_line.text.summary import print_lines
from vibsim.files.signals import interrupted_with
from vibsim.fitting.description import Table, facts, fit_lines, ranking_table
from vibsim.fitting.errors import FitError
from vibsim.fitting.fit_result import FitResult
from vibsim.fitting.fitting import make_plan, run_fit
from vibsim.fitting.goals.grammar import PHRASES
from vibsim.fitting.goals.observables import OBSERVABLES
from vibsim.fitting.goals.plan import FitPlan, Search

Pairs = Sequence[tuple[str, Any]]


def read_plan(
    sources: Sequence[str],
    values: dict[str, str],
    statements: Sequence[str],
    free: Pairs,
    prices: Pairs,
    readings: Sequence[str],
    ensemble: int,
    spreads: Pairs,
    settings: dict[str, Any],
) -> FitPlan:
    """The plan that the options describe.

    Raises CaseError and ResultFileError for the cases, UsageError for everything else.
    """
    if not sources:
        raise click.UsageError("give at least one CASE, or --list")
    cases = [read_case(source, values) for source in sources]
    for name, pairs in (("free", free), ("spread", spreads), ("leave", prices)):
        keys = [key for key, _ in pairs]
        if len(set(keys)) < len(keys):
            raise click.UsageError(
                f"--{name}: {next(key for key in keys if keys.count(key) > 1)} is given twice"
            )
    try:
        return make_plan(
            cases, dict(free), statements, readings, dict(prices), ensemble, dict(spreads), Search(**settings)
        )
    except FitError as error:
        raise click.UsageError(str(error)) from None


def run_job(
    plan: FitPlan, output: str, jobs: int | None, engine: str, force: bool, settings: Settings
) -> int:
    """Run or complete a fit; returns the exit code."""
    began, steps = time.perf_counter(), Progress(not settings.quiet, listed=True)
    remedy = goes_on(output)
    with Interruption() as interruption, interrupted_with(lambda: remedy):

        def watch(step: str, done: int, total: int) -> bool:
            steps.show(step, done, total)
            return interruption.signum is None

        try:
            fit, complete = run_fit(plan, output, jobs, engine, force, watch)
        finally:
            steps.close()
    if settings.json:
        print_json({"file": output, **facts(fit)})
    elif not settings.quiet:
        print_fit(fit, (f"{output} ({size(output)}), {time.perf_counter() - began:.1f} s"))
    if not complete:
        say(f"interrupted: {remedy}", err=True)
        return interruption.exit_code
    return 0


def print_fit(fit: FitResult, file: str, more: Iterable[tuple[str, str]] = ()) -> None:
    """Lines, then the ranking as a table, then more lines and the file."""
    print_lines(fit_lines(fit))
    print_table(ranking_table(fit))
    if fit.plan.free and fit.plan.fresh_starts:
        say("  from fresh starts; * from those by which it was chosen; - does not hold")
    print_lines([*more, ("file", file)])


def print_table(table: Table) -> None:
    """Columns as wide as they need be, texts left, numbers right."""
    heads, rows = table
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    for row in (heads, *rows):
        cells = [
            text.ljust(width) if i == 1 else text.rjust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        say(f"  {'  '.join(cells)}".rstrip())


def words_listed(settings: Settings) -> int:
    """Print what a statement can be about."""
    table: dict[str, dict[str, Any]] = {}
    for phrase in PHRASES:
        observable = OBSERVABLES[phrase.name]
        table[phrase.words] = {
            "takes": "nothing" if observable.words else f"a range of {observable.dimension}",
            "span": observable.windowed,
            "definition": observable.definition,
        }
    if settings.json:
        print_json(table)
        return 0
    width = max(map(len, table))
    for words, entry in table.items():
        span = ", a span of time" if entry["span"] else ""
        say(f"{words:<{width}}  [{entry['takes']}{span}] {entry['definition']}")
    return 0
