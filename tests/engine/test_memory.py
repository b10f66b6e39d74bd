"""Arrays of one run are not faulted in anew by the next."""

import os
import subprocess
import sys
from platform import libc_ver

import pytest

RUNS = 2
SCRIPT = f"""
import resource
from vibsim import load_case, simulate
case = load_case("II-B")
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range({RUNS}):
    simulate(case)
before = faults()
for _ in range({RUNS}):
    simulate(case)
print((faults() - before) / {RUNS})
"""


def faults_per_run(**environment):
    told = {key: value for key, value in os.environ.items() if not key.startswith("MALLOC_")}
    command = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(command, env=told | environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


@pytest.mark.skipif(libc_ver()[0] != "glibc", reason="the C library of Linux")
@pytest.mark.skipif("libasan" in os.environ.get("LD_PRELOAD", ""), reason="another malloc")
def test_a_run_uses_the_memory_that_the_one_before_it_freed():
    pytest.importorskip("vibsim.engine._engine")
    assert faults_per_run() < 1000 < faults_per_run(MALLOC_TRIM_THRESHOLD_="1000000")
