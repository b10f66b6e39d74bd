"""Quantities: decimal text to exact fraction to SI, with one rounding to a double at the very end."""

import re
from fractions import Fraction
from typing import NamedTuple

from vibsim.cases.problems import shown
from vibsim.cases.spelling import nearest
from vibsim.cases.values.pi import radians_to_turns, times_two_pi
from vibsim.cases.values.units import UNITS, Unit, find_unit, si_unit, unit_names

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
    value : exact value in SI units; in turns or turns per second where `per_turn`
    per_turn : True for Hz, rpm, rev/s, deg/s, deg and turn
    """

    text: str
    value: Fraction
    per_turn: bool = False

    def number(self) -> float:
        """Correctly rounded value in SI units (rad and rad/s for angles and rates)."""
        return times_two_pi(self.value, 1 if self.per_turn else 0)

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
    value = exact_number(number) * unit.factor
    if value and not SMALLEST <= abs(value) <= LARGEST:
        raise _out_of_range(text)
    return Quantity(f"{number} {unit.name}".strip(), value, unit.per_turn)


def exact_number(text: str) -> Fraction:
    """A decimal number, or a decimal over a whole number such as 1/3, as an exact fraction."""
    if len(text) > LONGEST_NUMBER:
        raise QuantityError(f"a number may have at most {LONGEST_NUMBER} characters, got {shown(text)}")
    top, _, bottom = "".join(text.split()).partition("/")
    digits, _, exponent = top.lower().partition("e")
    if not digits.strip("+-0."):
        top = "0"
    elif exponent and abs(int(exponent)) > LARGEST_EXPONENT:
        raise _out_of_range(text)
    if bottom and not int(bottom):
        raise QuantityError(f"division by zero in {shown(text)}")
    return Fraction(top) / int(bottom) if bottom else Fraction(top)


def _out_of_range(text: str) -> QuantityError:
    return QuantityError(f"does not fit double precision (2.3e-308 to 2.2e307), got {shown(text)}")


def allowed_units(dimension: str, alternative: str = "") -> str:
    """What may be written, in words: "a length in m, mm, um or cm"."""
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
