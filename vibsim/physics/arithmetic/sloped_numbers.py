"""Numbers that carry their derivatives by parameters: forward differentiation of whatever computes with them.

A number is a double and the row of its derivatives; every operation applies the rules of differentiation.
What is written for all number types gives derivatives so, exact to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

from vibsim.physics.arithmetic import elementary
from vibsim.physics.arithmetic.numbers import TWO_PI, Doubles

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
    sqrt = staticmethod(_lifted(math.sqrt, lambda x: 0.5 / math.sqrt(x)))

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
