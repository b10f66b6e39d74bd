"""Ensembles of perturbed starts: what of a chaotic run would be so with any start that looks the same.

Beyond the trust horizon a single run proves nothing. What nearly all runs from neighbouring starts have in
common is a property of the system all the same; what they do not is chance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibsim.reports.measurements import Numbers
from vibsim.reports.outcomes import Advance, outcomes_of

if TYPE_CHECKING:
    from vibsim.cases import Case

STEP = 5e-5  # [m] between neighbouring starts of block 1: a twentieth of the gap
EACH_WAY = 24


def starts() -> list[float]:
    """Displacements x1(0) [m]: 24 to either side of rest, rest itself left out."""
    return [k * STEP for k in range(-EACH_WAY, EACH_WAY + 1) if k]


def measure_ensemble(case: Case, advance: Advance) -> Numbers:
    """Outcomes of a motor case from each start."""
    members = [case.with_values({"initial.x1": f"{start:.4g} m"}) for start in starts()]
    return {"starts": starts(), "outcomes": outcomes_of(members, advance)}
