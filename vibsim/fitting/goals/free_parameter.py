"""A parameter that a fit may change: its range, how the range is divided, and what leaving its value costs.

J=0.5:20 g m^2          from 0.5 to 20 g m^2; by ratio, as the ends are positive and 5 times apart or more
c=linear 0.001:0.05     in equal steps;  c=log 1e-3:2e-3  by ratio
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vibsim.cases.schema.keys import UnknownKeyError
from vibsim.cases.values.units import UNITS
from vibsim.fitting.errors import FitError
from vibsim.physics.arithmetic.elementary import exp, log, log10
from vibsim.sweeps.plan.axis import read_axis, scale_name

if TYPE_CHECKING:
    from vibsim.cases import Case

LEAVE = 0.1  # price of a factor of 10, or of the whole width of a range in equal steps
DIGITS = 4  # significant ones of a value that is tried, so that it can be written down
FAR_APART = 5.0  # ratio of the ends from which a range is divided by ratio
SCALES = ("log", "linear")


@dataclass(frozen=True)
class FreeParameter:
    """One parameter.

    Attributes
    ----------
    key : dotted key of the case
    unit : of the numbers
    low, high : ends of the range
    by_ratio : whether the search divides the range by ratio
    printed : value in each case
    leave : price of leaving it by a factor of 10 (by the whole width where not `by_ratio`)
    """

    key: str
    unit: str
    low: float
    high: float
    by_ratio: bool
    printed: tuple[float, ...]
    leave: float = LEAVE

    @property
    def name(self) -> str:
        """The last part of the key; of a named body or part as an axis of a sweep is called."""
        section, *names = self.key.split(".")
        return scale_name(self.key) if section == "bodies" or len(names) > 1 else names[-1]

    def value(self, place: float) -> float:
        """The value at a place from 0 to 1 of the range, rounded to DIGITS digits and within it."""
        if self.by_ratio:
            value = exp(log(self.low) + place * (log(self.high) - log(self.low)))
        else:
            value = self.low + place * (self.high - self.low)
        return min(self.high, max(self.low, float(f"{value:.{DIGITS}g}")))

    def text(self, value: float) -> str:
        """The value as a case takes it."""
        return f"{value!r} {self.unit}".strip()

    def price(self, value: float) -> float:
        """What leaving the printed value for this one costs, on the average of the cases."""
        return self.leave * sum(self._distance(value, each) for each in self.printed) / len(self.printed)

    def _distance(self, value: float, printed: float) -> float:
        if self.by_ratio and printed > 0:
            return abs(log10(value / printed))
        return abs(value - printed) / (self.high - self.low)

    def plain(self) -> dict[str, Any]:
        """Plain data for JSON; `from_plain` reads it back."""
        return {**vars(self), "printed": list(self.printed)}

    @staticmethod
    def from_plain(data: Mapping[str, Any]) -> FreeParameter:
        """The parameter that `plain` wrote down."""
        return FreeParameter(**{**data, "printed": tuple(data["printed"])})

    def __str__(self) -> str:
        printed = " and ".join(dict.fromkeys(f"{value:g}" for value in self.printed))
        how = "by ratio" if self.by_ratio else "in equal steps"
        return (
            f"{self.name} {self.low:g} to {self.high:g} {self.unit}".strip() + f", {how}, printed {printed}"
        )


def read_free(cases: list[Case], key: str, text: str, leave: float | None = None) -> FreeParameter:
    """The parameter that `key` and the range `text` describe, both ends tried in every case.

    Raises FitError for a text that is no range and a key that is not one of a case's, CaseError where
    a case does not allow an end.
    """
    words = text.split(maxsplit=1)
    scale = words[0] if words[:1] and words[0] in SCALES else ""
    amount = text.strip().removeprefix(scale).strip()
    if amount.count(":") != 1:
        raise FitError(f"{key}={text}: a range is FROM:TO with a unit at the end, such as J=0.5:20 g m^2")
    try:
        axes = [read_axis(case, key, amount.replace(":", ",", 1), argument="free") for case in cases]
    except UnknownKeyError as error:
        raise FitError(f"free {key}: {error}") from None
    except ValueError as error:
        raise FitError(f"{key}={text}: {error}") from None
    full, unit = axes[0].key, axes[0].unit
    low, high = (float(value) for value in axes[0].values)
    if low > high:
        raise FitError(f"{key}={text}: a range must rise, got {low:g} to {high:g}")
    if scale == "log" and low <= 0:
        raise FitError(f"{key}={text}: a range by ratio must begin above 0")
    by_ratio = scale == "log" or (not scale and low > 0 and high / low >= FAR_APART)
    if leave is not None and not 0 <= leave < float("inf"):
        raise FitError(f"leave {key}={leave:g}: a price is at least 0")
    printed = tuple(printed_value(case, full, unit) for case in cases)
    return FreeParameter(full, unit, low, high, by_ratio, printed, LEAVE if leave is None else leave)


def printed_value(case: Case, key: str, unit: str) -> float:
    """The value of a case in that unit."""
    quantity = case.quantity(key)
    if quantity.value and quantity.per_turn != UNITS[unit].per_turn:
        raise FitError(f"{key}: {case.name} has {quantity}; turns and radians do not go together in a range")
    return float(quantity.value / UNITS[unit].factor)
