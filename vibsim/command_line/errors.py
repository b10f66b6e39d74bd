"""From exceptions to messages and exit codes."""

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

from vibsim.command_line.terminal.interruption import Interrupted, forget_alarm

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


class OutputClosed(Exception):
    """Nobody reads stdout any more."""


@contextmanager
def broken_pipe_named() -> Iterator[None]:
    """Say OutputClosed for a broken pipe, which click would take for a failure."""
    try:
        yield
    except BrokenPipeError as error:
        raise OutputClosed from error


def exit_code_of(action: Callable[[], Any], as_json: bool = False) -> int:
    """Run `action` and say what went wrong; returns the exit code. A bug is raised on.

    Errors go to stderr, and where `as_json` to stdout too, as an object with the key `error`.
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
        return report(error, code, as_json)
    return result if isinstance(result, int) else 0


def code_for(error: Exception) -> int | None:
    """Exit code of an error that is the user's to mend; None for a bug."""
    from vibsim.branches.curve.arclength import ContinuationError
    from vibsim.branches.plan import BranchError
    from vibsim.cases import CaseError
    from vibsim.engine.errors import EngineError
    from vibsim.fitting.errors import FitError
    from vibsim.orbits.errors import NoSection, OrbitError
    from vibsim.plots.errors import PlotError
    from vibsim.results import ResultFileError
    from vibsim.sweeps.plan.sweep_plan import PlanError
    from vibsim.sweeps.schedule.cluster import ClusterError

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


def report(error: Exception, code: int, as_json: bool) -> int:
    """Tell an error of the user's: the lines of a CaseError as they are, others after `Error:`."""
    from vibsim.cases import CaseError
    from vibsim.cases.problems import listed
    from vibsim.command_line.text.in_shell import problem_in_shell

    if not isinstance(error, CaseError):
        return told(f"Error: {error}", code, as_json)
    problems = [problem_in_shell(problem) for problem in error.problems]
    return told(listed(problems), code, as_json, problems=[vars(one) for one in problems])


def told(text: str | list[str], code: int, as_json: bool, **more: Any) -> int:
    """Print an error on stderr, and as JSON on stdout where that is asked for; returns its exit code.

    text : its line, or its lines
    """
    from vibsim.command_line.terminal.printing import print_json, say
    from vibsim.command_line.text.in_shell import in_shell

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
    """How the command is called, and where its help is."""
    from vibsim.command_line.terminal.printing import say

    ctx = getattr(error, "ctx", None)
    if ctx is not None:
        say(f"{ctx.get_usage()}\nTry '{ctx.command_path} --help' for help.\n", err=True, lines=True)


def _message(error: click.ClickException) -> str:
    """The message of click, with the nearest option in place of those that it takes for near."""
    if isinstance(error, click.NoSuchOption):
        from vibsim.cases.spelling import nearest

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
