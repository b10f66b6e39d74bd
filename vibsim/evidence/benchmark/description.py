"""A bench as a dict for programs."""

import json
from math import isfinite
from typing import Any

from vibsim.evidence.benchmark.bench_result import BenchResult
from vibsim.evidence.benchmark.columns import ROW
from vibsim.evidence.benchmark.families import family_of
from vibsim.evidence.benchmark.row import STATUS_FLAGS, Row
from vibsim.evidence.benchmark.verdicts import beside_reference, impacts_per_second

STATUS_NAMES = {code: name for name, code in STATUS_FLAGS.items()}


def facts(bench: BenchResult) -> dict[str, Any]:
    """Attributes and rows as plain data, the case as an object; what is not known is null."""
    attrs = {name: value for name, value in bench.attrs.items() if name != "case_yaml"}
    case = json.loads(attrs.pop("case_resolved_json"))
    attrs |= {name: json.loads(attrs[name]) for name in ("methods", "not_installed")}
    attrs["check_times_s"] = bench.check_times
    attrs["left_out"] = refusals(bench)
    ratios = [
        {
            "method": each.row.method,
            "setting": each.row.setting,
            "time_ratio": each.times,
            "error_ratio": each.errors,
        }
        for each in beside_reference(bench)
    ]
    rows = [row_facts(bench, row) for row in bench.rows]
    return {**attrs, "case": case, "telling_time_s": bench.telling_time, "rows": rows, "beside": ratios}


def refusals(bench: BenchResult) -> dict[str, str]:
    """Why families that were asked for cannot take the case, by name."""
    scene = bench.case.scene()
    sentences = {name: family_of(name).refusal(scene) for name in json.loads(bench.attrs["methods"])}
    return {name: sentence for name, sentence in sentences.items() if sentence is not None}


def row_facts(bench: BenchResult, row: Row) -> dict[str, Any]:
    """One row as plain data."""
    numbers = {name: _known(getattr(row, name), column.missing) for name, column in ROW.items()}
    errors = [_known(row.error_until(bench["time"], t)) for t in bench.check_times]
    return {
        "method": row.method,
        "label": family_of(row.method).label,
        "setting": row.setting,
        "status": STATUS_NAMES[row.status],
        "problem": row.problem or None,
        **numbers,
        "impacts_per_second": impacts_per_second(bench, row),
        "errors_m": errors,
        "events": {name: vars(count) for name, count in row.events.items()},
    }


def _known(value: float, missing: int | None = None) -> float | None:
    return value if isfinite(value) and value != missing else None
