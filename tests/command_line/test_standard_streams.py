"""Commands whose standard streams the caller closed."""

import subprocess
import sys

import pytest

import vibsim

RUN = ["run", "I-A", "--t-end", "0.1s", "-o", "a.h5"]


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_command_does_its_work_without_standard_streams(tmp_path, closed):
    outcome = shell(tmp_path, RUN, closed)
    assert (outcome.returncode, outcome.stderr) == (0, "")
    assert vibsim.open_result(tmp_path / "a.h5").complete


def test_a_case_from_a_closed_input_is_empty(tmp_path):
    outcome = shell(tmp_path, ["check", "-"], "<&-")
    assert outcome.returncode == 3
    assert (outcome.stdout + outcome.stderr).startswith("stdin:1:1: is empty")


def shell(folder, words, redirection):
    command = f'exec "$0" -m vibsim {" ".join(words)} {redirection}'
    return subprocess.run(["sh", "-c", command, sys.executable], cwd=folder, capture_output=True, text=True)
