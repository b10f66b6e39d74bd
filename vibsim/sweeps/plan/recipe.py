"""What all points of a sweep have in common: all that a worker needs besides what sets a point apart.

It is small plain data, sent along with every batch of points; the axes, which may be long, stay behind.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

from vibsim.analysis.discard import Discard
from vibsim.sweeps.statistics.quantities import Quantities, quantities_of

if TYPE_CHECKING:
    from vibsim.cases import Case

SMALLEST = 2.0**-1022  # below it a case does not take a number
UNITS = {  # of a state by its name, or by the letter that it begins with
    "x": "m",
    "v": "m/s",
    "phi": "rad",
    "phidot": "rad/s",
}

Start = Mapping[str, str]  # initial values that replace those of the case, such as {"initial.x1": "0.1 m"}


@dataclass(frozen=True)
class Recipe:
    """How a point is computed, whichever it is; the attributes are those of `Plan`."""

    case: "Case"
    carry: bool
    discard: Discard
    section: int
    every: Fraction | None
    compute: tuple[str, ...] = ()

    @cached_property
    def of(self) -> Quantities:
        """What is measured at every point."""
        return quantities_of(self.case)

    def start_after(self, values: Mapping[str, float]) -> Start:
        """Start values of the point that goes on where the one with these `values` ended."""
        ends = {name: values.get(f"end_{name}") for name in self.of.starts}
        return {
            self.of.starts[name]: f"{_storable(value)!r} {UNITS.get(name) or UNITS[name[0]]}"
            for name, value in ends.items()
            if value is not None
        }

    def point_case(self, changes: Mapping[str, str], start: Start | None = None) -> "Case":
        """The case of a point, begun from `start` where a state is carried. Raises CaseError."""
        return self.case.with_values({**changes, **(start or {})})


def _storable(value: float) -> float:
    return value if math.isfinite(value) and abs(value) >= SMALLEST else 0.0
