"""Speed against error: vibsim and its peers on one case, each judged by the truth.

    bench = run_bench(make_plan("II-B"), "II-B-bench.h5")
    bench.rows, bench["error"], bench.truth

Names are imported when they are used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.evidence.benchmark.bench_result import BenchResult, open_bench
    from vibsim.evidence.benchmark.description import facts
    from vibsim.evidence.benchmark.plan import make_plan
    from vibsim.evidence.benchmark.running import run_bench

_HOMES = {
    "BenchResult": "vibsim.evidence.benchmark.bench_result",
    "facts": "vibsim.evidence.benchmark.description",
    "make_plan": "vibsim.evidence.benchmark.plan",
    "open_bench": "vibsim.evidence.benchmark.bench_result",
    "run_bench": "vibsim.evidence.benchmark.running",
}

__all__ = ["BenchResult", "facts", "make_plan", "open_bench", "run_bench"]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
