"""The command reference: what `--help` says of every command, as one page."""

import inspect

import click

from from_code.markdown import code, fence, plain, table, with_code
from vibsim.command_line.main import COMMANDS, group

HEAD = """# Commands

What `vibsim COMMAND --help` says, in one place. [Exit codes](exit-codes.md) stand apart.
"""


def page() -> str:
    """The page of all commands."""
    context = click.Context(group, info_name="vibsim")
    everywhere = {name for parameter in group.params for name in parameter.opts}
    sections = [_section(name, context, everywhere) for name in COMMANDS]
    return "\n".join([HEAD, _options_of_all(group, context), *sections])


def _options_of_all(command: click.Group, context: click.Context) -> str:
    return "## Options of every command\n\n" + _options(command.params, context)


def _section(name: str, parent: click.Context, everywhere: set[str]) -> str:
    command = group.get_command(parent, name)
    context = click.Context(command, info_name=name, parent=parent)
    own = [
        parameter
        for parameter in command.params
        if isinstance(parameter, click.Option) and not everywhere & {*parameter.opts}
    ]
    parts = [
        f"## vibsim {name}",
        fence(" ".join([context.command_path, *command.collect_usage_pieces(context)]), "sh"),
        _prose(command.help or ""),
        _options(own, context) if own else "",
        _examples(command.epilog or ""),
    ]
    return "\n\n".join(filter(None, parts)) + "\n"


def _options(parameters: list[click.Parameter], context: click.Context) -> str:
    records = filter(None, (parameter.get_help_record(context) for parameter in parameters))
    return table(("option", ""), [(code(option), plain(text)) for option, text in records])


def _prose(text: str) -> str:
    """A help text: paragraphs filled, those marked with \\b as they are."""
    blocks = inspect.cleandoc(text).split("\n\n")
    return "\n\n".join(
        fence(block.removeprefix("\b\n")) if block.startswith("\b") else with_code(block) for block in blocks
    )


def _examples(epilog: str) -> str:
    """The examples behind a help text, as a block for the shell."""
    _, _, lines = epilog.partition("Examples:\n")
    return "Examples:\n\n" + fence(inspect.cleandoc("\n" + lines), "sh") if lines else ""
