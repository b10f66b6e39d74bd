"""Speed against error: vibsim and its peers on one case, each judged by the truth.

    bench = run_bench(make_plan("II-B"), "II-B-bench.h5")
    bench.rows, bench["error"], bench.truth

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.evidence.benchmark.bench_result import BenchResult as BenchResult
    from vibsim.evidence.benchmark.bench_result import facts as facts
    from vibsim.evidence.benchmark.bench_result import open_bench as open_bench
    from vibsim.evidence.benchmark.plan import make_plan as make_plan
    from vibsim.evidence.benchmark.running import run_bench as run_bench

__getattr__, __dir__, __all__ = lazy_names(__name__)
