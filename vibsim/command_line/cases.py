"""vibsim cases: the shipped cases."""

import click

from vibsim.command_line.examples import examples
from vibsim.command_line.terminal import print_json, say


@click.command(
    "cases",
    short_help="List the shipped cases, or print one.",
    epilog=examples(
        "vibsim cases",
        "vibsim cases II-B > my.yaml        # a case of your own, to start from",
        "vibsim cases II-B --resolved       # as a scene of named parts, every default filled in",
        "vibsim cases --json",
    ),
)
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option(
    "--resolved", is_flag=True, help="Print the long form: a scene of named parts, defaults filled in."
)
@click.pass_context
def command(ctx, names, resolved):
    """List the cases that come with vibsim, or print the YAML text of those named."""
    from vibsim.cases import load_case, shipped_case_names

    if resolved and not names:
        raise click.UsageError("--resolved prints cases; give the NAME of one")
    cases = [load_case(name) for name in names or shipped_case_names()]
    if ctx.obj.json:
        print_json([_described(case) for case in cases], indent=2)
    elif names:
        texts = [case.long_text() if resolved else case.text for case in cases]
        say("---\n".join(texts), nl=False)
    else:
        _print_table(cases)


def _described(case) -> dict:
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


def _print_table(cases) -> None:
    from vibsim.cases.plain_text import one_line

    rows = [("name", "source", "frequency", "title")]
    rows += [
        (case.name, case.source_kind, str(case.frequency() or "-"), one_line(case.title)) for case in cases
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        say("  ".join([*cells, row[3]]).rstrip())
