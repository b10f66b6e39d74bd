"""Ensembles of perturbed starts: what of a chaotic run would be so with any start that looks the same.

Beyond the trust horizon a single run proves nothing. What nearly all runs from neighbouring starts have in
common is a property of the system all the same; what they do not is chance.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from vibsim.analysis import count_impacts, judge_regime, measure_drift
from vibsim.engine.errors import EngineError
from vibsim.evidence.reports.measured.measurements import Numbers, overall_rate, steady_amplitudes
from vibsim.evidence.reports.measured.outcomes import Advance, outcome_of, run_all
from vibsim.results import Result, simulate

if TYPE_CHECKING:
    from vibsim.cases import Case

EVERY = "100 ms"  # half a turn of the motor: its mean speed over 12 turns is known to 1 %
STEP = 5e-5  # [m] between neighbouring starts of block 1: a twentieth of the gap
EACH_WAY = 24


def starts() -> list[float]:
    """Displacements x1(0) [m]: 24 to either side of rest, rest itself left out."""
    return [k * STEP for k in range(-EACH_WAY, EACH_WAY + 1) if k]


def measure_ensemble(case: Case, advance: Advance) -> Numbers:
    """What comes of a case from each start; raises Interrupted when `advance` returns False."""
    members = from_starts(case)
    return {
        "starts": starts(),
        "outcomes": run_all([partial(member_outcome, each) for each in members], advance),
    }


def from_starts(case: Case) -> list[Case]:
    """The case from each of the perturbed starts."""
    return [case.with_values({"initial.x1": f"{start:.4g} m"}) for start in starts()]


def member_outcome(case: Case) -> Numbers:
    """The motion of a member and, with a motor, what becomes of it; {"failed": why} where it breaks down."""
    try:
        result = simulate(case.with_values({"run.every": EVERY}), trust=False)
    except EngineError as error:
        return {"failed": str(error)}
    motor = outcome_of(result) if case.two_blocks().has_motor else {}
    return {**motor, **motion_of(result)}


def motion_of(result: Result) -> Numbers:
    """Drift rates [m/s], impacts over the whole run, impacts in each cycle, vibration and regime."""
    cycles, regime = count_impacts(result), judge_regime(result)
    return {
        "drift": measure_drift(result).rate,
        "overall": overall_rate(result),
        "impacts": int(result.attrs["impacts"]),
        "cycles": cycles.verdict,
        "one_per_cycle": set(cycles.impact_counts or ()) == {1},
        "steady": steady_amplitudes(result),
        "regime": regime.verdict,
        "period": regime.period,
    }
