"""Numbers that record how they come about, so that the same operations can be repeated on other doubles.

What is written for all number types leaves behind, on some numbers to begin with, the list of its operations
and of the comparisons that it went by. On other doubles for these the operations give the very bits that the
whole would give, as long as the comparisons fall out the same.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from vibsim.physics import elementary
from vibsim.physics.numbers import TWO_PI, Doubles

Operation = Callable[[Any, Any], Any]
Step = tuple[Operation, int, int]  # what is done, and the places of its two numbers


class NotRecorded(TypeError):
    """A use of a number that no record can repeat: as a double, or as a key."""


class Record:
    """Operations in their order on numbers in places: `count` inputs first, then constants and results.

    comparisons : (step, outcome): comparisons, with how they fell out
    """

    def __init__(self, inputs: Sequence[float]):
        self.count, self.values = len(inputs), list(inputs)
        self.steps: list[tuple[int, Step]] = []
        self.comparisons: list[tuple[Step, bool]] = []

    @property
    def inputs(self) -> list[Recorded]:
        """The numbers to begin with."""
        return [Recorded(self, place) for place in range(self.count)]

    def place(self, number: Any) -> int:
        """Place of a number; a constant gets a place of its own."""
        if isinstance(number, Recorded):
            return number.place
        self.values.append(number)
        return len(self.values) - 1

    def result(self, operation: Operation, one: Any, other: Any) -> Recorded:
        """The number that an operation makes of two."""
        step = operation, self.place(one), self.place(other)
        place = self.place(operation(self.values[step[1]], self.values[step[2]]))
        self.steps.append((place, step))
        return Recorded(self, place)

    def outcome(self, comparison: Operation, one: Any, other: Any) -> bool:
        """Outcome of a comparison, which is recorded."""
        step = comparison, self.place(one), self.place(other)
        outcome = bool(comparison(self.values[step[1]], self.values[step[2]]))
        self.comparisons.append((step, outcome))
        return outcome

    def repeated(self, inputs: Sequence[float]) -> list[float] | None:
        """The numbers in all places for other inputs; None where a comparison falls out otherwise."""
        values = [*inputs, *self.values[self.count :]]
        try:
            for place, (operation, one, other) in self.steps:
                values[place] = operation(values[one], values[other])
        except ArithmeticError:
            return None
        for (comparison, one, other), outcome in self.comparisons:
            if comparison(values[one], values[other]) is not outcome:
                return None
        return values


Method = Callable[["Recorded", Any], "Recorded"]


def _both_ways(operation: Operation) -> tuple[Method, Method]:
    """An operation that is recorded, with a recorded number on the left and on the right."""
    return (
        lambda self, other: self.record.result(operation, self, other),
        lambda self, other: self.record.result(operation, other, self),
    )


def _compared(comparison: Operation) -> Callable[[Recorded, Any], bool]:
    """A comparison that is recorded."""
    return lambda self, other: self.record.outcome(comparison, self, other)


class Recorded:
    """A double in a place of a record."""

    __slots__ = ("place", "record")

    def __init__(self, record: Record, place: int):
        self.record, self.place = record, place

    @property
    def value(self) -> float:
        """The double that it was at first."""
        return self.record.values[self.place]

    __add__, __radd__ = _both_ways(operator.add)
    __sub__, __rsub__ = _both_ways(operator.sub)
    __mul__, __rmul__ = _both_ways(operator.mul)
    __truediv__, __rtruediv__ = _both_ways(operator.truediv)
    __lt__ = _compared(operator.lt)
    __le__ = _compared(operator.le)
    __gt__ = _compared(operator.gt)
    __ge__ = _compared(operator.ge)
    __eq__ = _compared(operator.eq)
    __ne__ = _compared(operator.ne)

    def __neg__(self) -> Recorded:
        return self.record.result(_negative, self, self)

    def __abs__(self) -> Recorded:
        return self.record.result(_size, self, self)

    def __bool__(self) -> bool:
        return self.record.outcome(operator.ne, self, 0.0)

    def __float__(self) -> float:
        raise NotRecorded("a recorded number was taken as a double")

    def __hash__(self) -> int:
        raise NotRecorded("a recorded number was taken as a key")


def _negative(x: float, _: float) -> float:
    return -x


def _size(x: float, _: float) -> float:
    return abs(x)


def _root(x: float, _: float) -> float:
    return math.sqrt(x)


class RecordedNumbers(Doubles):
    """The kit of `Recorded` numbers, among which plain doubles are constants."""

    name = "double with its record"

    @staticmethod
    def number(value: Any) -> Any:
        return float(value) if isinstance(value, int | Fraction) else value

    @staticmethod
    def sqrt(x: Any) -> Any:
        return x.record.result(_root, x, x) if isinstance(x, Recorded) else math.sqrt(x)


# Numbers that carry their derivatives by parameters: forward differentiation of whatever computes with them.
#
# A number is a double and the row of its derivatives; every operation applies the rules of differentiation.
# What is written for all number types gives derivatives so, exact to rounding.


Plain = float | int


class Sloped:
    """A double and its derivatives by each parameter. Compared by the double alone."""

    __slots__ = ("slope", "value")
    __array_ufunc__ = None  # else a numpy number on the left would spread over it
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value: float, slope: np.ndarray):
        self.value, self.slope = value, slope

    def __add__(self, other: Sloped | Plain) -> Sloped:
        if isinstance(other, Sloped):
            return Sloped(self.value + other.value, self.slope + other.slope)
        return Sloped(self.value + other, self.slope)

    __radd__ = __add__

    def __neg__(self) -> Sloped:
        return Sloped(-self.value, -self.slope)

    def __sub__(self, other: Sloped | Plain) -> Sloped:
        return self + -other

    def __rsub__(self, other: Plain) -> Sloped:
        return -self + other

    def __mul__(self, other: Sloped | Plain) -> Sloped:
        if isinstance(other, Sloped):
            slope = self.slope * other.value + other.slope * self.value
            return Sloped(self.value * other.value, slope)
        return Sloped(self.value * other, self.slope * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Sloped | Plain) -> Sloped:
        if isinstance(other, Sloped):
            ratio = self.value / other.value
            return Sloped(ratio, (self.slope - ratio * other.slope) / other.value)
        return Sloped(self.value / other, self.slope / other)

    def __rtruediv__(self, other: Plain) -> Sloped:
        ratio = other / self.value
        return Sloped(ratio, -ratio / self.value * self.slope)

    def __abs__(self) -> Sloped:
        return -self if self.value < 0 else self

    def __float__(self) -> float:
        return self.value

    def __lt__(self, other: Sloped | Plain) -> bool:
        return self.value < float(other)

    def __le__(self, other: Sloped | Plain) -> bool:
        return self.value <= float(other)

    def __gt__(self, other: Sloped | Plain) -> bool:
        return self.value > float(other)

    def __ge__(self, other: Sloped | Plain) -> bool:
        return self.value >= float(other)

    def __eq__(self, other: object) -> bool:
        return self.value == float(other)  # type: ignore[arg-type]


def slope_of(number: Any, count: int) -> np.ndarray:
    """The derivatives of a number by `count` parameters; 0 for one that carries none."""
    return number.slope if isinstance(number, Sloped) else np.zeros(count)


def _lifted(function: Callable[[float], float], derivative: Callable[[float], float]) -> Callable[[Any], Any]:
    """A function of doubles as one of both sorts of numbers."""

    def lifted(x: Any) -> Any:
        if not isinstance(x, Sloped):
            return function(x)
        return Sloped(function(x.value), derivative(x.value) * x.slope)

    return lifted


def _slope_of_tanh(x: float) -> float:
    cosh = elementary.cosh(x)
    return 1 / cosh / cosh


def _slope_of_asin(x: float) -> float:
    return 1 / math.sqrt((1 - x) * (1 + x))


class SlopedNumbers(Doubles):
    """The kit of `Sloped` numbers, among which plain doubles are constants."""

    name = "double with derivatives"
    sin = staticmethod(_lifted(elementary.sin, elementary.cos))  # type: ignore[assignment]
    cos = staticmethod(_lifted(elementary.cos, lambda x: -elementary.sin(x)))  # type: ignore[assignment]
    exp = staticmethod(_lifted(elementary.exp, elementary.exp))  # type: ignore[assignment]
    expm1 = staticmethod(_lifted(elementary.expm1, elementary.exp))  # type: ignore[assignment]
    log = staticmethod(_lifted(elementary.log, lambda x: 1 / x))  # type: ignore[assignment]
    sinh = staticmethod(_lifted(elementary.sinh, elementary.cosh))  # type: ignore[assignment]
    cosh = staticmethod(_lifted(elementary.cosh, elementary.sinh))  # type: ignore[assignment]
    tanh = staticmethod(_lifted(elementary.tanh, _slope_of_tanh))  # type: ignore[assignment]
    asin = staticmethod(_lifted(elementary.asin, _slope_of_asin))  # type: ignore[assignment]
    acos = staticmethod(_lifted(elementary.acos, lambda x: -_slope_of_asin(x)))  # type: ignore[assignment]
    atan = staticmethod(_lifted(elementary.atan, lambda x: 1 / (1 + x * x)))  # type: ignore[assignment]
    sqrt = staticmethod(_lifted(math.sqrt, lambda x: 0.5 / math.sqrt(x)))

    @staticmethod
    def power(a: Any, p: float) -> Any:
        value = elementary.power(float(a), p)
        return (
            Sloped(value, p * elementary.power(a.value, p - 1) * a.slope) if isinstance(a, Sloped) else value
        )

    @staticmethod
    def sine_cosine(x: Any) -> tuple[Any, Any]:
        return SlopedNumbers.sin(x), SlopedNumbers.cos(x)

    @staticmethod
    def rounded_sine_cosine(angle: Any) -> tuple[Any, Any]:
        sine, cosine = Doubles.rounded_sine_cosine(float(angle))
        if not isinstance(angle, Sloped):
            return sine, cosine
        return Sloped(sine, cosine * angle.slope), Sloped(cosine, -sine * angle.slope)

    @staticmethod
    def tolerance_exponent(scene: Any) -> float:
        return elementary.log2(float(scene.tol))

    @staticmethod
    def number(value: Any) -> Any:
        return float(value) if isinstance(value, Fraction) else value

    @staticmethod
    def exponent(x: Any) -> int:
        return Doubles.exponent(float(x))

    @staticmethod
    def turn_angle(cycles: Any, cycles_lo: Any, t: Any) -> Any:
        angle = Doubles.turn_angle(float(cycles), float(cycles_lo), float(t))
        turned = TWO_PI * (float(t) * (cycles + cycles_lo) + float(cycles) * (t - float(t)))
        return Sloped(angle, turned.slope) if isinstance(turned, Sloped) else angle

    @staticmethod
    def reduce_angle(angle: Any) -> tuple[Any, float]:
        reduced, turns = Doubles.reduce_angle(float(angle))
        return (Sloped(reduced, angle.slope) if isinstance(angle, Sloped) else reduced), turns
