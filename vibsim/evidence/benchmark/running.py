"""Run a bench: the truth, then row after row, each kept on file as it comes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from vibsim.evidence.benchmark.bench_file import write_bench
from vibsim.evidence.benchmark.bench_result import BenchResult
from vibsim.evidence.benchmark.measuring import measure
from vibsim.evidence.benchmark.plan import Plan
from vibsim.evidence.benchmark.provenance import origin
from vibsim.evidence.benchmark.row import Row
from vibsim.evidence.benchmark.truth import Truth, compute_truth
from vibsim.files.output_file import check_result_output

Watch = Callable[[str, float], bool]  # given what is done and how far it is [0 to 1]; False stops the bench


def run_bench(
    plan: Plan,
    path: str | Path | None = None,
    truth: Truth | None = None,
    force: bool = False,
    watch: Watch = lambda what, share: True,
) -> BenchResult | None:
    """Run a bench, into a file where `path` is given; None where `watch` stopped it before its truth.

    Parameters
    ----------
    truth : what an earlier bench of the same fingerprint knows; computed when None
    force : replace an existing file

    When `watch` says False the row under way is given up and the bench ends with those before it, its
    attribute `complete` 0. Raises EngineError when the truth cannot be computed, MultiprecisionMissing
    without a library for it, ResultFileError when the file cannot be written.
    """
    target = None if path is None else check_result_output(path, force)
    if truth is None:
        truth = compute_truth(plan, lambda t: watch("truth", t / plan.times[-1]))
    if truth is None:
        return None
    attrs: dict[str, Any] = {**origin(plan), "complete": 0}
    rows: list[Row] = []

    def keep() -> None:
        if target is not None:
            write_bench(target, attrs, plan.case.scene(), truth, rows)

    keep()
    scene, entries = plan.case.scene(), list(plan.rows())
    for i, (family, setting) in enumerate(entries):
        at = f"{family.name}, {setting}", i / len(entries)
        if not watch(*at):
            break
        row = measure(family, setting, scene, truth, plan.limit, lambda at=at: watch(*at))  # type: ignore[misc]
        if not watch(*at):
            break
        rows.append(row)
        keep()
    else:
        attrs["complete"] = 1
        keep()
    return BenchResult({**attrs, **truth.attrs}, truth, rows)
