"""vibsim paper: every figure and claim of the paper, reproduced and audited."""

from __future__ import annotations

from typing import Any

import click

from vibsim.command_line.options.examples import examples

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
    from vibsim.command_line.jobs.paper import write_report

    return write_report(folder, formats, fresh, ctx.obj)
