"""The range that a quantity should be in, and how far it is from it."""

from dataclasses import dataclass
from math import inf, isfinite, isnan


@dataclass(frozen=True)
class Bounds:
    """From `low` to `high`, both allowed; either may be infinite."""

    low: float = -inf
    high: float = inf

    def contain(self, value: float) -> bool:
        """Whether a value is in the range; NaN, where a run has no such quantity, is not."""
        return self.low <= value <= self.high

    def shortfall(self, value: float) -> float:
        """0 in the range, growing with the distance from it; 1 from one `scale` away on, and for NaN."""
        if self.contain(value):
            return 0.0
        if isnan(value):
            return 1.0
        distance = self.low - value if value < self.low else value - self.high
        return min(1.0, distance / self.scale) if self.scale else 1.0

    @property
    def scale(self) -> float:
        """Width of the range; of an open one the magnitude of its end. 0: nothing counts as near."""
        if isfinite(self.low) and isfinite(self.high):
            return self.high - self.low
        return abs(self.low if isfinite(self.low) else self.high)
