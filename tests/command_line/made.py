"""Ways to call vibsim from a test, and what to call it with."""

import signal
import subprocess
import sys
from contextlib import contextmanager

from click.testing import CliRunner

from vibsim.command_line.main import group

# a case whose force turns a billion times between two samples
SLOW_SOURCE = """
name: slow
blocks: {m1: 1 kg, m2: fixed}
coupling: {k1: 1 N/m}
excitation: {kind: harmonic, A: 1 N, omega: 1e9 Hz}
initial: {x1: 1 mm}
run: {t_end: 100 s, every: 1 s}
"""


def call(*words, **options):
    """`vibsim words...` inside this process; .exit_code, .stdout, .stderr. A bug is raised."""
    return CliRunner().invoke(
        group, [str(word) for word in words], catch_exceptions=False, prog_name="vibsim", **options
    )


def told(*words, **options):
    """What `vibsim words...` prints inside this process; it succeeds."""
    done = call(*words, **options)
    assert done.exit_code == 0, done.output
    return done.stdout


def refused(*words, code=2, **options):
    """What `vibsim words...` says inside this process as it ends with an exit code other than 0."""
    done = call(*words, **options)
    assert done.exit_code == code, done.output
    assert "Traceback" not in done.output
    return done.stderr


def process(*words, **options):
    """`vibsim words...` as a process of its own; .returncode, .stdout, .stderr."""
    command = [sys.executable, "-m", "vibsim", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


@contextmanager
def begun(*words, **options):
    """`vibsim words...` as a process that goes on beside the test, and no longer than the block."""
    command = [sys.executable, "-m", "vibsim", *map(str, words)]
    kept = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **options}
    with subprocess.Popen(command, **kept) as child:
        try:
            yield child
        finally:
            child.kill()  # nothing, where it has ended


@contextmanager
def own_handlers():
    """Handlers of signals that a command sets are set back behind the block."""
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM)}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
