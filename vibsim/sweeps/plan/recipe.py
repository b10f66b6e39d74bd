"""What all points of a sweep have in common: all that a worker needs besides what sets a point apart.

It is small plain data, sent along with every batch of points; the axes, which may be long, stay behind.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from vibsim.sweeps.plan.discard import Discard

if TYPE_CHECKING:
    from vibsim.cases import Case

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

    def point_case(self, changes: Mapping[str, str], start: Start | None = None) -> "Case":
        """The case of a point, begun from `start` where a state is carried. Raises CaseError."""
        return self.case.with_values({**changes, **(start or {})})
