"""The same cases with the stop out of reach: what of their motion is the impacts' doing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from vibsim.analysis import judge_capture, judge_regime, measure_drift
from vibsim.evidence.reports.measured.measurements import Numbers, overall_rate, plain
from vibsim.evidence.reports.measured.outcomes import Advance, run_all
from vibsim.results import Result, simulate

if TYPE_CHECKING:
    from vibsim.cases import Case

NO_STOP = {"stop.G": "1000 m"}  # a gap that no motion closes
AS_LONG = {**NO_STOP, "run.every": "50 ms"}
SETTLED = {**AS_LONG, "run.t_end": "10000 s"}  # free vibration dies out as exp(-t/540 s), c = 0.001 N s/m


def measure_without_stop(cases: Sequence[Case], advance: Advance) -> Numbers:
    """For each case by name: drift over the same time, and the regime that it settles in."""
    runs = run_all([partial(_measured, case) for case in cases], advance)
    return {case.name: numbers for case, numbers in zip(cases, runs, strict=True)}


def _measured(case: Case) -> Numbers:
    run, settled = (simulate(case.with_values(changes), trust=False) for changes in (AS_LONG, SETTLED))
    capture = plain(judge_capture(run)) if case.two_blocks().has_motor else None
    return {
        "drift": plain(measure_drift(run, orbit_rates=judge_regime(run).drift_rates)),
        "overall": overall_rate(run),
        "impacts": int(run.attrs["impacts"]) + int(settled.attrs["impacts"]),
        "regime": _regime(settled),
        "capture": capture,
    }


def _regime(result: Result) -> Numbers:
    regime: Numbers = plain(judge_regime(result))
    return regime
