"""One axis of a sweep: a key of the case and the exact values it takes, in the order they are written."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.problems import CaseError
from vibsim.cases.schema.forms import LONG
from vibsim.cases.schema.keys import measured_at
from vibsim.cases.values.quantities import decimal_text, exact_number
from vibsim.cases.values.ranges import RangeError, RangeValue, parse_range
from vibsim.cases.values.units import UNITS, find_unit, si_unit

if TYPE_CHECKING:
    from vibsim.cases import Case

MOST_TRIED = 1000  # values of an axis; trying one takes 0.1 ms
MOST_LISTED = 1000  # values written out in an attribute of the file; even steps are told in short
ROUNDED = 2.1e-14  # relative difference of two ratios of values that are rounded to 15 digits (5e-15 each)
SCALE_NAMES = {
    "excitation.Omega0": "omega0",
    "motor.Omega0": "omega0",
    "rest_distance.value": "rest_distance",
}


def scale_name(key: str) -> str:
    """What the values of a key are called: the last part of the key, omega0 for the motor constant.

    In the long form of a case with the name of the part: wall_k for stops.wall.k, m_ram for bodies.ram.
    """
    section, *names = key.split(".")
    if section in LONG.named and len(names) > 1:
        return "_".join(names)
    return f"m_{names[0]}" if section == "bodies" else SCALE_NAMES.get(key, names[-1])


@dataclass(frozen=True)
class Axis:
    """A key that is varied, or several that are given the same values.

    Attributes
    ----------
    key : dotted key of the case, such as "excitation.Omega0"; the first of several
    unit : unit of the values, as the range has it; empty for a plain number
    values : exact values in that unit, in the order of the range or list, none twice
    also : further keys that take the same values
    """

    key: str
    unit: str
    values: tuple[Fraction, ...]
    also: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of its dimension scale, see `scale_name`."""
        return scale_name(self.key)

    @property
    def way(self) -> int:
        """Which way the values run: 1 ascending (one value too), -1 descending, 0 neither."""
        if all(low < high for low, high in pairwise(self.values)):
            return 1
        return -1 if all(high > low for high, low in pairwise(self.values)) else 0

    @property
    def by_ratio(self) -> bool:
        """Whether the values, three or more above 0, are evenly spaced by ratio, as of log FROM:TO/COUNT."""
        if len(self) < 3 or min(self.values) <= 0:
            return False
        ratios = [float(after / before) for before, after in pairwise(self.values)]
        even = len({after - before for before, after in pairwise(self.values)}) == 1
        return not even and max(ratios) - min(ratios) <= ROUNDED * max(ratios)

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of the case that the axis sets."""
        return (self.key, *self.also)

    def __len__(self) -> int:
        return len(self.values)

    def numbers(self) -> np.ndarray:
        """The values as doubles (n), in `unit`."""
        return np.array([float(value) for value in self.values])

    def text(self, position: int) -> str:
        """One value with its unit, as `Case.with_values` takes it."""
        return f"{decimal_text(self.values[position])} {self.unit}".strip()

    def changes(self, position: int) -> dict[str, str]:
        """What a point at this position replaces in the case: key -> text."""
        return dict.fromkeys(self.keys, self.text(position))

    def plain(self) -> dict[str, Any]:
        """The axis as plain data for JSON; `from_plain` reads it back."""
        also = {"also": list(self.also)} if self.also else {}
        data: dict[str, Any] = {"key": self.key, **also, "unit": self.unit}
        step = (self.values[-1] - self.values[0]) / max(len(self) - 1, 1)
        if len(self) > MOST_LISTED and all(high - low == step for low, high in pairwise(self.values)):
            ends = {"from": decimal_text(self.values[0]), "step": decimal_text(step)}
            return {**data, **ends, "count": len(self)}
        return {**data, "values": [decimal_text(value) for value in self.values]}

    @staticmethod
    def from_plain(data: Mapping[str, Any]) -> "Axis":
        """The axis that `plain` wrote down."""
        if "values" in data:
            values = tuple(map(exact_number, data["values"]))
        else:
            first, step = exact_number(data["from"]), exact_number(data["step"])
            values = tuple(first + i * step for i in range(data["count"]))
        return Axis(data["key"], data["unit"], values, tuple(data.get("also", ())))

    def part(self, begin: int, end: int) -> "Axis":
        """The axis with its values at positions `begin` to `end - 1`."""
        return replace(self, values=self.values[begin:end])

    def __str__(self) -> str:
        ends = (self.values[0], self.values[-1]) if self.way else (min(self.values), max(self.values))
        span = " to ".join(dict.fromkeys(map(decimal_text, ends)))
        return f"{self.name} {span} {self.unit}".strip()


def read_axis(case: "Case", key: str, text: str, bare_unit: str = "", argument: str = "axes") -> Axis:
    """The axis that `key` and the range `text` describe, every value tried in the case.

    Parameters
    ----------
    key : dotted or unambiguous short key of a number of the case; KEY=KEY for several of the same values
    text : a range, see `vibsim.cases.values.ranges`
    bare_unit : unit of a range that has none; by default SI, and an angular rate must have one
    argument : of Python in which the user wrote it, for messages

    Raises UnknownKeyError, RangeError, and CaseError where the case does not allow a value.
    """
    full, *also = (_number_key(case, each.strip()) for each in key.split("="))
    values = _in_one_unit(parse_range(text, bare_unit or _bare_unit(full)))
    exact = [value.value for value in values]
    for low, high in pairwise(sorted(exact)):
        if low == high:
            raise RangeError(f"{text} has the value {decimal_text(low)} twice")
    axis = Axis(full, values[0].unit, tuple(exact), tuple(also))
    _check(case, axis, argument)
    return axis


def _number_key(case: "Case", key: str) -> str:
    """The dotted key of a number of the case. Raises UnknownKeyError."""
    case.quantity(key)
    return case.full_key(key)


def range_and_unit(key: str, values: object) -> tuple[str, str]:
    """The range that Python code gives for a key, and the unit of its bare numbers ("": as without one).

    values : as of `range_text`, or a pair of such values and their unit

    Raises RangeError for anything else, and for a unit that there is not.
    """
    match values:
        case (listed, str() as unit_text) if isinstance(values, tuple) and _is_listed(listed):
            unit = find_unit(unit_text)
            if unit is None:
                raise RangeError(f"{key}: unknown unit {unit_text!r}")
            return range_text(key, listed), unit.name
    return range_text(key, values), ""


def _is_listed(values: object) -> bool:
    return isinstance(values, Iterable) and not isinstance(values, str | Mapping | bytes)


def range_text(key: str, values: object) -> str:
    """The range that Python code gives for a key: a text as it is, values (numbers or texts) as a list.

    Raises RangeError for anything else.
    """
    if isinstance(values, str):
        return values
    if isinstance(values, Iterable) and _is_listed(values):
        return ",".join(_value_text(key, value) for value in values)
    raise RangeError(f"{key}: must be a range such as '3:7:0.05 Hz' or a list of values, got {values!r}")


def _value_text(key: str, value: object) -> str:
    """repr of a float is its shortest decimal, also where numpy holds it."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, bool) or not isinstance(value, str | int | float | Fraction):
        raise RangeError(f"{key}: a value must be a number, or a text such as '3 Hz', got {value!r}")
    return str(value)


def _bare_unit(key: str) -> str:
    """The SI unit; none for an angular rate, which must have one."""
    measured = measured_at(key)
    return si_unit(measured.dimension).name if measured and measured.dimension != "angular rate" else ""


def _in_one_unit(values: list[RangeValue]) -> list[RangeValue]:
    """The values in the unit of the last; a list may mix units of one dimension."""
    unit = UNITS[values[-1].unit]
    if all(value.unit == unit.name for value in values):
        return values
    for value in values:
        if (UNITS[value.unit].dimension, UNITS[value.unit].per_turn) != (unit.dimension, unit.per_turn):
            raise RangeError(f"{value.text} and {values[-1].text} do not go together on one axis")
    return [
        replace(value, value=value.value * UNITS[value.unit].factor / unit.factor, unit=unit.name)
        for value in values
    ]


def _check(case: "Case", axis: Axis, argument: str) -> None:
    """Try the values, of a long axis some and both ends; a CaseError names the argument instead of overrides.

    What a case allows is a span of numbers, so that the ends tell; a point that it does not allow all the
    same fails alone.
    """
    for position in sorted({round(i) for i in np.linspace(0, len(axis) - 1, min(len(axis), MOST_TRIED))}):
        try:
            case.with_values(axis.changes(position))
        except CaseError as error:
            raise CaseError(replace(problem, file=argument) for problem in error.problems) from None
