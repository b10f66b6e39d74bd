"""The command `vibsim`: a group whose commands are imported when they are called."""

import sys
from collections.abc import Callable, Sequence
from functools import partial
from itertools import takewhile
from typing import Any

import click

from vibsim import __version__
from vibsim.command_line.errors import INTERRUPTED, broken_pipe_named, exit_code_of
from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.repeated_options import refuse_repeated
from vibsim.command_line.options.settings import add_global_options, global_options
from vibsim.command_line.terminal.interruption import ended_by_signals, heard_from_now_on, interruption_named
from vibsim.command_line.terminal.standard_streams import open_closed_streams
from vibsim.files import signals
from vibsim.lazy_names import named

# heading -> name -> (module of commands/, one line); the list is printed without importing any of them
LISTED = {
    "Cases": {
        "cases": ("cases", "List the shipped cases, or print one."),
        "new": ("new", "Begin a case file of your own."),
        "check": ("check", "Check case files."),
        "schema": ("schema", "Print the JSON Schema of a case file."),
    },
    "Motions": {
        "run": ("run", "Run cases and write their trajectories."),
        "sweep": ("sweep", "Run a case at every point of a grid."),
        "orbit": ("orbit", "Find periodic motions, stable or not, and their multipliers."),
        "continue": ("continuation", "Follow a periodic orbit over a parameter."),
        "fit": ("fit", "Find values under which cases do what is said of them."),
    },
    "Results": {
        "plot": ("plot", "Draw pictures of runs, cases and sweeps."),
        "animate": ("animate", "Show the machine of a run, moving."),
        "info": ("info", "Say what a result file holds."),
        "analyse": ("analyse", "Judge runs: capture, drift, impacts, regime, frequencies."),
        "compare": ("compare", "Compare two runs."),
        "export": ("export", "Write a result as CSV, Parquet or MAT."),
    },
    "Evidence": {
        "verify": ("verify", "Verify this installation against known cases."),
        "bench": ("bench", "Measure speed against error, beside other solvers."),
        "paper": ("paper", "Reproduce and audit the paper."),
    },
}
COMMANDS = {name: told for commands in LISTED.values() for name, told in commands.items()}

COMPLETION = (
    'Shell completion: put  eval "$(_VIBSIM_COMPLETE=bash_source vibsim)"  into ~/.bashrc '
    "(zsh_source for zsh, fish_source for fish)."
)

# What numpy starts unless told otherwise: threads for large matrices, which vibsim lacks; they spin while
# they wait (30 ms of a core).
NOT_NEEDED = {"OPENBLAS_NUM_THREADS": "1"}
WITHOUT_WINDOWS = {"MPLBACKEND": "agg"}  # whatever is set: matplotlib refuses to load with a name it has not


class LazyGroup(click.Group):
    """Commands by name; exceptions become messages and exit codes here."""

    owns_the_process = False  # whether `main` began it

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        if self.owns_the_process:
            signals.of_the_command = True
        command: click.Command = named(f"vibsim.command_line.commands.{COMMANDS[cmd_name][0]}:command")
        add_global_options(command)
        refuse_repeated(command)
        return command

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        name = args[0]
        if name not in COMMANDS and not name.startswith("-"):
            ctx.fail(f"no command {name!r}{_hint(name)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        width = max(map(len, COMMANDS))
        for heading, commands in LISTED.items():
            with formatter.section(heading):
                formatter.write_dl([(name.ljust(width), line) for name, (_, line) in commands.items()])

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        with broken_pipe_named(), interruption_named():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        with broken_pipe_named(), interruption_named():
            return super().invoke(ctx)

    def main(self, *args: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        run: Callable[..., Any] = partial(super().main, *args, standalone_mode=False, **extra)
        if not standalone_mode:
            return run()
        words = args[0] if args and args[0] is not None else extra.get("args") or sys.argv[1:]
        sys.exit(exit_code_of(run, _wants_json(words)))


def _wants_json(words: Sequence[str]) -> bool:
    """Whether a command line has --json, even where it cannot be understood."""
    options = takewhile(lambda word: word != "--", words)
    return "--json" in options


def _hint(name: str) -> str:
    if name.endswith((".yaml", ".yml")):
        return f"; to run the case: vibsim run {name}"
    if name.endswith((".h5", ".hdf5")):
        return f"; to see what it holds: vibsim info {name}"
    from vibsim.cases.spelling import nearest

    near = nearest(name, COMMANDS)
    return f"; did you mean {near}?" if near else f"; commands are {', '.join(COMMANDS)}"


group = LazyGroup(
    "vibsim",
    params=[*global_options()],
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    help="Vibro-impact systems with dry friction under ideal and limited-power excitation.",
    epilog=examples(
        "vibsim cases",
        "vibsim run II-B",
        "vibsim run II-B -s Omega0='6.5 Hz' -o faster.h5",
        "vibsim plot II-B.h5",
        before=COMPLETION,
    ),
)
click.version_option(__version__, message="vibsim %(version)s")(group)
refuse_repeated(group)


def main() -> None:
    """The command as a process of its own, which it ends with the exit code."""
    import gc
    import os

    open_closed_streams()
    for name, value in NOT_NEEDED.items():
        os.environ.setdefault(name, value)
    os.environ.update(WITHOUT_WINDOWS)
    gc.set_threshold(100_000)  # starting up makes many objects and no garbage; looking for it takes 30 ms
    heard_from_now_on()
    group.owns_the_process = True
    try:
        group.main(prog_name="vibsim")
    except KeyboardInterrupt:  # another one, while the first was told
        sys.exit(INTERRUPTED)
    finally:
        ended_by_signals()
        gc.freeze()  # the system takes all memory back at once; sorting it before the end takes 30 ms
