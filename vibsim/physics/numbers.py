"""Number kits: the elementary functions that the engine needs, for one type of number.

What is computed in Python (modes, starts, events that C leaves open) takes its arithmetic from a kit.
`Doubles` is the kit of IEEE doubles; C repeats its operations one by one, so every expression here has a
fixed order. A kit for another type offers the same names (`Kit`).

What is written for all number types is generic in `N`: `Scene[N]`, `State[N]`, `Kit[N]`. Without its argument
a type means doubles: `Scene` is `Scene[float]`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol, overload

from vibsim.physics import elementary
from vibsim.physics.elementary import TWO_PI as TWO_PI
from vibsim.physics.elementary import VELTKAMP

if TYPE_CHECKING:
    from typing_extensions import Self, TypeVar

    from vibsim.physics.parts import Scene

    N = TypeVar("N", bound="Number", default=float)

    @overload
    def abs(x: int, /) -> int: ...
    @overload
    def abs(x: N, /) -> N: ...
    def abs(x: Any, /) -> Any: ...  # of any N; the built-in's declaration forgets which

else:
    from builtins import abs
    from typing import TypeVar

    N = TypeVar("N")

TWO_PI_LO = 2.4492935982947064e-16  # 2 pi = TWO_PI + TWO_PI_LO to 107 bits


class Number(Protocol):
    """A real number: a float, or one of words (`precision`). Each computes with its own type and with whole
    numbers and doubles.
    """

    def __add__(self, other: Self | float, /) -> Self: ...
    def __radd__(self, other: float, /) -> Self: ...
    def __sub__(self, other: Self | float, /) -> Self: ...
    def __rsub__(self, other: float, /) -> Self: ...
    def __mul__(self, other: Self | float, /) -> Self: ...
    def __rmul__(self, other: float, /) -> Self: ...
    def __truediv__(self, other: Self | float, /) -> Self: ...
    def __rtruediv__(self, other: float, /) -> Self: ...
    def __neg__(self) -> Self: ...
    def __abs__(self) -> Self: ...
    def __lt__(self, other: Self | float, /) -> bool: ...
    def __le__(self, other: Self | float, /) -> bool: ...
    def __gt__(self, other: Self | float, /) -> bool: ...
    def __ge__(self, other: Self | float, /) -> bool: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __float__(self) -> float: ...


class Kit(Protocol[N]):
    """Interface of a number type as the engine needs it; `Doubles` documents each name."""

    @property
    def eps(self) -> N: ...
    @property
    def inf(self) -> N: ...
    def sin(self, x: N, /) -> N: ...
    def cos(self, x: N, /) -> N: ...
    def sine_cosine(self, x: N, /) -> tuple[N, N]: ...
    def rounded_sine_cosine(self, angle: N, /) -> tuple[N, N]: ...
    def function(self, name: str, /) -> Callable[[N], N]: ...
    def power(self, a: N, p: N, /) -> N: ...
    def sqrt(self, x: N, /) -> N: ...
    def next_after(self, t: N, towards: float, /) -> N: ...
    def order(self, scene: Scene[N], /) -> int: ...
    def tolerance_exponent(self, scene: Scene[N], /) -> float: ...
    def number(self, value: N | float | Fraction, /) -> N: ...
    def power_of_two(self, y: float, /) -> N: ...
    def turn_angle(self, cycles: N, cycles_lo: N, t: N, /) -> N: ...
    def reduce_angle(self, angle: N, /) -> tuple[N, N]: ...
    def unwind(self, angle: N, turns: N, /) -> N: ...
    def rounded(self, values: Iterable[N], /) -> list[float]: ...


def beyond(lost: N, values: tuple[N, N], zero: N) -> tuple[N, N]:
    """Two values, `zero` in place of those that are no larger than `lost`."""
    one, other = values
    return one if abs(one) > lost else zero, other if abs(other) > lost else zero


class Doubles:
    """IEEE double precision, whose elementary functions have the same bits everywhere."""

    eps = 2.0**-53  # unit round-off
    inf = math.inf
    sin = staticmethod(elementary.sin)
    cos = staticmethod(elementary.cos)
    sine_cosine = staticmethod(elementary.sine_cosine)
    function = staticmethod(elementary.function)  # of one argument, by its name in formulas
    power = staticmethod(elementary.power)  # a**p of a >= 0, nan of a below 0
    sqrt = staticmethod(math.sqrt)
    next_after = staticmethod(math.nextafter)

    @staticmethod
    def rounded_sine_cosine(angle: float) -> tuple[float, float]:
        """Sine and cosine of an angle [rad] that is rounded: 0 where rounding hides them, as at quarter
        turns, which are none of the numbers.
        """
        return beyond(Doubles.eps * abs(angle), elementary.sine_cosine(angle), 0.0)

    @staticmethod
    def order(scene: Scene) -> int:
        """Order of the Taylor flow [-]."""
        return scene.order

    @staticmethod
    def tolerance_exponent(scene: Scene) -> float:
        """Binary exponent of the tolerance of the Taylor flow [-]."""
        return _exponent_of(scene.tol)

    @staticmethod
    def number(value: float | Fraction) -> float:
        """`value` in this kit's type."""
        return float(value)

    @staticmethod
    def power_of_two(y: float) -> float:
        """2**y for a real y [-]."""
        return elementary.exp(y * 0.6931471805599453)

    @staticmethod
    def turn_angle(cycles: float, cycles_lo: float, t: float) -> float:
        """2 pi (cycles + cycles_lo) t reduced to [-pi, pi] [rad], without forming the large product.

        cycles * t is split exactly into product and error (Dekker 1971), whole turns are dropped from the
        product, and only then is it scaled: the phase of a forcing in Hz keeps full accuracy at any t.
        """
        product = cycles * t
        wide = VELTKAMP * cycles
        f1 = wide - (wide - cycles)
        f2 = cycles - f1
        wide = VELTKAMP * t
        t1 = wide - (wide - t)
        t2 = t - t1
        error = ((f1 * t1 - product) + f1 * t2 + f2 * t1) + f2 * t2
        turns = (product - math.floor(product + 0.5)) + (error + cycles_lo * t)
        return TWO_PI * turns

    @staticmethod
    def reduce_angle(angle: float) -> tuple[float, float]:
        """`angle` [rad] moved into [-pi, pi] by whole turns, and the number of turns taken out (a float)."""
        turns = math.floor(angle / TWO_PI + 0.5)
        return (angle - turns * TWO_PI) - turns * TWO_PI_LO, turns

    @staticmethod
    def rounded(values: Iterable[float]) -> list[float]:
        """The doubles nearest to `values`: they themselves."""
        return list(values)

    @staticmethod
    def unwind(angle: float, turns: float) -> float:
        """angle + 2 pi turns [rad]."""
        return angle + turns * TWO_PI


_exponent_of = lru_cache(maxsize=16)(elementary.log2)  # of the one or two tolerances that there are


def total_of(kit: Kit[N], values: Iterable[N]) -> N:
    """Sum in order; 0 of nothing."""
    rest = iter(values)
    for total in rest:
        for value in rest:
            total = total + value
        return total
    return kit.number(0)


# Binary numbers of any length as decimal text, rounded once.


SPARE = 12  # digits beyond those shown: the text is then the nearest one but for ties that no run meets
EXPONENT_ROOM = 8  # sign, point, "e" and an exponent of five characters


def decimal_text(parts: tuple[int, int], digits: int) -> str:
    """m 2**e to so many significant decimal digits, "-4.98...e-3"; parts: the whole numbers m, e."""
    mantissa, exponent = parts
    if not mantissa:
        return f"{0:.{digits - 1}e}"
    context = _context(digits + SPARE)
    value = context.multiply(context.create_decimal(mantissa), _power_of_two(exponent, digits + SPARE))
    return f"{value:.{digits - 1}e}"


def text_width(digits: int) -> int:
    """Characters that the text of any number takes at most."""
    return digits + EXPONENT_ROOM


@lru_cache(maxsize=8)
def _context(digits: int) -> Context:
    return Context(prec=digits, rounding=ROUND_HALF_EVEN, Emin=-999999999, Emax=999999999)


@lru_cache(maxsize=4096)
def _power_of_two(exponent: int, digits: int) -> Decimal:
    context = _context(digits)
    return context.power(context.create_decimal(2), exponent)
