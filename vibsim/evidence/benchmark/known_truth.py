"""The truth of an earlier bench, taken over where it is that of the same case over the same instants."""

from pathlib import Path

from vibsim.evidence.benchmark.bench_result import BenchResult, open_bench
from vibsim.evidence.benchmark.errors import BenchError
from vibsim.evidence.benchmark.plan import NOT_TRUTH, Plan
from vibsim.evidence.benchmark.truth import Truth
from vibsim.files.errors import ResultFileError


def truth_from(plan: Plan, path: str | Path) -> Truth:
    """The truth in the bench file `path`. Raises ResultFileError where it is no such file, BenchError where
    the truth in it is not that of `plan`, with what differs.
    """
    bench = open_bench(path)
    if bench.truth.fingerprint != plan.fingerprint:
        raise BenchError(
            f"{path}: its truth is of another case; it differs in {', '.join(_differences(plan, bench))}"
        )
    return bench.truth


def truth_at_hand(plan: Plan, path: str | Path) -> Truth | None:
    """The same; None where there is none."""
    try:
        return truth_from(plan, path)
    except (ResultFileError, BenchError):
        return None


def _differences(plan: Plan, bench: BenchResult) -> list[str]:
    ours, theirs = ({k: str(v) for k, v in case.values.items()} for case in (plan.case, bench.case))
    keys = [key for key in {**ours, **theirs} if key not in NOT_TRUTH and ours.get(key) != theirs.get(key)]
    return [f"{key} ({theirs.get(key, 'none')} there, {ours.get(key, 'none')} here)" for key in keys]
