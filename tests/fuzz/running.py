"""One mutant at a time: a forked copy of this process runs the command, and is watched from outside."""

import os
import pkgutil
import signal
import sys
import time
from dataclasses import dataclass

from vibsim.command_line import commands

LIMIT = 4.0  # seconds until a command is interrupted: what a case asks for may take for ever
PATIENCE = 2.0  # seconds that it may take to end then


@dataclass(frozen=True)
class Outcome:
    """How a command ended: exit code (negative: signal), what it printed, seconds from SIGINT to the end."""

    code: int
    stdout: str
    stderr: str
    ending: float | None


def run(words, folder, limit=LIMIT, patience=PATIENCE):
    """Run `vibsim WORDS` in `folder`; its Outcome. What does not end after SIGINT is killed."""
    child = os.fork()
    if child == 0:
        _be_the_command(words, folder)
    code = _wait(child, limit)
    ending = None
    if code is None:
        began = time.monotonic()
        os.kill(child, signal.SIGINT)
        code = _wait(child, 5 * patience)
        ending = time.monotonic() - began
        if code is None:
            os.kill(child, signal.SIGKILL)
            code = _wait(child, 60)
    texts = [(folder / name).read_bytes().decode("utf-8", "replace") for name in ("stdout", "stderr")]
    return Outcome(code, *texts, ending)


def _wait(child, seconds):
    """Exit code; None when it is still running."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found, status = os.waitpid(child, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    return None


def _be_the_command(words, folder):
    """Never returns."""
    code = 1
    try:
        os.chdir(folder)
        for descriptor, name in ((0, os.devnull), (1, "stdout"), (2, "stderr")):
            flags = os.O_RDONLY if descriptor == 0 else os.O_WRONLY | os.O_CREAT | os.O_TRUNC
            os.dup2(os.open(name, flags, 0o600), descriptor)
        sys.stdin = open(0)  # noqa: SIM115
        sys.stdout, sys.stderr = (open(each, "w", closefd=False) for each in (1, 2))  # noqa: SIM115
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # as `python -m vibsim` begins
        sys.argv = ["vibsim", *words]
        from vibsim.command_line.main import main

        main()
        code = 0
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 0
    except BaseException:
        import traceback

        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)


def preload():
    """Import once what every copy would import."""
    import matplotlib

    matplotlib.use("Agg")
    for name in (
        "cases",
        "results.trajectory_file",
        "sweeps.sweeping",
        "sweeps.sweep_result",
        "orbits.branches.continuing",
        "fitting.fit_result",
        "plots.picture",
    ):
        __import__(f"vibsim.{name}")
    for module in pkgutil.iter_modules(commands.__path__):
        __import__(f"{commands.__name__}.{module.name}")


def control_characters(text):
    """Those that a terminal would obey."""
    return {ch for ch in text if (ord(ch) < 32 and ch not in "\n\t\r") or 127 <= ord(ch) < 160}
