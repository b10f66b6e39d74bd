"""vibsim fit: which values make cases do what is said of them."""

import time
from collections.abc import Iterable, Sequence
from typing import Any

import click

from vibsim.command_line.commands.run import read_case, to_be_completed
from vibsim.command_line.options import (
    CASE,
    OneOf,
    PairType,
    Settings,
    count_option,
    every_end_option,
    examples,
    jobs_option,
    joined,
    output_option,
    set_option,
    some_text,
    spread_option,
    stored_force_option,
)
from vibsim.command_line.terminal import Progress, print_json, say
from vibsim.command_line.text import goes_on, print_columns, print_lines, size
from vibsim.fitting.fit_result import FitResult, facts, fit_lines, ranking_table, run_fit
from vibsim.fitting.measures import VIBRATION, FitError, observable_of
from vibsim.fitting.plan import FitPlan, Search, make_plan
from vibsim.fitting.statements import PHRASES, Phrase
from vibsim.signals import Interruption, interrupted_with

FREE = PairType("KEY=FROM:TO, such as J=0.5:20g.m^2", some_text)


@click.command(
    "fit",
    short_help="Find values under which cases do what is said of them.",
    epilog=examples(
        "vibsim fit II-B --free c=0.001:0.05 --want 'captured until the end'",
        "vibsim fit II-B II-C --free J=0.5:20g.m^2 --free c=0.001:0.05 --want 'II-B: captured until the end' "
        "--want 'II-C: passes 4.5 Hz between 80 and 120 s' --want 'II-C: settles between 6.1 and 6.3 Hz'",
        "vibsim fit II-B --free J=0.5:20g.m^2 --free c=0.001:0.05 --at-most 1 --want 'held for at least 9 s'",
        "vibsim fit II-B --try 'J=0.006, c=0.005' --try J=0.01 --want 'captured until the end'",
        "vibsim fit I-C --free omega=5:8Hz --ensemble 0 --want 'chaotic' --want 'drift rate above 0.1 mm/s'",
        "vibsim fit II-B-fit.h5                        # complete it by the plan that it holds",
        "vibsim plot II-B-fit.h5",
        before="A statement is [CASE:] WHAT [RANGE] [over A to B s] [from P % of the starts] [, weight N]; "
        "--list names what it can be about. An interrupted fit is resumed by the same command, or by its "
        "file alone.",
    ),
)
@click.argument("sources", metavar="CASE...", nargs=-1, type=CASE)
@click.option(
    "--want", "statements", metavar="STATEMENT", multiple=True, help="What runs should do; repeatable."
)
@click.option(
    "--free", "free", metavar="KEY=RANGE", multiple=True, type=FREE,
    help="A number to change; 'log FROM:TO' divides by ratio, 'linear FROM:TO' in equal steps; repeatable.",
)  # fmt: skip
@click.option(
    "--leave", "prices", metavar="KEY=PENALTY", multiple=True,
    type=PairType("KEY=PENALTY, such as J=0.05", float),
    help="Penalty for a factor of 10 from the printed value (or the width, in equal steps). [default: 0.1]",
)  # fmt: skip
@click.option(
    "--try", "readings", metavar="KEY=VALUE,...", multiple=True, help="Values to judge as well; repeatable."
)
@count_option("--ensemble", "Starts that are drawn, besides each case's own.", default=8)
@spread_option("the starts")
@click.option(
    "--method", type=OneOf(["quasi-random", "evolution"]), default="quasi-random", show_default=True,
    help="Sobol points, or differential evolution.",
)  # fmt: skip
@count_option("--candidates", "How many are tried.", default=256)
@count_option(
    "--at-most",
    "Change so many at a time, in every combination. [default: all together]",
    least=1,
    metavar="K",
)
@count_option(
    "--screen",
    "Starts that quasi-random candidates are judged from first; the best quarter is from all.",
    default=2,
    least=1,
)
@count_option("--confirm", "Judge so many of the best again, from fresh starts.", default=3, metavar="K")
@count_option("--fresh", "Number of the fresh starts.", default=24)
@count_option("--seed", "Seed of all random draws.", default=0, metavar="S")
@click.option("--list", "list_words", is_flag=True, help="List what a statement can be about, and stop.")
@set_option
@every_end_option
@click.option("--every", metavar="TIME", help="Sampling of the runs; as the cases say unless given.")
@jobs_option("Runs")
@output_option("CASE-fit.h5")
@stored_force_option
@click.pass_context
def command(
    ctx: click.Context,
    /,
    sources: tuple[str, ...],
    statements: tuple[str, ...],
    free: tuple[tuple[str, str], ...],
    prices: tuple[tuple[str, float], ...],
    readings: tuple[str, ...],
    ensemble: int,
    spreads: tuple[tuple[str, str], ...],
    list_words: bool,
    changes: tuple[tuple[str, str], ...],
    t_end: str | None,
    every: str | None,
    jobs: int | None,
    output: str | None,
    force: bool,
    **settings: Any,
) -> int:
    """Find values under which the runs of CASE do what statements say of them, judged from many starts.

    CASE is a YAML file, the name of a shipped case, - for standard input, or an HDF5 file of `vibsim run`. Of
    several cases each statement names one; what is changed is changed in all of them. The file of a fit,
    given alone, is completed.
    """

    if list_words:
        return words_listed(ctx.obj)
    run_settings = {"run.t_end": t_end, "run.every": every}
    values = joined(changes, run_settings)
    if len(sources) == 1 and not statements:
        stored = to_be_completed(sources[0], ("fit",), ctx)
        if stored is not None:
            return run_job(stored.plan, output or sources[0], jobs, force, ctx.obj)
    plan = read_plan(sources, values, statements, free, prices, readings, ensemble, spreads, settings)
    name = "-".join(case.name for case in plan.cases)
    return run_job(plan, output or f"{name}-fit.h5", jobs, force, ctx.obj)


# What `vibsim fit` does: make the plan, run it with progress and interruption, say what came of it.


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


def run_job(plan: FitPlan, output: str, jobs: int | None, force: bool, settings: Settings) -> int:
    """Run or complete a fit; returns the exit code."""
    began, remedy = time.perf_counter(), goes_on(output)
    steps = Progress(not settings.quiet, listed=True)
    with Interruption() as interruption, interrupted_with(lambda: remedy), steps:

        def watch(step: str, done: int, total: int) -> bool:
            steps.show(step, done, total)
            return interruption.signum is None

        fit, complete = run_fit(plan, output, jobs, force, watch)
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
    heads, rows = ranking_table(fit)
    print_lines(fit_lines(fit))
    print_columns([heads, *rows], right=[i for i in range(len(heads)) if i != 1])
    if fit.plan.free and fit.plan.fresh_starts:
        say("  from fresh starts; * from those by which it was chosen; - does not hold")
    print_lines([*more, ("file", file)])


def words_listed(settings: Settings) -> int:
    """Print what a statement can be about."""
    table: dict[str, dict[str, Any]] = {}
    named = Phrase(f"{VIBRATION}x_P - x_Q", f"{VIBRATION}x_P - x_Q, or of x_P, of named bodies,")
    for phrase in (*PHRASES, named):
        observable = observable_of(phrase.name)
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
