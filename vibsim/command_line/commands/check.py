"""vibsim check: are these case files right, and if not, what is wrong with them?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from vibsim.cases.problems import counted, listed
from vibsim.cases.quantities import number
from vibsim.command_line.main import INVALID_CASE
from vibsim.command_line.options import Settings, examples
from vibsim.command_line.terminal import print_json, say, style
from vibsim.physics.connections import reads_time

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.cases.problems import Problem
    from vibsim.cases.validation import Fact

    Report = tuple[str, Case | None, Sequence[Problem]]


@click.command(
    "check",
    short_help="Check case files.",
    epilog=examples(
        "vibsim check my.yaml",
        "vibsim check cases/*.yaml --json",
        "vibsim check -v II-B               # with natural frequencies and the friction band",
        "vibsim cases II-B | sed 's/5.5 Hz/6 Hz/' | vibsim check -",
    ),
)
@click.argument("sources", metavar="CASE...", nargs=-1, required=True)
@click.pass_context
def command(
    ctx: click.Context,
    sources: tuple[str, ...],
) -> int:
    """Check each CASE (a YAML file, a shipped name, or - for standard input) and print every problem found.

    Exit code 3 where any of them is invalid. With -v, print what the numbers imply.
    """
    reports = [_checked(source) for source in sources]
    if ctx.obj.json:
        print_json([_described(report) for report in reports], indent=2)
    else:
        for report in reports:
            _print(report, ctx.obj)
    return INVALID_CASE if any(problems for _, _, problems in reports) else 0


def _checked(source: str) -> Report:
    """(source, case, problems): the case, or what is wrong with it."""
    from vibsim.cases import CaseError, load_case

    try:
        return source, load_case(source), []
    except CaseError as error:
        return source, None, error.problems


def _print(report: Report, settings: Settings) -> None:
    source, case, problems = report
    for line in listed(problems):
        say(line)
    if case is None:
        say(f"{source}: {style('invalid', fg='red')}, {counted(len(problems), 'problem')}")
    elif not settings.quiet:
        say(f"{source}: {style('ok', fg='green')} ({case.name}: {_summary(case)})")
        if settings.verbose:
            _print_facts(case)


def _summary(case: Case) -> str:
    frequency, kind = case.frequency(), case.source_kind
    t_end, every = case.quantity("run.t_end"), case.quantity("run.every")
    steady = {"none": "no excitation", "constant": "constant forces", "formula": "forces by formulas"}
    source = steady.get(kind) or f"{kind} {frequency or ''}".strip()
    if kind == "none" and reads_time(case.scene()):
        source = "formulas of the time"
    return f"{source}, {t_end} every {every}"


def _print_facts(case: Case) -> None:
    for fact in _facts(case):
        say(f"  {fact.name:<22} {number(fact.value, 6):>12} {fact.unit:<3} {fact.meaning}")


def _facts(case: Case) -> Sequence[Fact]:
    from vibsim.cases.validation import derived_facts

    return derived_facts(case.scene())


def _described(report: Report) -> dict[str, Any]:
    """One report as JSON."""
    source, case, problems = report
    facts = {"source": source, "valid": not problems, "problems": [vars(problem) for problem in problems]}
    if case is not None:
        facts |= {"name": case.name, "sha256": case.sha256, "resolved": json.loads(case.resolved_json())}
        facts["facts"] = {fact.name: {"value": fact.value, "unit": fact.unit} for fact in _facts(case)}
    return facts
