"""vibsim cases: the shipped cases, listed, printed or drawn."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibsim.cases.problems import one_line
from vibsim.cases.quantities import number
from vibsim.command_line.options import CASE, FILE, Settings, examples
from vibsim.command_line.terminal import print_json, print_written, say
from vibsim.command_line.text import print_columns

if TYPE_CHECKING:
    from vibsim.cases import Case


@click.command(
    "cases",
    short_help="List the shipped cases, or print one.",
    epilog=examples(
        "vibsim cases",
        "vibsim cases II-B > my.yaml        # a case of your own, to start from",
        "vibsim cases II-B --resolved       # as a scene of named parts, every default filled in",
        "vibsim cases gallery/impact-damper --draw -o damper.pdf",
        "vibsim cases --json",
    ),
)
@click.argument("names", metavar="[NAME]...", nargs=-1, type=CASE)
@click.option(
    "--resolved", is_flag=True, help="Print the long form: a scene of named parts, defaults filled in."
)
@click.option("--draw", is_flag=True, help="Draw the machine instead: bodies, parts and what drives them.")
@click.option("-o", "--output", type=FILE, metavar="FILE", help="The drawing; NAME-machine.png by default.")
@click.option("--force", is_flag=True, help="Replace a drawing that exists.")
@click.pass_context
def command(
    ctx: click.Context,
    names: tuple[str, ...],
    resolved: bool,
    draw: bool,
    output: str | None,
    force: bool,
) -> None:
    """List the cases that come with vibsim, or print the YAML text of those named.

    NAME may be a case file too: `--resolved` and `--draw` show what it comes to.
    """
    from vibsim.cases import gallery_case_names, load_case, shipped_case_names

    _check_options(names, resolved, draw, output, force)
    cases = [load_case(name) for name in names or [*shipped_case_names(), *gallery_case_names()]]
    if draw:
        _draw(ctx.obj, dict(zip(names, cases, strict=True)), output, force)
    elif ctx.obj.json:
        print_json([_described(case) for case in cases], indent=2)
    elif names:
        texts = [case.long_text() if resolved else case.text for case in cases]
        say("---\n".join(texts), nl=False, lines=True)
    else:
        _print_table(cases)


def _check_options(
    names: tuple[str, ...], resolved: bool, draw: bool, output: str | None, force: bool
) -> None:
    """Usage errors of options that do not go together."""
    for option, value in (("--resolved", resolved), ("--draw", draw)):
        if value and not names:
            raise click.UsageError(f"{option} shows cases; give the NAME of one")
    if draw and resolved:
        raise click.UsageError("--draw and --resolved do not go together")
    if not draw and (output is not None or force):
        raise click.UsageError("-o and --force belong to --draw")
    if output is not None and len(names) > 1:
        raise click.UsageError("-o takes one drawing; give one NAME")


def _draw(settings: Settings, cases: dict[str, Case], output: str | None, force: bool) -> None:
    """Draw the machines of the cases; nothing is drawn before every file is checked."""
    from vibsim.plots.machine import draw_machine_file
    from vibsim.plots.picture import check_targets, picture_suffix

    targets = [output or f"{case.name}-machine.png" for case in cases.values()]
    for target in targets:
        picture_suffix(target)
        if targets.count(target) > 1:
            raise click.UsageError(f"two of the cases would be drawn into {target}; draw them one by one")
    check_targets(targets, force)
    written = [
        draw_machine_file(case, name, force) for case, name in zip(cases.values(), targets, strict=True)
    ]
    print_written(settings, written)


def _described(case: Case) -> dict[str, Any]:
    """A case as JSON: what the table shows, and the YAML text."""
    frequency = case.frequency()
    return {
        "name": case.name,
        "title": case.title,
        "source": case.source_kind,
        "frequency": str(frequency) if frequency else None,
        "sha256": case.sha256,
        "yaml": case.text,
        "resolved": case.long_text(),
    }


def _shipped_name(case: Case) -> str:
    """The name by which a shipped case is found: with its folder, where it is in one."""
    folder = Path(case.source).parent.name
    return f"{folder}/{case.name}" if folder == "gallery" else case.name


def _short_frequency(case: Case) -> str:
    """The frequency of the source with six digits and its unit; a dash where there is none."""
    frequency = case.frequency()
    if frequency is None:
        return "-"
    value, _, unit = str(frequency).partition(" ")
    return f"{number(float(value), 6)} {unit}"


def _print_table(cases: Iterable[Case]) -> None:
    rows = [("name", "source", "frequency", "title")]
    rows += [
        (_shipped_name(case), case.source_kind, _short_frequency(case), one_line(case.title))
        for case in cases
    ]
    print_columns(rows, indent="")
