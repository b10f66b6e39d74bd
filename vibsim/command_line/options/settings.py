"""The options that every command has: -v, -q, --json, --color. They may stand before or after its name."""

import os
from dataclasses import dataclass
from typing import Any

import click

from vibsim.command_line.options.parameters import OneOf


@dataclass
class Settings:
    """What the global options say; `ctx.obj` of every command.

    verbose : print more; quiet : print nothing but errors; json : results as JSON on stdout
    """

    verbose: bool = False
    quiet: bool = False
    json: bool = False
    color: str = "auto"


def global_options() -> list[click.Option]:
    """New copies of the global options; they fill in `ctx.obj` and are not passed to the command."""

    def option(*names: str, **rest: Any) -> click.Option:
        return click.Option(names, expose_value=False, callback=_remember, default=None, **rest)

    return [
        option("-v", "--verbose", is_flag=True, help="Print more."),
        option("-q", "--quiet", is_flag=True, help="Print nothing but errors."),
        option("--json", is_flag=True, help="Print results as JSON."),
        option(
            "--color",
            type=OneOf(["auto", "always", "never"]),
            help="Color the output; auto: on a terminal, unless NO_COLOR is set.",
        ),
    ]


def add_global_options(command: click.Command) -> None:
    """Let a command take the global options after its name, except those that it defines itself."""
    taken = {name for parameter in command.params for name in parameter.opts}
    command.params += [option for option in global_options() if not taken.intersection(option.opts)]


def _remember(ctx: click.Context, option: click.Parameter, value: Any) -> None:
    settings = ctx.ensure_object(Settings)
    if value is not None and option.name is not None:
        setattr(settings, option.name, value)
    ctx.color = _wants_color(settings.color)


def _wants_color(choice: str) -> bool | None:
    """For click: True or False, or None to color on a terminal."""
    if choice == "auto":
        return False if os.environ.get("NO_COLOR") else None
    return choice == "always"
