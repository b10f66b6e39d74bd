"""vibsim info: what a result file holds."""

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import FILE


@click.command(
    "info",
    short_help="Say what a result file holds.",
    epilog=examples(
        "vibsim info II-B.h5",
        "vibsim info runs/*.h5 --json | jq .impacts",
        "vibsim info II-B.h5 --case > again.yaml       # the case file as it was given",
    ),
)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@click.option("--case", "case_only", is_flag=True, help="Print the case file that was run, and nothing else.")
@click.pass_context
def command(
    ctx: click.Context,
    files: tuple[str, ...],
    case_only: bool,
) -> None:
    """Say what each result FILE holds, where it comes from and what came of the run."""
    from vibsim.command_line.text.describe import print_case, print_description

    for path in files:
        if case_only:
            print_case(path, ctx.obj)
        else:
            print_description(path, ctx.obj)
