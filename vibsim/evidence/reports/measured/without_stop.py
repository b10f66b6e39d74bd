"""The same cases with the stop out of reach, or with wider gaps: what of their motion impacts cause."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from statistics import median
from typing import TYPE_CHECKING

from vibsim.analysis import count_impacts, judge_capture, judge_regime, measure_drift
from vibsim.evidence.reports.measured.ensembles import EVERY, from_starts
from vibsim.evidence.reports.measured.measurements import Numbers, drifts, overall_rate, plain
from vibsim.evidence.reports.measured.outcomes import Advance, outcome_of, run_all
from vibsim.evidence.reports.measured.paper_runs import PRINTED
from vibsim.results import Result, simulate

if TYPE_CHECKING:
    from vibsim.cases import Case

NO_STOP = {"stop.G": "1000 m"}  # a gap that no motion closes
AS_LONG = {**NO_STOP, "run.every": "50 ms"}
SETTLED = {**AS_LONG, "run.t_end": "10000 s"}  # free vibration dies out as exp(-t/540 s), c = 0.001 N s/m


GAPS_MM = tuple(float(f"{400 ** (k / 26):.3g}") for k in range(27))  # 1 to 400 mm, in equal factors


def measure_without_stop(cases: Sequence[Case], advance: Advance) -> Numbers:
    """For each case by name: drift over the same time, and the regime that it settles in; of the printed
    cases with an ideal source also the median overall rate of perturbed starts [m/s], and how many drift.
    """
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
        **(_of_starts(case) if case.name in PRINTED else {}),
    }


def _of_starts(case: Case) -> Numbers:
    runs = [simulate(each, trust=False) for each in from_starts(case.with_values(AS_LONG))]
    return {
        "starts_overall": median(abs(overall_rate(run)) for run in runs),
        "starts_drifting": sum(drifts(plain(measure_drift(run))) for run in runs),
    }


def measure_gaps(case: Case, advance: Advance) -> list[Numbers]:
    """For each of GAPS_MM: what a motor does from rest, and its impacts in the second half of the run."""
    return run_all([partial(_with_gap, case, gap) for gap in GAPS_MM], advance)


def _with_gap(case: Case, gap_mm: float) -> Numbers:
    result = simulate(case.with_values({"stop.G": f"{gap_mm:g} mm", "run.every": EVERY}), trust=False)
    late = count_impacts(result)
    return {"gap_mm": gap_mm, **outcome_of(result), "impacts_per_turn": late.impacts}


def _regime(result: Result) -> Numbers:
    regime: Numbers = plain(judge_regime(result))
    return regime
