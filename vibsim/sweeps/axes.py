"""One axis of a sweep: a key of the case and the exact values it takes, in the order they are written."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.problems import CaseError, counted
from vibsim.cases.quantities import (
    UNITS,
    Quantity,
    QuantityError,
    RangeError,
    RangeValue,
    any_unit_named,
    decimal_text,
    exact_number,
    parse_range,
    si_unit,
)
from vibsim.cases.schema_keys import LONG, UnknownKeyError
from vibsim.results.store import from_plain, stored

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
    """Name of the values of a key: the last part of the key, omega0 for the motor constant.

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
        """Direction of the values: 1 ascending (one value too), -1 descending, 0 neither."""
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
        """Changes of the case by a point at this position: key -> text."""
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
    text : a range, see `vibsim.cases.quantities`
    bare_unit : unit of a range that has none; by default SI, and an angular rate must have one
    argument : of Python in which the user wrote it, for messages

    Raises UnknownKeyError, RangeError, and CaseError where the case does not allow a value.
    """
    full, *also = (_number_key(case, each.strip()) for each in key.split("="))
    values = _in_one_unit(parse_range(text, bare_unit or _bare_unit(case, full)))
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
            unit = any_unit_named(unit_text)
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


def _bare_unit(case: "Case", key: str) -> str:
    """The SI unit; none for an angular rate, which must have one."""
    measured = case.measured(key)
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


# How a value of the case varies over an ensemble: its distribution, exact, and the numbers drawn from it.
#
# x1=1 mm             uniform, up to 1 mm either side of the case's value
# phi=0:360 deg       uniform from 0 to 360 degrees
# v1=normal 2 mm/s    normal about the case's value, with that standard deviation


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
        """Name of its values, as those of an axis."""
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
        from statistics import NormalDist

        return np.array([NormalDist().inv_cdf(part) for part in share.tolist()])

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
    spread = _about(full, usual, NORMAL if normal else UNIFORM, _width(case, full, amount, text))
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


def _width(case: "Case", key: str, amount: str, text: str) -> Quantity:
    measured = case.measured(key)
    assert measured is not None  # it is a number of the case
    try:
        width = measured.parsed(amount)
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


# The axis of an ensemble: members that begin differently, each drawn from the seed and its own number.


NAME = "member"
FULL_TURN = "0:1 turn"
ANGLE_OF_ROTOR = re.compile(r"initial\.[^.]+\.phi")  # of a rotor by its name
ROTOR_ANGLES = ("initial.phi", "initial.motor.phi")  # in the short form of a case, and in the long


@dataclass(frozen=True)
class Members:
    """An axis of `count` members that takes the place of a key's values; see `Axis`.

    Attributes
    ----------
    seed : of all draws
    spreads : what varies, and how
    first : number of the first member: an ensemble may be shared among several files
    """

    key: str = field(default=NAME, kw_only=True)
    count: int
    first: int = field(default=0, kw_only=True)
    seed: int
    spreads: tuple[Spread, ...] = field(metadata=stored("spread"))

    name = NAME
    unit = ""

    def __len__(self) -> int:
        return self.count

    @property
    def way(self) -> int:
        """Members are numbered upwards."""
        return 1

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of the case that the axis sets."""
        return tuple(spread.key for spread in self.spreads)

    @cached_property
    def drawn(self) -> dict[str, np.ndarray]:
        """Values of every member (n) by key, in the unit of the spread."""
        return {spread.key: spread.draw(self.seed, self.first, self.count) for spread in self.spreads}

    def numbers(self) -> np.ndarray:
        """Numbers of the members (n)."""
        return np.arange(self.first, self.first + self.count)

    def text(self, position: int) -> str:
        """Number of one member."""
        return str(self.first + position)

    def changes(self, position: int) -> dict[str, str]:
        """Changes of the case by a member: key -> shortest text that reads back to the number drawn."""
        return {
            spread.key: f"{float(self.drawn[spread.key][position])!r} {spread.unit}".strip()
            for spread in self.spreads
        }

    def part(self, begin: int, end: int) -> "Members":
        """The members at positions `begin` to `end - 1`, each as it was."""
        return replace(self, count=end - begin, first=self.first + begin)

    def __str__(self) -> str:
        return f"{counted(self.count, 'member')}, seed {self.seed}: {'; '.join(map(str, self.spreads))}"


def axis_from_plain(data: Mapping[str, Any]) -> Axis | Members:
    """The axis or ensemble that its `plain` wrote down."""
    return from_plain(Members, data) if "seed" in data else Axis.from_plain(data)


def axes_from_plain(data: Iterable[Mapping[str, Any]]) -> tuple[Axis | Members, ...]:
    """All axes of a sweep."""
    return tuple(map(axis_from_plain, data))


def rotor_angles(case: "Case") -> list[str]:
    """Keys of the angles of the motor, or of all rotors, at the start of a case."""
    return [key for key in case.values if key in ROTOR_ANGLES or ANGLE_OF_ROTOR.fullmatch(key)]


def read_members(case: "Case", count: int, seed: int, spreads: Mapping[str, str]) -> Members:
    """An ensemble of a case; of a motor or rotors, unless told otherwise, over all their angles at the start.

    spreads : key -> spread, see `vibsim.sweeps.axes`

    Raises SpreadError and what `read_spread` raises.
    """
    if count < 1:
        raise SpreadError(f"an ensemble needs at least 1 member, got {count}")
    if seed < 0:
        raise SpreadError(f"the seed must not be negative, got {seed}")
    if not spreads:
        spreads = dict.fromkeys(rotor_angles(case), FULL_TURN)
    if not spreads:
        raise SpreadError('say what varies over the ensemble, such as spread={"x1": "1 mm"}')
    read = tuple(read_spread(case, key, text) for key, text in spreads.items())
    keys = [spread.key for spread in read]
    if len(set(keys)) < len(keys):
        raise SpreadError(f"{next(key for key in keys if keys.count(key) > 1)} is spread twice")
    return Members(count, seed, read)
