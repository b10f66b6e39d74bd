"""What would make the paper's account of II-B and II-C hold: one parameter at a time, then two together.

Each parameter of Table 1 is varied over a range about its printed value, the others as printed, and both
cases are run; then the two that the readings change, m3 and c, on a grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vibsim.reports.measurements import Numbers
from vibsim.reports.outcomes import Advance, outcomes_of

if TYPE_CHECKING:
    from vibsim.cases import Case


@dataclass(frozen=True)
class Sought:
    """A parameter to vary: its key in a case, symbol, unit, and the values tried (SI)."""

    key: str
    symbol: str
    unit: str
    values: tuple[float, ...]


NO_CONTACT = 1000.0  # [m] a gap that no motion closes: as if there were no stop

ALONE = (
    Sought("coupling.c", "c", "N s/m",
           (0, 2e-4, 5e-4, 2e-3, 5e-3, 0.01, 0.02, 0.025, 0.03, 0.04, 0.045, 0.049, 0.05, 0.07, 0.1, 0.3)),
    Sought("friction.mu", "mu", "",
           (0, 2e-4, 5e-4, 2e-3, 5e-3, 0.01, 0.012, 0.014, 0.017, 0.02, 0.03, 0.05, 0.1)),
    Sought("stop.G", "G", "m", (0, 2e-4, 5e-4, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, NO_CONTACT)),
    Sought("stop.k2", "k2", "N/m", (50, 100, 200, 1e3, 3e3, 6e3, 2e4, 5e4, 1e5, 2e5)),
    Sought("excitation.M0", "M0", "N m", (2e-3, 3e-3, 4e-3, 4.5e-3, 5.5e-3, 6e-3, 8e-3, 0.01, 0.02)),
    Sought("excitation.J", "J", "kg m²", (1e-4, 3e-4, 5e-4, 2e-3, 4e-3, 6e-3, 8e-3, 0.01, 0.014)),
    Sought("excitation.m3", "m3", "kg",
           (0.01, 0.02, 0.04, 0.045, 0.048, 0.051, 0.054, 0.057, 0.06, 0.065, 0.07, 0.08)),
    Sought("excitation.e", "e", "m", (0.05, 0.08, 0.13, 0.15, 0.17, 0.18, 0.19, 0.2)),
    Sought("initial.x1", "x1(0)", "m", (-0.02, -0.01, -5e-3, 2e-3, 5e-3, 0.01, 0.02, 0.03, 0.05)),
    Sought("initial.phi", "phi(0)", "rad", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)),
)  # fmt: skip

TOGETHER = (
    Sought("excitation.m3", "m3", "kg", tuple(round(0.030 + 0.004 * i, 3) for i in range(13))),
    Sought("coupling.c", "c", "N s/m",
           (1e-3, 1.25e-3, 1.5e-3, 1.75e-3, 2e-3, 2.5e-3, 3e-3, 4e-3, 6e-3, 0.01, 0.02, 0.03)),
)  # fmt: skip


def search_alone(cases: Sequence[Case], advance: Advance) -> list[Numbers]:
    """A row for each value of each parameter: the outcome of every case by name."""
    points = [{sought.key: value} for sought in ALONE for value in sought.values]
    return _rows(cases, points, advance)


def search_together(cases: Sequence[Case], advance: Advance) -> list[Numbers]:
    """A row for each point of the grid of TOGETHER."""
    first, second = TOGETHER
    points = [{first.key: a, second.key: b} for a in first.values for b in second.values]
    return _rows(cases, points, advance)


def _rows(cases: Sequence[Case], points: Sequence[dict[str, float]], advance: Advance) -> list[Numbers]:
    changed = [case.with_values(point) for point in points for case in cases]
    outcomes = iter(outcomes_of(changed, advance))
    return [{"at": point, **{case.name: next(outcomes) for case in cases}} for point in points]
