"""Ways to call vibsim from a test."""

import subprocess
import sys

from click.testing import CliRunner

from vibsim.command_line.main import group


def call(*words, **options):
    """`vibsim words...` inside this process; .exit_code, .stdout, .stderr. A bug is raised."""
    return CliRunner().invoke(
        group, [str(word) for word in words], catch_exceptions=False, prog_name="vibsim", **options
    )


def process(*words, **options):
    """`vibsim words...` as a process of its own; .returncode, .stdout, .stderr."""
    command = [sys.executable, "-m", "vibsim", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)
