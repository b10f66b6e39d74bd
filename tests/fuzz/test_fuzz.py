"""A few mutants in the suite; `make fuzz` makes three thousand, or as many as you like."""

import os
import subprocess
import sys

import pytest


@pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants are run by copies of one process")
def test_no_mutant_of_a_few_ends_badly(tmp_path):
    words = ["--count", "25", "--patience", "60", "--keep", str(tmp_path)]
    command = [sys.executable, "-m", "tests.fuzz", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "25 mutants, 0 failed\n"), done.stdout + done.stderr
