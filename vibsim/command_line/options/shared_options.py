"""Options that several commands have, each written once."""

from collections.abc import Callable
from typing import Any

import click

from vibsim.command_line.options.parameters import FILE, KEY_SPREAD, OneOf, once_each

Decorator = Callable[[Any], Any]
ENGINES = ("auto", "c", "python")

engine_option = click.option(
    "--engine", type=OneOf(ENGINES), default="auto", help="Engine that computes; results are the same."
)
every_end_option = click.option("--t-end", metavar="TIME", help="End of every run, such as 100s.")
stored_force_option = click.option(
    "--force", is_flag=True, help="Replace an output file that holds something else."
)


def jobs_option(what: str) -> Decorator:
    """-j; what : what is computed at a time, "Runs" or "Points"."""
    return click.option(
        "-j",
        "--jobs",
        type=click.IntRange(min=1),
        metavar="N",
        help=f"{what} at a time. [default: all cores]",
    )


def output_option(default: str) -> Decorator:
    """-o; default : the name of the file, in words."""
    return click.option(
        "-o", "--output", type=FILE, metavar="FILE", help=f"Output file. [default: {default}]"
    )


def spread_option(over: str) -> Decorator:
    """--spread, each key once; over : what it varies, "the ensemble" or "the starts"."""
    return click.option(
        "--spread", "spreads", metavar="KEY=HOW", multiple=True, callback=once_each, type=KEY_SPREAD,
        help=f"What varies over {over}: WIDTH (uniform, either side of the case's value), FROM:TO, or "
        "'normal DEVIATION'; repeatable. [default: the motor's phi, over the full turn]",
    )  # fmt: skip
