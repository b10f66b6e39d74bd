"""Quantities: decimal text to exact fraction to SI, with one rounding to a double at the very end."""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from functools import lru_cache
from math import prod
from typing import NamedTuple

from vibsim.cases.problems import nearest, shown
from vibsim.physics.elementary import radians_to_turns, times_two_pi

# The units that a case may use: a small table, exact factors, angular rate a dimension of its own.
#
# A turn is not a number here: Hz, rpm and deg carry the flag `per_turn`, and their factor counts turns
# instead of radians, so that 5.5 Hz stays 11/2 turns per second and pi enters in one rounding at the very
# end.


class Unit(NamedTuple):
    """One unit: value [SI] = number * factor * (2 pi)**per_turn; per_turn is 1 for Hz, rpm, deg and turn."""

    name: str
    dimension: str
    factor: Fraction
    per_turn: int = False


# The first unit of a dimension is its SI unit, the meaning of a bare number.
FACTORS: dict[str, dict[str, str]] = {
    "mass": {"kg": "1", "g": "1e-3", "t": "1e3"},
    "length": {"m": "1", "mm": "1e-3", "um": "1e-6", "cm": "1e-2"},
    "time": {"s": "1", "ms": "1e-3", "us": "1e-6", "min": "60", "h": "3600"},
    "velocity": {"m/s": "1", "mm/s": "1e-3", "cm/s": "1e-2", "m/min": "1/60"},
    "inverse velocity": {"s/m": "1", "s/mm": "1e3", "s/cm": "1e2"},
    "acceleration": {"m/s^2": "1", "mm/s^2": "1e-3", "cm/s^2": "1e-2"},
    "force": {"N": "1", "mN": "1e-3", "kN": "1e3"},
    "stiffness": {"N/m": "1", "N/mm": "1e3", "kN/m": "1e3", "kN/mm": "1e6", "MN/m": "1e6", "N/cm": "1e2"},
    "damping": {"N s/m": "1", "N s/mm": "1e3", "kN s/m": "1e3", "kg/s": "1"},
    "inertia": {"kg m^2": "1", "g m^2": "1e-3", "kg cm^2": "1e-4", "g cm^2": "1e-7", "kg mm^2": "1e-6"},
    "torque": {"N m": "1", "mN m": "1e-3", "kN m": "1e3", "N cm": "1e-2", "N mm": "1e-3"},
    "angle": {"rad": "1"},
    "angular rate": {"rad/s": "1"},
    "inverse angular rate": {"s/rad": "1"},
    "torsional stiffness": {"N m/rad": "1", "mN m/rad": "1e-3", "kN m/rad": "1e3", "MN m/rad": "1e6"},
    "torsional damping": {"N m s/rad": "1", "mN m s/rad": "1e-3", "kN m s/rad": "1e3"},
    "number": {"": "1"},
}
FACTORS_IN_TURNS: dict[str, dict[str, str]] = {
    "angle": {"deg": "1/360", "turn": "1"},
    "angular rate": {"Hz": "1", "rpm": "1/60", "rev/s": "1", "deg/s": "1/360"},
}
SPELLINGS = {
    "Nm": "N m", "mNm": "mN m", "kNm": "kN m", "Ncm": "N cm", "Nmm": "N mm",
    "Ns/m": "N s/m", "Ns/mm": "N s/mm", "kNs/m": "kN s/m", "m/s/s": "m/s^2",
    "sec": "s", "hour": "h", "hr": "h", "degree": "deg", "degrees": "deg", "rev": "turn", "turns": "turn",
    "rev/min": "rpm", "1/min": "rpm", "turn/s": "rev/s", "turns/s": "rev/s", "cycles/s": "Hz",
}  # fmt: skip


def _table() -> "UnitTable":
    units = UnitTable()
    for table, per_turn in ((FACTORS, False), (FACTORS_IN_TURNS, True)):
        for dimension, factors in table.items():
            for name, factor in factors.items():
                units[name] = Unit(name, dimension, Fraction(factor), per_turn)
    return units


class UnitTable(dict[str, Unit]):
    """Units by name; one that is not in the table is made of others, where any unit is read at all."""

    def __missing__(self, name: str) -> Unit:
        unit = next(filter(None, (read(name) for read in FURTHER_UNITS)), None)
        if unit is None:
            raise KeyError(name)
        return unit


FURTHER_UNITS: list[Callable[[str], Unit | None]] = []  # any_unit.py adds its reader when it is loaded
UNITS = _table()


def si_unit(dimension: str) -> Unit:
    """The SI unit of a dimension, what a bare number is in; one without a name is called by its unit."""
    return UNITS[next(iter(FACTORS[dimension])) if dimension in FACTORS else dimension]


def unit_names(dimension: str) -> list[str]:
    """Names of the units of a dimension; for angular rate the cycles come first, as people mean them."""
    turns, radians = FACTORS_IN_TURNS.get(dimension, {}), FACTORS.get(dimension, {dimension: "1"})
    ordered = [*turns, *radians] if dimension == "angular rate" else [*radians, *turns]
    return [name for name in ordered if name]


def canonical_spelling(text: str) -> str:
    """One spelling for all: "N*s/m", "N.s/m" and "N·s/m" are "N s/m", "kg m²" is "kg m^2", "µm" is "um"."""
    name = text.replace("\u00b2", "^2").replace("**", "^").replace("\u00b5", "u").replace("\u03bc", "u")
    name = name.replace("\u00b0", "deg")
    name = re.sub(r"[*.\u00b7\u22c5\u00d7]", " ", name)
    name = re.sub(r"(?<=[A-Za-z])2$", "^2", name.strip())
    name = re.sub(r"\s*([/^])\s*", r"\1", name)
    name = re.sub(r"\s+", " ", name)
    if name.endswith("m^2") and name[:-3] in ("kg", "g"):
        name = f"{name[:-3]} m^2"
    return SPELLINGS.get(name, name)


@lru_cache(maxsize=256)
def find_unit(text: str) -> Unit | None:
    """The unit that `text` names in any accepted spelling, or None."""
    name = text if text in UNITS else canonical_spelling(text)
    return UNITS.get(name) if name else None


def any_unit_named(text: str) -> Unit | None:
    """The unit that `text` names, be it one of the table or made of others; None for what is none."""
    known = find_unit(text)
    return known or next(filter(None, (read(text) for read in FURTHER_UNITS)), None)


NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_NUMBER_AND_UNIT = re.compile(rf"(?P<number>{NUMBER}(?:\s*/\s*\d+)?)\s*(?P<unit>.*)", re.ASCII | re.DOTALL)
_NOT_FINITE = r"[+-]?\.?(inf|infinity|nan)\b"
LONGEST_NUMBER = 200  # characters; keeps every fraction small
LARGEST_EXPONENT = 1000  # so that 1e999999999 is refused before it is multiplied out
LARGEST = Fraction(2**1024 - 2**970) / 8  # an eighth of the largest double: 2 pi times it still fits
SMALLEST = Fraction(1, 2**1022)  # below it a double loses digits


class QuantityError(ValueError):
    """A text that is no quantity of the dimension asked for; the message says why and what is allowed."""


class Quantity(NamedTuple):
    """An exact value and the text that it came from.

    Attributes
    ----------
    text : canonical text, number as written and unit, e.g. "5.5 Hz"; parses back to the same quantity
    value : exact value in SI units over (2 pi)**per_turn; in turns or turns per second where that is 1
    per_turn : True for Hz, rpm, rev/s, deg/s, deg and turn; other powers for such units as N m/deg
    """

    text: str
    value: Fraction
    per_turn: int = False

    def number(self) -> float:
        """Correctly rounded value in SI units (rad and rad/s for angles and rates)."""
        return times_two_pi(self.value, int(self.per_turn))

    def cycles(self) -> tuple[float, float]:
        """An angular rate in Hz, or an angle in turns, as an unevaluated double-double (high, low)."""
        if not self.per_turn:
            return radians_to_turns(self.value)
        top, bottom = self.value.numerator, self.value.denominator
        high = top / bottom
        high_top, high_bottom = high.as_integer_ratio()
        return high, (top * high_bottom - high_top * bottom) / (bottom * high_bottom)

    def __str__(self) -> str:
        return self.text


def in_own_unit(own: Quantity, value: Fraction) -> str:
    """A value, in SI units and turns as `own`, as a text in the unit that `own` has."""
    name = own.text.partition(" ")[2]
    return f"{decimal_text(value / UNITS[name].factor)} {name}".strip()


@lru_cache(maxsize=1024)  # the values of an axis come once for each point of a sweep
def parse_quantity(text: str, dimension: str, alternative: str = "") -> Quantity:
    """The quantity that `text` spells, e.g. parse_quantity("1 mm", "length").

    `alternative` says in messages what else would be allowed, such as "the word fixed".

    Raises QuantityError for a text that is no number, an unknown or missing unit, a wrong dimension, and a
    value that does not fit a double.
    """
    match = _NUMBER_AND_UNIT.fullmatch(text.strip())
    if match is None:
        raise QuantityError(_not_a_number(text, dimension, alternative))
    number, unit_text = match["number"], match["unit"].strip()
    unit = _unit_of(text, unit_text, dimension, alternative)
    value = exact_number(number)
    if unit.factor != 1:
        value *= unit.factor
    if not fits_double(value):
        raise _out_of_range(text)
    return Quantity(f"{number} {unit.name}".strip(), value, unit.per_turn)


def fits_double(value: Fraction) -> bool:
    """Whether a value is 0 or lies between SMALLEST and LARGEST; mostly its digits tell."""
    size = value.numerator.bit_length() - value.denominator.bit_length()
    return abs(size) < 1000 or not value or SMALLEST <= abs(value) <= LARGEST


def product_fits(factors: Iterable[Quantity]) -> bool:
    """Whether a product fits a double as its factors do; in doubles an overflow is inf."""
    numbers = [factor.number() for factor in factors]
    return not all(numbers) or float(SMALLEST) <= abs(prod(numbers)) <= float(LARGEST)


def quantity_unit(text: str) -> str:
    """The unit of a quantity as it is written behind the number; empty without one."""
    match = _NUMBER_AND_UNIT.fullmatch(text.strip())
    return match["unit"].strip() if match else ""


def is_inertia(text: str) -> bool:
    """Whether a text, `0.3 kg m^2`, is an inertia; few units have a 2 or a square."""
    if "m" not in text or not any(square in text[1:] for square in ("^", "2", "**", "\u00b2")):
        return False
    unit = find_unit(quantity_unit(text))
    return unit is not None and unit.dimension == "inertia"


def exact_number(text: str) -> Fraction:
    """A decimal number, or a decimal over a whole number such as 1/3, as an exact fraction."""
    if len(text) > LONGEST_NUMBER:
        raise QuantityError(f"a number may have at most {LONGEST_NUMBER} characters, got {shown(text)}")
    top, _, bottom = "".join(text.split()).partition("/")
    digits, power, exponent = top.lower().partition("e")
    ten = int(exponent) if power else 0
    if not digits.strip("+-0."):
        digits, ten = "0", 0
    elif abs(ten) > LARGEST_EXPONENT:
        raise _out_of_range(text)
    if bottom and not int(bottom):
        raise QuantityError(f"division by zero in {shown(text)}")
    whole, _, decimals = digits.partition(".")
    if decimals and not decimals.isdigit():
        raise QuantityError(f"must be a number, got {shown(text)}")
    ten -= len(decimals)  # Fraction reads a text itself in three times the time
    return Fraction(int(whole + decimals) * 10 ** max(ten, 0), 10 ** max(-ten, 0) * int(bottom or 1))


def _out_of_range(text: str) -> QuantityError:
    return QuantityError(f"does not fit double precision (2.3e-308 to 2.2e307), got {shown(text)}")


def allowed_units(dimension: str, alternative: str = "") -> str:
    """Values that may be written, in words: "a length in m, mm, um or cm"."""
    *names, last = unit_names(dimension) or [""]
    listed = f"{', '.join(names)} or {last}" if names else last
    article = "an" if dimension[0] in "aeiou" else "a"
    allowed = f"{article} {dimension} in {listed}" if listed else "a plain number"
    return f"{allowed}, or {alternative}" if alternative else allowed


def _not_a_number(text: str, dimension: str, alternative: str) -> str:
    word = text.strip()
    if re.match(_NOT_FINITE, word, re.IGNORECASE):
        return f"must be finite, got {shown(word)}"
    if word.startswith("\u2212"):
        return f"write the minus sign as -, got {shown(word)}"
    return f"must be {allowed_units(dimension, alternative)}, got {shown(word)}"


def _unit_of(text: str, unit_text: str, dimension: str, alternative: str) -> Unit:
    """The unit behind the number; the SI unit where there is none and that is allowed."""
    if not unit_text and dimension != "angular rate":
        return si_unit(dimension)
    if not unit_text:
        raise QuantityError(f"needs a unit ({', '.join(unit_names(dimension))}), got {shown(text)}")
    unit = find_unit(unit_text)
    if unit is not None and unit.dimension == dimension:
        return unit
    message = f"must be {allowed_units(dimension, alternative)}, got {shown(text)}"
    if unit_text[0] == ",":
        message += "; write decimals with a point"
    elif unit is None and unit_text[0].isalpha() and not re.search(r"\d\d", unit_text):
        near = nearest(unit_text, unit_names(dimension)) or nearest(unit_text, filter(None, UNITS))
        message += f"; unknown unit {shown(unit_text)}" + (f" (did you mean {near}?)" if near else "")
    raise QuantityError(message)


def decimal_text(value: Fraction) -> str:
    """The shortest exact text of a fraction: "3.05", "1e-8", or "10/3" where no decimal ends.

    parse_quantity reads each of these back to the same fraction.
    """
    twos, fives, rest = 0, 0, value.denominator
    while rest % 2 == 0:
        twos, rest = twos + 1, rest // 2
    while rest % 5 == 0:
        fives, rest = fives + 1, rest // 5
    if rest != 1:
        return f"{value.numerator}/{value.denominator}"
    places = max(twos, fives)
    digits = str(abs(value.numerator) * 10**places // value.denominator)
    stripped = digits.rstrip("0") or "0"
    exponent = len(digits) - len(stripped) - places if value else 0
    sign = "-" if value < 0 else ""
    return sign + _placed(stripped, exponent)


def _placed(digits: str, exponent: int) -> str:
    """digits * 10**exponent, with a plain point while that is short, else with an exponent."""
    if 0 <= exponent <= 6:
        return digits + "0" * exponent
    if exponent > 6:
        return f"{digits}e{exponent}"
    whole = len(digits) + exponent
    if whole > 0:
        return f"{digits[:whole]}.{digits[whole:]}"
    if whole > -5:
        return "0." + "0" * -whole + digits
    return f"{digits}e{exponent}"


# Numbers as messages, summaries and pages write them.


LEADING_ZEROS = re.compile(r"e([+-])0*(?=\d)")


def number(x: float, digits: int) -> str:
    """A number to so many significant digits, its exponent as short as can be: 0.0025, 1e-6, 2.3e8."""
    return LEADING_ZEROS.sub(lambda match: "e" + match[1].removeprefix("+"), f"{x:.{digits}g}")


# Ranges for sweeps, counted exactly: 3:7:0.05 is 81 values, and one of them is 3.05.
#
#     a:b:h    from a to b in steps of h, both ends included where a step meets them; falling, h needs no sign
#     a:b/n    n values, evenly spaced, both ends included
#     log a:b/n    n values, evenly spaced by ratio, both ends included
#     a,b,c    a list
#
# One unit, wherever it stands, holds for all values ("3:7:0.05 Hz", "0:2mm/20"), or each value of a list has
# its own ("1 mm, 2 mm").


MOST_VALUES = 1_000_000
# Values between the ends of a range by ratio are rounded to so many significant digits: few enough to be
# written down, and as many as a double keeps. A million products of 40 digits are right to 34.
RATIO_DIGITS = Context(prec=15)
RATIO_PRODUCTS = Context(prec=40)
_PART = rf"\s*(?P<number>{NUMBER})(?P<over>\s*/\s*\d+(?![\d.eE]))?(?P<unit>.*?)(?P<behind>\s*/\s*\d+)?\s*"


class RangeError(ValueError):
    """A text that is no range; the message says why, and how ranges are written."""


@dataclass(frozen=True, slots=True)
class RangeValue:
    """One value of a range.

    Attributes
    ----------
    value : exact number, in `unit`
    unit : canonical name of the unit, empty where there is none
    text : number and unit, such as "3.05 Hz": what Case.with_values takes
    """

    value: Fraction
    unit: str
    text: str


def parse_range(text: str, bare_unit: str = "") -> list[RangeValue]:
    """The values of a range, in the order in which it is written.

    Parameters
    ----------
    text : "a:b:h", "a:b/n", "log a:b/n" or "a,b,c", with or without units
    bare_unit : unit of a range that has none, such as "Hz"

    Raises RangeError: not a range, step 0 or in the wrong direction, mixed units, more than 1,000,000 values.
    """
    amount = without_log(text)
    if amount is not None:
        return _by_ratio(amount, bare_unit, text)
    pieces = text.split(":")
    if len(pieces) > 3:
        raise _not_a_range(text)
    if len(pieces) == 1:
        return _listed(text, bare_unit)
    parts = [_part(piece, text) for piece in pieces]
    unit = _common_unit([part.unit for part in parts], text) or bare_unit
    misplaced = parts[:-1] if len(parts) == 2 else parts
    if any(part.over is not None for part in misplaced):
        raise _not_a_range(text)
    start, end = parts[0].number, parts[1].number
    if len(parts) == 3:
        return [_value(number, unit) for number in _stepped(start, end, parts[2].number, text)]
    if parts[1].over is None:
        raise RangeError(f"{shown(text)} has no step; write it as FROM:TO:STEP or FROM:TO/COUNT")
    return [_value(number, unit) for number in _spaced(start, end, parts[1].over, text)]


def without_log(text: str) -> str | None:
    """Text behind the word log of a range by ratio; None for any other text."""
    word, *rest = text.split(maxsplit=1) or [""]
    return (rest or [""])[0] if word == "log" else None


def _by_ratio(amount: str, bare_unit: str, text: str) -> list[RangeValue]:
    """The values of a:b/n, evenly spaced by ratio."""
    pieces = amount.split(":")
    if len(pieces) != 2:
        raise _not_by_ratio(text)
    low, high = parts = [_part(piece, text) for piece in pieces]
    if low.over is not None or high.over is None:
        raise _not_by_ratio(text)
    if not (low.number > 0 and high.number > 0):
        raise RangeError(f"{shown(text)}: both ends of a range by ratio must be above 0")
    unit = _common_unit([part.unit for part in parts], text) or bare_unit
    return [_value(number, unit) for number in _rising(low.number, high.number, high.over, text)]


def _rising(start: Fraction, end: Fraction, count: int, text: str) -> Iterator[Fraction]:
    """start (end / start)^(i / (count - 1)): the ends exact, what lies between rounded to RATIO_DIGITS."""
    _count(count, text)
    exact = RATIO_PRODUCTS
    first = exact.divide(Decimal(start.numerator), Decimal(start.denominator))
    last = exact.divide(Decimal(end.numerator), Decimal(end.denominator))
    growth = exact.exp(exact.divide(exact.ln(exact.divide(last, first)), Decimal(count - 1)))
    yield start
    for _ in range(count - 2):
        first = exact.multiply(first, growth)
        yield Fraction(RATIO_DIGITS.plus(first))
    yield end


@dataclass(frozen=True)
class _Part:
    number: Fraction
    over: int | None  # the n of b/n
    unit: str


def _part(piece: str, text: str) -> _Part:
    match = re.fullmatch(_PART, piece, re.ASCII | re.DOTALL)
    if match is None:
        raise _not_a_range(text)
    try:
        number = exact_number(match["number"])
        divisor = match["over"] or match["behind"]
        over = int(exact_number(divisor.strip().removeprefix("/").strip())) if divisor else None
    except QuantityError as error:
        raise RangeError(str(error)) from None
    return _Part(number, over, _unit(match["unit"].strip(), text))


def _unit(name: str, text: str) -> str:
    if not name:
        return ""
    unit = any_unit_named(name)
    if unit is None:
        near = nearest(name, filter(None, UNITS))
        hint = f" (did you mean {near}?)" if near else ""
        if name[0] in "./+-,;:0123456789":  # what follows the number begins as no unit does
            hint = "; behind / stands how many values, a whole number, such as 3:7/9, and the unit behind it"
        raise RangeError(f"unknown unit {shown(name)} in the range {shown(text)}{hint}")
    return unit.name


def _common_unit(units: list[str], text: str) -> str:
    """The one unit that is named in a range, or an empty text."""
    named = {unit for unit in units if unit}
    if len(named) > 1:
        raise RangeError(f"{shown(text)}: write one unit, at the end, such as 3:7:0.05 Hz")
    return next(iter(named), "")


def _listed(text: str, bare_unit: str) -> list[RangeValue]:
    items = text.split(",")
    if not all(item.strip() for item in items):
        raise RangeError(f"an empty item in the list {shown(text)}" if text.strip() else "the range is empty")
    _limit(len(items), text)
    parts = [_part(item, text) for item in items]
    named = dict.fromkeys(part.unit for part in parts if part.unit)
    if named and not (parts[-1].unit if len(named) == 1 else all(part.unit for part in parts)):
        raise RangeError(f"{shown(text)}: write one unit for all values, or one behind each")
    unit = next(iter(named), bare_unit)
    if any(part.over == 0 for part in parts):
        raise RangeError(f"division by zero in {shown(text)}")
    return [_value(part.number / (part.over or 1), part.unit or unit) for part in parts]


def _stepped(start: Fraction, end: Fraction, step: Fraction, text: str) -> Iterator[Fraction]:
    if step == 0:
        raise RangeError(f"{shown(text)}: the step must not be 0")
    if step < 0 and end > start:
        raise RangeError(f"{shown(text)}: the step leads away from {decimal_text(end)}; leave its sign out")
    step = abs(step) if end >= start else -abs(step)
    count = (end - start) // step + 1
    _limit(count, text)
    return (start + i * step for i in range(count))


def _spaced(start: Fraction, end: Fraction, count: int, text: str) -> Iterator[Fraction]:
    _count(count, text)
    return (start + (end - start) * Fraction(i, count - 1) for i in range(count))


def _count(count: int, text: str) -> None:
    if count < 2:
        raise RangeError(f"{shown(text)}: at least 2 values are needed, got {count}")
    _limit(count, text)


def _limit(count: int, text: str) -> None:
    if count > MOST_VALUES:
        many = f"{float(count):.3g}" if count < 10**300 else f"{Decimal(count):.3g}"
        raise RangeError(f"{shown(text)} has {many} values; at most {MOST_VALUES:,} are allowed")


def _value(number: Fraction, unit: str) -> RangeValue:
    return RangeValue(number, unit, f"{decimal_text(number)} {unit}".strip())


def _not_a_range(text: str) -> RangeError:
    return RangeError(
        f"{shown(text)} is no range; write FROM:TO:STEP, FROM:TO/COUNT, 'log FROM:TO/COUNT' or A,B,C, "
        "with a unit at the end"
    )


def _not_by_ratio(text: str) -> RangeError:
    return RangeError(f"{shown(text)}: a range by ratio is 'log FROM:TO/COUNT', such as 'log 1:1000/31 N/m'")
