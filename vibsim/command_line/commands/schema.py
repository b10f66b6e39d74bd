"""vibsim schema: the JSON Schema by which editors check a case file while it is written."""

import click

from vibsim.command_line.options import examples
from vibsim.command_line.terminal import print_json


@click.command(
    "schema",
    short_help="Print the JSON Schema of a case file.",
    epilog=examples(
        "vibsim schema > vibsim-case.json",
        "# then, as the first line of a case file, for editors that know the YAML language server:",
        "# yaml-language-server: $schema=vibsim-case.json",
    ),
)
def command() -> None:
    """Print the JSON Schema of a case file: keys, units, ranges, defaults.

    Editors that know JSON Schema use it to complete keys and to mark mistakes while you type.
    """
    from vibsim.cases import case_schema

    print_json(case_schema(), indent=2)
