"""The command `vibsim`: a group whose commands are imported when they are called."""

import errno
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import takewhile
from typing import Any

import click

from vibsim import __version__, signals
from vibsim.command_line.options import (
    Settings,
    add_global_options,
    examples,
    global_options,
    refuse_unclear,
)
from vibsim.command_line.terminal import in_shell, open_closed_streams, print_json, problem_in_shell, say
from vibsim.lazy import named
from vibsim.signals import Terminated, ended_by_signals, forget_alarm, heard_from_now_on


class Interrupted(Exception):
    """The command was interrupted and no message of it is printed yet; its text names what was not done."""

    def __init__(self, text: str, by_sigterm: bool = False):
        super().__init__(text)
        self.by_sigterm = by_sigterm


@contextmanager
def interruption_named() -> Iterator[None]:
    """Say Interrupted for a KeyboardInterrupt, which click would take for its own."""
    try:
        yield
    except KeyboardInterrupt as error:
        forget_alarm()
        text = f"interrupted: {error}" if str(error) else "interrupted"
        raise Interrupted(text, isinstance(error, Terminated)) from error


# From exceptions to messages and exit codes.


INVALID_CASE, RUN_FAILED, FAILED_POINTS, FILE_TROUBLE = 3, 4, 5, 6
INTERRUPTED, BROKEN_PIPE, TERMINATED = 130, 141, 143

EXIT_CODES = {
    0: "done",
    1: "a bug: a traceback; please report it",
    click.UsageError.exit_code: "a command line that cannot be followed",
    INVALID_CASE: "an invalid case, or none of that name",
    RUN_FAILED: "a run, or a check of `verify`, failed",
    FAILED_POINTS: "a sweep ended with failed points",
    FILE_TROUBLE: "a result file is missing, damaged, in the way or cannot be written",
    INTERRUPTED: "interrupted by Ctrl-C; everything finished so far is kept",
    BROKEN_PIPE: "nobody reads the output any more",
    TERMINATED: "interrupted by SIGTERM; everything finished so far is kept",
}


NOWHERE: Mapping[str, str] = {}


class OutputClosed(Exception):
    """Nobody reads stdout any more."""


@contextmanager
def broken_pipe_named() -> Iterator[None]:
    """Say OutputClosed for a broken pipe, which click would take for a failure."""
    try:
        yield
    except BrokenPipeError as error:
        raise OutputClosed from error


def exit_code_of(
    action: Callable[[], Any], as_json: bool = False, places: Mapping[str, str] = NOWHERE
) -> int:
    """Run `action` and say what went wrong; returns the exit code. A bug is raised on.

    Errors go to stderr, and where `as_json` to stdout too, as an object with the key `error`.
    places : options that gave values of a case, by their keys; read when `action` has failed
    """
    try:
        result = action()
        with broken_pipe_named():
            sys.stdout.flush()
    except click.ClickException as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # click 8.2 and later: its message is the help
            return told(error.format_message().splitlines(), error.exit_code, as_json)
        _say_usage(error)
        return told(f"Error: {_message(error)}", error.exit_code, as_json)
    except (click.Abort, KeyboardInterrupt):
        forget_alarm()
        return told("interrupted", INTERRUPTED, as_json)
    except Interrupted as error:
        return told(str(error), TERMINATED if error.by_sigterm else INTERRUPTED, as_json)
    except OutputClosed:
        _discard_stdout()
        return BROKEN_PIPE
    except OSError as error:
        return _output_failed(error)
    except Exception as error:
        code = code_for(error)
        if code is None:
            raise
        return report(error, code, as_json, places)
    return result if isinstance(result, int) else 0


def code_for(error: Exception) -> int | None:
    """Exit code of an error that is the user's to mend; None for a bug."""
    from vibsim.cases import CaseError
    from vibsim.engine.errors import EngineError
    from vibsim.fitting.measures import FitError
    from vibsim.orbits.branches.correction import ContinuationError
    from vibsim.orbits.branches.plan import BranchError
    from vibsim.orbits.coordinates import NoSection, OrbitError
    from vibsim.plots.subject import PlotError
    from vibsim.results import ResultFileError
    from vibsim.sweeps.sweep_plan import PlanError
    from vibsim.sweeps.workers import ClusterError

    codes: dict[type[Exception], int] = {
        CaseError: INVALID_CASE,
        EngineError: RUN_FAILED,
        PlotError: click.UsageError.exit_code,
        ResultFileError: FILE_TROUBLE,
        ClusterError: RUN_FAILED,
        PlanError: click.UsageError.exit_code,
        BranchError: click.UsageError.exit_code,
        ContinuationError: RUN_FAILED,
        FitError: click.UsageError.exit_code,
        NoSection: click.UsageError.exit_code,
        OrbitError: RUN_FAILED,
    }
    return next((code for kind, code in codes.items() if isinstance(error, kind)), None)


def report(error: Exception, code: int, as_json: bool, places: Mapping[str, str]) -> int:
    """Tell an error of the user's: the lines of a CaseError as they are, others after `Error:`."""
    from vibsim.cases import CaseError
    from vibsim.cases.problems import listed

    if not isinstance(error, CaseError):
        return told(f"Error: {error}", code, as_json)
    problems = [problem_in_shell(problem, places) for problem in error.problems]
    return told(listed(problems), code, as_json, problems=[vars(one) for one in problems])


def told(text: str | list[str], code: int, as_json: bool, **more: Any) -> int:
    """Print an error on stderr, and as JSON on stdout where that is asked for; returns its exit code.

    text : its line, or its lines
    """

    lines = [in_shell(line) for line in ([text] if isinstance(text, str) else text)]
    for line in lines:
        say(line, err=True)
    if as_json:
        message = "\n".join(lines).removeprefix("Error: ")
        with broken_pipe_named():
            print_json({"error": {"message": message, "exit_code": code, **more}})
            sys.stdout.flush()
    return code


def _say_usage(error: click.ClickException) -> None:
    """The usage line of the command, and where its help is."""

    ctx = getattr(error, "ctx", None)
    if ctx is not None:
        say(f"{ctx.get_usage()}\nTry '{ctx.command_path} --help' for help.\n", err=True, lines=True)


def _message(error: click.ClickException) -> str:
    """The message of click, with the nearest option in place of those that it takes for near."""
    from vibsim.cases.problems import nearest

    if isinstance(error, click.NoSuchOption):
        parameters = error.ctx.command.get_params(error.ctx) if error.ctx else []
        options = [name for parameter in parameters for name in parameter.opts if name.startswith("--")]
        near = nearest(error.option_name, options)
        return f"no option {error.option_name}" + (f"; did you mean {near}?" if near else "")
    return error.format_message()


def _output_failed(error: OSError) -> int:
    """Stdout is on a full disk; any other OSError is a bug."""
    if error.errno == errno.ENOSPC and error.filename is None:
        _discard_stdout()
        return told("Error: stdout: disk full", FILE_TROUBLE, as_json=False)
    raise error


def _discard_stdout() -> None:
    """Send what is still buffered for stdout nowhere: at its end the interpreter would complain."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


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
        "edge": ("edge", "Find what lies between two attractors: the saddle on their boundary."),
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
        refuse_unclear(command)
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
        settings = extra.setdefault("obj", Settings())
        run: Callable[..., Any] = partial(super().main, *args, standalone_mode=False, **extra)
        if not standalone_mode:
            return run()
        words = args[0] if args and args[0] is not None else extra.get("args") or sys.argv[1:]
        sys.exit(exit_code_of(run, _wants_json(words), settings.places))


def _wants_json(words: Sequence[str]) -> bool:
    """Whether a command line has --json, even where it cannot be understood."""
    options = takewhile(lambda word: word != "--", words)
    return "--json" in options


def _hint(name: str) -> str:
    from vibsim.cases.problems import nearest

    if name.endswith((".yaml", ".yml")):
        return f"; to run the case: vibsim run {name}"
    if name.endswith((".h5", ".hdf5")):
        return f"; to see what it holds: vibsim info {name}"

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
refuse_unclear(group)


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
        try:
            ended_by_signals()
        except KeyboardInterrupt:  # another one, while the command ended
            ended_by_signals()
        gc.freeze()  # the system takes all memory back at once; sorting it before the end takes 30 ms
