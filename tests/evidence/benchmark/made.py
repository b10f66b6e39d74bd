"""Small benches for the tests."""

from functools import cache

import numpy as np

from vibsim.cases import load_case
from vibsim.evidence.benchmark.bench_result import BenchTruth
from vibsim.evidence.benchmark.plan import make_plan
from vibsim.evidence.benchmark.running import compute_truth

METHODS = ("taylor", "dop853", "rk4")


def plan(name="II-B", t_end="2 s", methods=METHODS, limit=600.0, **changes):
    """A plan of a shipped case; values as excitation__Omega0="6 Hz"."""
    values = {key.replace("__", "."): value for key, value in changes.items()}
    return make_plan(load_case(name, values), t_end, methods, limit)


@cache
def truth(name="II-B", t_end="2 s"):
    """Its truth."""
    return compute_truth(plan(name, t_end))


def planted(times, x1, events=()):
    """A truth made up: x1 and x2 = 0 at `times`, and `events` (t, kind)."""
    times = np.asarray(times, dtype="f8")
    columns = {"time": times, "x1": np.asarray(x1, dtype="f8"), "x2": np.zeros(len(times))}
    table = np.array(events, dtype="f8").reshape(-1, 2)
    return BenchTruth("made up", columns, {"t": table[:, 0], "kind": table[:, 1].astype("i1")}, {})
