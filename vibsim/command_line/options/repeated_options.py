"""An option that is given twice is an error: the second one would silently take the place of the first."""

from collections import Counter
from typing import Any

import click


def refuse_repeated(command: click.Command) -> None:
    """Let a command refuse to be given an option twice that is not meant to be; flags may be."""
    if getattr(command.make_parser, "refuses", False):
        return
    make = command.make_parser

    def make_parser(ctx: click.Context) -> Any:
        parser = make(ctx)
        parse = parser.parse_args

        def parse_args(args: list[str]) -> Any:
            options, rest, order = parse(args)
            for option in _repeated(order):
                name = max(option.opts, key=len)
                raise click.UsageError(f"{name} is given twice, and takes one value", ctx)
            return options, rest, order

        parser.parse_args = parse_args  # type: ignore[method-assign]
        return parser

    make_parser.refuses = True  # type: ignore[attr-defined]
    command.make_parser = make_parser  # type: ignore[method-assign]


def _repeated(order: list[click.Parameter]) -> list[click.Option]:
    """Options that came more than once and keep only one value; --yes/--no pairs are such."""
    return [
        option
        for option, count in Counter(order).items()
        if count > 1 and isinstance(option, click.Option) and not (option.multiple or option.count)
        if not option.is_flag or option.secondary_opts
    ]
