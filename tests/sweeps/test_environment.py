"""The bits of a result do not depend on a BLAS, its threads, or the vector unit that numpy uses."""

import json
import os
import subprocess
import sys

import pytest

SCRIPT = """
import hashlib, json, sys
from dataclasses import asdict
import vibsim
from vibsim.analysis import analyse

def digest(array):
    return hashlib.sha256(array.tobytes()).hexdigest()

def columns(name, result):
    numbers = [key for key in result if key != "wall_time" and result[key].dtype.kind == "f"]
    return {f"{name} {key}": digest(result[key]) for key in numbers}

def short(case, **axis):
    return vibsim.sweep(vibsim.load_case(case, {"run.t_end": "60 s"}), axis, compute="all", jobs=2)

case = vibsim.load_case("II-B", {"run.t_end": "4000 s"})  # BLAS shares out more than 10,000 products
found = columns("long", vibsim.sweep(case, {"Omega0": "6 Hz"}, jobs=1))
found |= columns("motor", short("II-B", Omega0="6 Hz"))
found |= columns("force", short("I-C-eq211", omega="6.5 Hz"))
run = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "60 s"}))
found |= columns("run", run) | {"horizon": run.trust_horizon, "largest": run.attrs["error_estimate_max"]}
found["verdicts"] = repr(asdict(analyse(run, exponent=False)))
json.dump(found, sys.stdout)
"""


def environments():
    """numpy tells which vector units it has code for."""
    try:
        from numpy._core._multiarray_umath import __cpu_dispatch__
    except ImportError:  # before numpy 2
        from numpy.core._multiarray_umath import __cpu_dispatch__

    yield {"OPENBLAS_NUM_THREADS": "2"}
    yield {
        "OPENBLAS_NUM_THREADS": "1",
        "OPENBLAS_CORETYPE": "Prescott",
        "NPY_DISABLE_CPU_FEATURES": " ".join(__cpu_dispatch__),
    }


@pytest.mark.timeout(300)
def test_sweeps_runs_and_verdicts_have_the_same_bits_everywhere():
    command = [sys.executable, "-W", "ignore", "-c", SCRIPT]
    runs = [
        subprocess.Popen(command, env={**os.environ, **environment}, stdout=subprocess.PIPE)
        for environment in environments()
    ]
    here, there = (json.loads(run.communicate()[0]) for run in runs)
    assert len(here) > 80
    assert {key: (here[key], there[key]) for key in here if here[key] != there[key]} == {}
