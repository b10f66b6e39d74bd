"""From exceptions to messages and exit codes.

0 ok, 1 a bug (traceback), 2 usage, 3 invalid case, 4 run failed, 5 sweep with failed points, 6 file trouble,
130 and 143 interrupted; 141 when nobody reads the output any more.
"""

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

INVALID_CASE, RUN_FAILED, FAILED_POINTS, FILE_TROUBLE = 3, 4, 5, 6
INTERRUPTED, BROKEN_PIPE, TERMINATED = 130, 141, 143


class OutputClosed(Exception):
    """Nobody reads stdout any more."""


@contextmanager
def broken_pipe_named() -> Iterator[None]:
    """Say OutputClosed for a broken pipe, which click would take for a failure."""
    try:
        yield
    except BrokenPipeError as error:
        raise OutputClosed from error


def exit_code_of(action: Callable[[], Any]) -> int:
    """Run `action` and say what went wrong on stderr; returns the exit code. A bug is raised on."""
    try:
        result = action()
        with broken_pipe_named():
            sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except OutputClosed:
        _discard_stdout()
        return BROKEN_PIPE
    except OSError as error:
        return _output_failed(error)
    except Exception as error:
        code = code_for(error)
        if code is None:
            raise
        report(error)
        return code
    return result if isinstance(result, int) else 0


def code_for(error: Exception) -> int | None:
    """Exit code of an error that is the user's to mend; None for a bug."""
    from vibsim.cases import CaseError
    from vibsim.fitting.errors import FitError
    from vibsim.kernel import KernelError
    from vibsim.plots.errors import PlotError
    from vibsim.results import ResultFileError
    from vibsim.sweeps.cluster import ClusterError
    from vibsim.sweeps.plan import PlanError

    codes: dict[type[Exception], int] = {
        CaseError: INVALID_CASE,
        KernelError: RUN_FAILED,
        PlotError: click.UsageError.exit_code,
        ResultFileError: FILE_TROUBLE,
        ClusterError: RUN_FAILED,
        PlanError: click.UsageError.exit_code,
        FitError: click.UsageError.exit_code,
    }
    return next((code for kind, code in codes.items() if isinstance(error, kind)), None)


def report(error: Exception) -> None:
    """Print an error of the user's on stderr: the lines of a CaseError as they are, others after `Error:`."""
    text = str(error)
    located = code_for(error) == INVALID_CASE
    click.echo(text if located else f"Error: {text}", err=True)


def _output_failed(error: OSError) -> int:
    """Stdout is on a full disk; any other OSError is a bug."""
    if error.errno == errno.ENOSPC and error.filename is None:
        _discard_stdout()
        click.echo("Error: stdout: disk full", err=True)
        return FILE_TROUBLE
    raise error


def _discard_stdout() -> None:
    """Send what is still buffered for stdout nowhere: at its end the interpreter would complain."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
