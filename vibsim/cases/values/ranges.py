"""Ranges for sweeps, counted exactly: 3:7:0.05 is 81 values, and one of them is 3.05.

    a:b:h    from a to b in steps of h, both ends included where a step meets them; falling, h needs no sign
    a:b/n    n values, evenly spaced, both ends included
    log a:b/n    n values, evenly spaced by ratio, both ends included
    a,b,c    a list

One unit, wherever it stands, holds for all values ("3:7:0.05 Hz", "0:2mm/20"), or each value of a list has
its own ("1 mm, 2 mm").
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction

from vibsim.cases.problems import shown
from vibsim.cases.spelling import nearest
from vibsim.cases.values.quantities import NUMBER, QuantityError, decimal_text, exact_number
from vibsim.cases.values.units import UNITS, find_unit

MOST_VALUES = 1_000_000
# Values between the ends of a range by ratio are rounded to so many significant digits: few enough to be
# written down, and as many as a double keeps. A million products of 40 digits are right to 34.
RATIO_DIGITS = Context(prec=15)
RATIO_PRODUCTS = Context(prec=40)
_PART = rf"\s*(?P<number>{NUMBER})(?P<over>/\d+)?(?P<unit>.*?)(?P<behind>\s*/\s*\d+)?\s*"


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
    """What stands behind the word log of a range by ratio; None for any other text."""
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
    unit = find_unit(name)
    if unit is None:
        near = nearest(name, filter(None, UNITS))
        hint = f" (did you mean {near}?)" if near else ""
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
