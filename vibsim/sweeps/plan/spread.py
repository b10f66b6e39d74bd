"""How a value of the case varies over an ensemble: its distribution, exact, and the numbers drawn from it.

x1=1 mm             uniform, up to 1 mm either side of the case's value
phi=0:360 deg       uniform from 0 to 360 degrees
v1=normal 2 mm/s    normal about the case's value, with that standard deviation
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.schema.keys import UnknownKeyError, measured_at
from vibsim.cases.values.quantities import Quantity, QuantityError, decimal_text, exact_number, parse_quantity
from vibsim.cases.values.units import UNITS
from vibsim.sweeps.plan.axis import read_axis, scale_name

if TYPE_CHECKING:
    from vibsim.cases import Case

UNIFORM, NORMAL = "uniform", "normal"
OUTPUTS_PER_COUNT = 4  # of Philox: it makes four words of 64 bits for each value of its counter
BITS_LEFT_OUT = 12  # of 64: what is left and a half is exact in a double


class SpreadError(ValueError):
    """A text that is no spread; the message says why, and how spreads are written."""


@dataclass(frozen=True)
class Spread:
    """The distribution of one value of the case.

    Attributes
    ----------
    key : dotted key of the case
    unit : of `centre` and `width`
    shape : UNIFORM within `width` of `centre`, or NORMAL with that standard deviation
    """

    key: str
    unit: str
    shape: str
    centre: Fraction
    width: Fraction

    @property
    def name(self) -> str:
        """What its values are called, as those of an axis."""
        return scale_name(self.key)

    def draw(self, seed: int, first: int, count: int) -> np.ndarray:
        """The values of members `first` to `first + count - 1` (count), in `unit`.

        Each depends on the seed, the key and its member's number alone: Philox counts up to it. Other
        members, other spreads and the order in which they are asked for leave it as it is.
        """
        key = np.random.SeedSequence([seed, *self.key.encode()]).generate_state(2, np.uint64)
        skipped, within = divmod(first, OUTPUTS_PER_COUNT)
        words = np.random.Philox(key=key, counter=skipped).random_raw(within + count)[within:]
        share = ((words >> np.uint64(BITS_LEFT_OUT)) + 0.5) * 2.0 ** (BITS_LEFT_OUT - 64)  # inside (0, 1)
        return float(self.centre) + float(self.width) * self._deviations(share)

    def _deviations(self, share: np.ndarray) -> np.ndarray:
        if self.shape == UNIFORM:
            return 2 * share - 1
        return np.array([NormalDist().inv_cdf(part) for part in share.tolist()])

    def plain(self) -> dict[str, str]:
        """The spread as plain data for JSON; `from_plain` reads it back."""
        exact = {"centre": decimal_text(self.centre), "width": decimal_text(self.width)}
        return {"key": self.key, "unit": self.unit, "shape": self.shape, **exact}

    @staticmethod
    def from_plain(data: Mapping[str, Any]) -> "Spread":
        """The spread that `plain` wrote down."""
        numbers = exact_number(data["centre"]), exact_number(data["width"])
        return Spread(data["key"], data["unit"], data["shape"], *numbers)

    def __str__(self) -> str:
        if self.shape == NORMAL:
            span = f"about {decimal_text(self.centre)}, standard deviation {decimal_text(self.width)}"
        else:
            low, high = (decimal_text(self.centre + side * self.width) for side in (-1, 1))
            span = f"from {low} to {high}"
        return f"{self.name} {self.shape} {span} {self.unit}".strip()


def read_spread(case: "Case", key: str, text: str) -> Spread:
    """The spread that `key` and `text` describe, tried in the case.

    Raises SpreadError, and CaseError where the case does not allow its values.
    """
    try:
        usual = case.quantity(key)
    except UnknownKeyError as error:
        raise SpreadError(f"spread of {key}: {error}") from None
    full, words = case.full_key(key), text.split()
    normal = words[:1] == [NORMAL]
    amount = text.strip().removeprefix(NORMAL if normal else "")
    if ":" in amount and not normal:
        return _between(case, full, amount, text)
    spread = _about(full, usual, NORMAL if normal else UNIFORM, _width(full, amount, text))
    tried = [spread.centre + side * spread.width for side in ((0,) if normal else (-1, 1))]
    values = ",".join(f"{decimal_text(value)} {spread.unit}" for value in tried)
    read_axis(case, key, values, argument="spread")
    return spread


def _between(case: "Case", key: str, amount: str, text: str) -> Spread:
    """Uniform from one value to a greater one."""
    advice = "write FROM:TO, such as 0:360 deg"
    if amount.count(":") > 1:
        raise SpreadError(f"{key}={text}: a spread has two ends; {advice}")
    values = amount.replace(":", ",")
    try:
        ends = read_axis(case, key, values, argument="spread")
        low, high = ends.values
    except ValueError as error:
        reason = str(error).partition("; write")[0].replace(values, amount)
        raise SpreadError(f"{key}={text}: {reason}; {advice}") from None
    if low > high:
        raise SpreadError(f"{key}={text}: FROM is above TO; {advice}")
    return Spread(key, ends.unit, UNIFORM, (low + high) / 2, (high - low) / 2)


def _width(key: str, amount: str, text: str) -> Quantity:
    measured = measured_at(key)
    assert measured is not None  # it is a number of the case
    try:
        width = parse_quantity(amount, measured.dimension)
    except QuantityError as error:
        raise SpreadError(
            f"{key}={text}: {error}; a spread is WIDTH, FROM:TO or normal STANDARD_DEVIATION"
        ) from None
    if width.value <= 0:
        raise SpreadError(f"{key}={text}: a spread must be wider than 0")
    return width


def _about(key: str, usual: Quantity, shape: str, width: Quantity) -> Spread:
    """About the value that the case has, in the unit of the width."""
    unit = UNITS[width.text.partition(" ")[2]]
    if usual.value and usual.per_turn != unit.per_turn:
        raise SpreadError(f"{key}: the case has {usual}; turns and radians do not go together in a spread")
    return Spread(key, unit.name, shape, usual.value / unit.factor, width.value / unit.factor)
