"""Any unit: products of powers of kg, m, s, A, K and of derived units with their prefixes, exact.

Numbers beside formulas and in them have any unit: 1e6 N/m^1.5, 0.05 V s/rad, 1 mH. An angle is a pure number
(rad = 1), and a frequency in Hz is 2 pi rad/s as everywhere: turns are counted apart, as in `quantities.py`,
so that pi enters in one rounding at the very end.
"""

import re
from fractions import Fraction
from functools import lru_cache
from math import isqrt
from typing import NamedTuple

from vibsim.cases.problems import nearest, shown
from vibsim.cases.quantities import (
    FACTORS,
    FURTHER_UNITS,
    NUMBER,
    UNITS,
    Quantity,
    QuantityError,
    Unit,
    exact_number,
    fits_double,
)

Dimension = tuple[Fraction, ...]  # exponents of kg, m, s, A, K

BASES = ("kg", "m", "s", "A", "K")
LARGEST_POWER = 12  # of a unit
ROOT_DIGITS = 1100  # of factors such as 1000**1.5, as of pi


class AnyUnit(NamedTuple):
    """A unit: value [SI] = number * factor * (2 pi)**turns.

    Attributes
    ----------
    name : canonical text, such as "N s^2/m^2"
    dimension : exponents of kg, m, s, A, K
    """

    name: str
    dimension: Dimension
    factor: Fraction
    turns: int


def dimension(kg: int = 0, m: int = 0, s: int = 0, A: int = 0, K: int = 0) -> Dimension:
    """A dimension by its exponents."""
    return tuple(map(Fraction, (kg, m, s, A, K)))


PURE = dimension()
MASS, LENGTH, TIME = dimension(kg=1), dimension(m=1), dimension(s=1)
RATE = dimension(s=-1)
VELOCITY = dimension(m=1, s=-1)
FORCE = dimension(kg=1, m=1, s=-2)
TORQUE = dimension(kg=1, m=2, s=-2)


def product(a: Dimension, b: Dimension, power: Fraction | int = 1) -> Dimension:
    """The dimension of a b**power."""
    return tuple(x + power * y if y else x for x, y in zip(a, b, strict=True))


# Symbols of units.


class Symbol(NamedTuple):
    dimension: Dimension
    factor: Fraction = Fraction(1)
    turns: int = 0
    prefixes: str = ""


_ALL = "f p n u m k M G"
SYMBOLS = {
    "m": Symbol(LENGTH, prefixes="p n u m c k"),
    "s": Symbol(TIME, prefixes="p n u m"),
    "g": Symbol(MASS, Fraction(1, 1000), prefixes="p n u m k"),
    "t": Symbol(MASS, Fraction(1000)),
    "A": Symbol(dimension(A=1), prefixes=_ALL),
    "K": Symbol(dimension(K=1), prefixes="m"),
    "min": Symbol(TIME, Fraction(60)),
    "h": Symbol(TIME, Fraction(3600)),
    "N": Symbol(FORCE, prefixes=_ALL),
    "J": Symbol(TORQUE, prefixes=_ALL),
    "W": Symbol(dimension(1, 2, -3), prefixes=_ALL),
    "Pa": Symbol(dimension(1, -1, -2), prefixes=_ALL),
    "bar": Symbol(dimension(1, -1, -2), Fraction(100000), prefixes="m"),
    "V": Symbol(dimension(1, 2, -3, -1), prefixes=_ALL),
    "ohm": Symbol(dimension(1, 2, -3, -2), prefixes=_ALL),
    "S": Symbol(dimension(-1, -2, 3, 2), prefixes=_ALL),
    "C": Symbol(dimension(s=1, A=1), prefixes=_ALL),
    "F": Symbol(dimension(-1, -2, 4, 2), prefixes=_ALL),
    "H": Symbol(dimension(1, 2, -2, -2), prefixes=_ALL),
    "T": Symbol(dimension(1, 0, -2, -1), prefixes=_ALL),
    "Wb": Symbol(dimension(1, 2, -2, -1), prefixes=_ALL),
    "rad": Symbol(PURE, prefixes="u m"),
    "deg": Symbol(PURE, Fraction(1, 360), 1),
    "turn": Symbol(PURE, turns=1),
    "rev": Symbol(PURE, turns=1),
    "Hz": Symbol(RATE, turns=1, prefixes="m k M G"),
    "rpm": Symbol(RATE, Fraction(1, 60), 1),
}
PREFIXES = {
    "f": Fraction(1, 10**15),
    "p": Fraction(1, 10**12),
    "n": Fraction(1, 10**9),
    "u": Fraction(1, 10**6),
    "m": Fraction(1, 10**3),
    "c": Fraction(1, 100),
    "k": Fraction(10**3),
    "M": Fraction(10**6),
    "G": Fraction(10**9),
}
SPELLINGS = {
    "Ohm": "ohm", "\u03a9": "ohm", "\u2126": "ohm", "°": "deg", "degree": "deg", "degrees": "deg",
    "turns": "turn",
    "sec": "s", "hour": "h", "hr": "h", "Ncm": "N cm", "Nmm": "N mm", "Nm": "N m", "mNm": "mN m",
    "kNm": "kN m", "kgm": "kg m", "Ns": "N s", "Nms": "N m s", "Vs": "V s", "As": "A s", "Ws": "W s",
}  # fmt: skip
SUPERSCRIPTS = {"²": "2", "³": "3", "⁴": "4"}


@lru_cache(maxsize=512)
def symbol(word: str) -> Symbol | None:
    """The unit that a word such as mH stands for, its prefix in the factor; None for others."""
    if word in SYMBOLS:
        return SYMBOLS[word]
    base = SYMBOLS.get(word[1:])
    if base is None or word[0] not in base.prefixes.split():
        return None
    return base._replace(factor=base.factor * PREFIXES[word[0]])


# Reading units.


_WORD = re.compile(r"\s*([A-Za-z\u03a9\u2126°]+)")
_POWER = re.compile(
    r"\s*(?:\^|\*\*)\s*(?:(-?\d+(?:\.\d+)?)|\(\s*(-?\d+(?:\.\d+)?)\s*(?:/\s*(\d+)\s*)?\))|([²³⁴])|(\d)(?![\w.])"
)
_TIMES = re.compile(r"\s*[*·⋅×]|\s*\.(?=\s*[A-Za-z])")
_MIDDOT = re.compile(r"\s*[·⋅×]")
_OVER = re.compile(r"\s*/")


class _Factor(NamedTuple):
    """A power of a symbol; a spelling such as Nm is several."""

    word: str
    power: Fraction
    end: int


class _UnitReader:
    """Reads the longest unit at a place of a text.

    signs : whether a product may be written with * and . too, as beside formulas
    """

    def __init__(self, text: str, signs: bool):
        self.text, self.times = text, _TIMES if signs else _MIDDOT
        self.factors: list[tuple[str, Fraction]] = []

    def read(self, at: int) -> int:
        """Where the unit ends that begins at `at`; `at` itself where there is none."""
        one = re.compile(r"\s*1(?=\s*/)").match(self.text, at)
        end = at
        if one is None:
            factor = self._factor(at)
            if factor is None:
                return at
            end = self._take(factor, 1)
        else:
            over = _OVER.match(self.text, one.end())
            assert over is not None
            end = self._divisor(over.end())
            if end < 0:
                return at
        return self._rest(end, over=one is not None)

    def _rest(self, end: int, over: bool) -> int:
        """Position in the text behind the factors that follow the first one; over: whether a divisor came
        already.
        """
        while True:
            slash = _OVER.match(self.text, end)
            if slash:
                behind = self._divisor(slash.end())
                if behind < 0:
                    return end
                end, over = behind, True
                continue
            times = self.times.match(self.text, end)
            factor = self._factor(times.end() if times else end)
            if factor is None:
                return end
            if over:
                raise QuantityError("write a unit with two factors below the line as J/(kg K) or J/kg/K")
            end = self._take(factor, 1)

    def _divisor(self, at: int) -> int:
        """The end of a factor, or of several in brackets, below the line; -1 where there is none."""
        factor = self._factor(at)
        if factor is not None:
            return self._take(factor, -1)
        bracket = re.compile(r"\s*\(").match(self.text, at)
        if bracket is None:
            return -1
        inside, end = [], bracket.end()
        while (factor := self._factor(end)) is not None:
            inside.append(factor)
            end = factor.end
            times = self.times.match(self.text, end)
            end = times.end() if times else end
        close = re.compile(r"\s*\)").match(self.text, end)
        if len(inside) < 2 or close is None:
            return -1
        for factor in inside:
            self._take(factor, -1)
        return close.end()

    def _take(self, factor: _Factor, sign: int) -> int:
        *first, last = SPELLINGS.get(factor.word, factor.word).split()
        self.factors += [(word, Fraction(sign)) for word in first]
        self.factors.append((last, sign * factor.power))
        return factor.end

    def _factor(self, at: int) -> _Factor | None:
        match = _WORD.match(self.text, at)
        if match is None:
            return None
        word, end = match[1], match.end()
        if self.text[end : end + 1] == "_" or re.compile(r"\s*\(").match(self.text, end):
            return None  # a name, or a function
        if symbol(SPELLINGS.get(word, word).split()[0]) is None:
            return None
        power = _POWER.match(self.text, end)
        if power is None:
            return None if re.compile(r"[\w]").match(self.text, end) else _Factor(word, Fraction(1), end)
        plain, top, bottom, small, digit = power.groups()
        value = Fraction(plain or top or digit or SUPERSCRIPTS[small]) / int(bottom or 1)
        if not 0 < abs(value) <= LARGEST_POWER:
            raise QuantityError(f"a power of a unit must be between -{LARGEST_POWER} and {LARGEST_POWER}")
        return _Factor(word, value, power.end())


def read_unit(text: str, at: int = 0, signs: bool = False) -> tuple[AnyUnit | None, int]:
    """The longest unit that begins at a place of a text, and where it ends; None, and the place, without one.

    Raises QuantityError for a unit that cannot be.
    """
    text = text.replace("\u00b5", "u").replace("\u03bc", "u")
    reader = _UnitReader(text, signs)
    end = reader.read(at)
    return (_unit(reader.factors), end) if reader.factors else (None, at)


def _unit(factors: list[tuple[str, Fraction]]) -> AnyUnit:
    total, factor, turns = PURE, Fraction(1), Fraction(0)
    for word, power in factors:
        one = symbol(word)
        assert one is not None
        total = product(total, one.dimension, power)
        factor *= rational_power(one.factor, power)
        turns += one.turns * power
    name = unit_name(factors)
    if turns.denominator != 1:
        raise QuantityError(f"{name} has a root of a turn; write the frequency in rad/s, the angle in rad")
    if name == "1/min":
        raise QuantityError("1/min may be rpm or 1/(60 s); write rpm, or 1/s")
    return AnyUnit(name, total, factor, int(turns))


def unit_name(factors: list[tuple[str, Fraction]]) -> str:
    """A unit as text: "N s^2/m^2", "1/K"; an empty one for no factors."""
    top = [_powered(word, power) for word, power in factors if power > 0]
    bottom = [_powered(word, -power) for word, power in factors if power < 0]
    return "/".join([" ".join(top) or ("1" if bottom else ""), *bottom])


def _powered(word: str, power: Fraction) -> str:
    if power == 1:
        return word
    twice = power * 1000
    text = f"{float(power):g}" if twice.denominator == 1 else f"({power})"
    return f"{word}^{text}"


def rational_power(base: Fraction, power: Fraction) -> Fraction:
    """base**power for base > 0: exact where that is a fraction, else right to 1100 digits."""
    whole = base**power.numerator if power.denominator == 1 else None
    if whole is not None:
        return whole
    root, raised = power.denominator, base**power.numerator
    scale = 10 ** (ROOT_DIGITS * root)
    exact = (_root(raised.numerator, root), _root(raised.denominator, root))
    if exact[0] ** root == raised.numerator and exact[1] ** root == raised.denominator:
        return Fraction(*exact)
    return Fraction(_root(raised.numerator * scale // raised.denominator, root), 10**ROOT_DIGITS)


def _root(n: int, k: int) -> int:
    """The whole part of the k-th root of n."""
    if k == 2:
        return isqrt(n)
    low = 1 << ((n.bit_length() + k - 1) // k)
    while True:
        next_ = ((k - 1) * low + n // low ** (k - 1)) // k
        if next_ >= low:
            return low
        low = next_


# Names of dimensions, for messages.


_KNOWN = (
    "", "kg", "m", "s", "A", "K", "N", "N m", "N/m", "N s/m", "m/s", "m/s^2", "1/s", "1/m", "s/m", "1/s^2",
    "kg m^2", "kg/m", "kg/m^3", "W", "Pa", "V", "ohm", "H", "F", "C", "T", "N/A", "N m/A", "V s", "V s/m",
    "A/s", "V/s", "N m s", "N s", "N/s", "m^2", "m^3", "1/K",
)  # fmt: skip


@lru_cache(maxsize=1)
def _known() -> dict[Dimension, str]:
    named: dict[Dimension, str] = {PURE: ""}
    for name in _KNOWN[1:]:
        unit, _ = read_unit(name)
        assert unit is not None
        named.setdefault(unit.dimension, name)
    return named


@lru_cache(maxsize=512)
def si_name(of: Dimension) -> str:
    """The SI unit of a dimension as text; empty for a pure number."""
    if of in _known():
        return _known()[of]
    lead, power = ("N", of[0])
    if of[3]:
        lead, power = ("V", of[0])
    lead_symbol = symbol(lead)
    assert lead_symbol is not None
    rest = product(of, lead_symbol.dimension, -power) if power else of
    if power and sum(map(abs, rest)) > sum(map(abs, of)) + 2:
        rest, power = of, Fraction(0)
    factors = [(lead, power)] if power else []
    order = ("kg", "A", "s", "m", "K")
    factors += [(word, rest[BASES.index(word)]) for word in order if rest[BASES.index(word)]]
    return unit_name(factors)


def called(of: Dimension) -> str:
    """A dimension in messages."""
    return si_name(of) or "a pure number"


# Quantities of any unit.


_QUANTITY = re.compile(rf"\s*(?P<number>{NUMBER}(?:\s*/\s*\d+(?!\s*/\s*[A-Za-z]))?)", re.ASCII)


@lru_cache(maxsize=1024)
def any_quantity(text: str) -> tuple[Quantity, Dimension]:
    """The quantity that `text` spells, and its dimension; without a unit it is a pure number.

    Raises QuantityError.
    """
    match = _QUANTITY.match(text)
    if match is None:
        raise QuantityError(f"must be a number with its unit, such as 3 N/m^2; got {shown(text)}")
    unit = _unit_behind(text, match.end())
    value = exact_number(match["number"]) * unit.factor
    if not fits_double(value):
        raise QuantityError(f"does not fit double precision (2.3e-308 to 2.2e307), got {shown(text)}")
    return Quantity(f"{match['number']} {unit.name}".strip(), value, unit.turns), unit.dimension


def _unit_behind(text: str, at: int) -> AnyUnit:
    rest = text[at:].strip()
    if not rest:
        return AnyUnit("", PURE, Fraction(1), 0)
    if rest.startswith("/"):
        text, at = "1" + text[at:].lstrip(), 0
    unit, end = read_unit(text, at, signs=True)
    if unit is None or text[end:].strip():
        raise QuantityError(_no_unit(rest, text[end:].strip()))
    return unit


def _no_unit(rest: str, left: str) -> str:
    if re.match(r",\s*\d", rest):
        return f"{shown(rest)} is no unit; write decimals with a point"
    word = re.match(r"[^\W\d]\w*", left.lstrip("/*.( "))
    if word is None:
        return f"{shown(rest)} is no unit; a unit is written like N s^2/m^2"
    near = nearest(word[0], [*SYMBOLS, "kg", "mm", "kN", "mH", "uF"])
    hint = f" (did you mean {near}?)" if near else ""
    if rest.startswith("*"):
        hint += "; the value here is a number: write the formula where it is used"
    return f"unknown unit {shown(word[0])}{hint}; a unit is a product of powers of kg m s A K rad N J V ..."


def dimension_of(quantity: Quantity) -> Dimension:
    """The dimension of a quantity, from its text."""
    return any_quantity(quantity.text)[1]


# Any unit beside those of the table in quantities.py, and quantities of one dimension in any unit of it.


@lru_cache(maxsize=1)
def _named_dimensions() -> dict[Dimension, str]:
    """The dimensions that the table of units has names for; angles are pure numbers."""
    later = ("angle", "inverse angular rate", "torsional stiffness", "torsional damping")
    names = [name for name in FACTORS if name not in later]
    return {dimension_of_name(name): name for name in reversed(names)}


@lru_cache(maxsize=64)
def dimension_of_name(name: str) -> Dimension:
    """The dimension behind a name, such as "stiffness" or "N/m^3"."""
    return any_quantity(f"1 {next(iter(FACTORS[name])) if name in FACTORS else name}".strip())[1]


@lru_cache(maxsize=256)
def further_unit(text: str) -> Unit | None:
    """A unit that the table has not, such as kN/m^3; None for what is none."""
    try:
        unit, end = read_unit(text, signs=True)
    except QuantityError:
        return None
    if unit is None or text[end:].strip():
        return None
    name = _named_dimensions().get(unit.dimension) or si_name(unit.dimension)
    return Unit(unit.name, name, unit.factor, unit.turns)


if further_unit not in FURTHER_UNITS:
    FURTHER_UNITS.append(further_unit)


def bare_as(old: str, bare: str) -> str:
    """A bare number as a text in the SI unit of a quantity that it replaces; for a frequency as it is."""
    try:
        quantity, of = any_quantity(old)
    except QuantityError:
        return bare
    return bare if quantity.per_turn else f"{bare.strip()} {si_name(of)}".strip()


TURNING_UNITS = {
    "inertia": "kg m^2, g m^2 or kg cm^2",
    "angle": "rad, mrad, deg or turn",
    "angular rate": "Hz, rpm, deg/s or rad/s",
    "inverse angular rate": "s/rad",
    "torque": "N m, mN m or kN m",
    "torsional stiffness": "N m/rad, kN m/rad or N m/deg",
    "torsional damping": "N m s/rad or mN m s/rad",
}  # for messages


def quantity_of(text: str, name: str) -> Quantity:
    """A quantity in any unit of a dimension, such as "torsional stiffness" or "N/m^3"; a bare number is SI,
    but for angular rates. Raises QuantityError.
    """
    wanted = dimension_of_name(name)
    units = TURNING_UNITS.get(name) or si_name(wanted)
    what = f"{'an' if name[0] in 'aei' else 'a'} {name} in {units}" if name in FACTORS else f"in {units}"
    allowed = f"must be {what}" if units else "must be a plain number"
    try:
        quantity, own = any_quantity(text)
        if not quantity.text.partition(" ")[2] and (name != "angular rate" or quantity.value == 0):
            quantity, own = any_quantity(f"{quantity.text} {_si_text(name)}".strip())
    except QuantityError as error:
        raise QuantityError(f"{allowed}, got {shown(text)}; {error}") from None
    if own != wanted:
        raise QuantityError(f"{allowed}, got {shown(text)}, which is {called(own)}")
    return quantity


def _si_text(name: str) -> str:
    return next(iter(FACTORS[name])) if name in FACTORS else name


def free_dimension(quantity: Quantity) -> str:
    """Name of the kind of a number of any unit: "stiffness", "N/m^3", "number"."""
    return UNITS[quantity.text.partition(" ")[2]].dimension
