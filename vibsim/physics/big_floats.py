"""The number kit of any precision on mpmath, for where python-flint is missing: some thirty times slower.

mpmath's numbers are plain floats without a radius: decisions close to round-off go by the margin `eps` alone,
which stands GUARD_BITS above the working precision.
"""

from fractions import Fraction
from typing import Any

import mpmath

from vibsim.physics.numbers import beyond
from vibsim.physics.precision import GUARD_BITS, WorkingPrecision

Number = Any  # mpf: mpmath tells no types


class BigFloats(WorkingPrecision[Number]):
    """Arithmetic of `digits` decimal digits, in a context of its own."""

    name = "mpf"
    library = f"mpmath {mpmath.__version__}"

    def __init__(self, digits: int) -> None:
        super().__init__(digits)
        self.context = context = mpmath.mp.clone()
        context.prec = self.bits + GUARD_BITS
        self.eps = context.ldexp(1, -self.bits)
        self.inf = context.inf
        self.pi = +context.pi
        self.two_pi = 2 * self.pi
        self.sin, self.cos, self.exp, self.expm1 = context.sin, context.cos, context.exp, context.expm1
        self.sinh, self.cosh, self.log = context.sinh, context.cosh, context.log
        self.tanh, self.atan = context.tanh, context.atan
        self.finite = context.isfinite

    def sine_cosine(self, x: Number) -> tuple[Number, Number]:
        """Sine and cosine of an angle [rad]."""
        cosine, sine = self.context.cos_sin(x)
        return sine, cosine

    def rounded_sine_cosine(self, angle: Number) -> tuple[Number, Number]:
        """Sine and cosine of an angle [rad] that is rounded: 0 where rounding hides them."""
        return beyond(self.eps * abs(angle), self.sine_cosine(angle), self.number(0))

    def activate(self) -> None:
        """Nothing to do: the precision belongs to the numbers' context."""

    def number(self, value: Number | float | Fraction) -> Number:
        """`value` as mpf."""
        if isinstance(value, Fraction):
            return self.context.mpf(value.numerator) / value.denominator
        return self.context.mpf(value)

    @staticmethod
    def exact(t: Number) -> Number:
        """The time `t` on the grid of the number type."""
        return t

    @staticmethod
    def all_exact(values: list[Number]) -> list[Number]:
        """The list `values`: they carry nothing besides their digits."""
        return values

    def asin(self, x: Number) -> Number:
        """Angle [rad] from -pi/2 to pi/2 of a sine; nan beyond 1."""
        return self.context.asin(x) if abs(x) <= 1 else self.context.nan

    def acos(self, x: Number) -> Number:
        """Angle [rad] from 0 to pi of a cosine; nan beyond 1."""
        return self.context.acos(x) if abs(x) <= 1 else self.context.nan

    def power(self, a: Number, p: Number) -> Number:
        """a**p for a >= 0, nan of a below 0."""
        if p == 0 or not a >= 0:
            return self.number(1) if p == 0 else self.context.nan
        if a == 0:
            return self.inf if p < 0 else a
        return self.context.power(a, p)

    def sqrt(self, x: Number) -> Number:
        """Square root; 0 where rounding has left x below it."""
        return self.context.sqrt(x) if x > 0 else self.context.zero

    def next_after(self, t: Number, _towards: float) -> Number:
        """The next larger time: one unit in the last place on."""
        return t + (abs(t) + self.eps) * self.eps

    @staticmethod
    def parts(x: Any) -> tuple[int, int]:
        """Whole numbers m, e with x = m 2**e."""
        sign, mantissa, exponent, _ = x._mpf_
        return (-int(mantissa) if sign else int(mantissa)), int(exponent)

    def of_parts(self, mantissa: int, exponent: int) -> Number:
        """mantissa 2**exponent, exactly."""
        return self.context.make_mpf(mpmath.libmp.from_man_exp(mantissa, exponent))

    def power_of_two(self, y: float) -> Number:
        """2**y for a float y."""
        return self.context.mpf(2) ** y

    def turn_angle(self, cycles: Number, cycles_lo: Number, t: Number) -> Number:
        """2 pi (cycles + cycles_lo) t reduced to [-pi, pi] [rad]."""
        turns = (self.number(cycles) + cycles_lo) * t
        return self.two_pi * (turns - self.context.floor(turns + 0.5))

    def reduce_angle(self, angle: Number) -> tuple[Number, Number]:
        """`angle` [rad] moved into [-pi, pi], and the whole turns taken out."""
        turns = self.context.floor(angle / self.two_pi + 0.5)
        return angle - turns * self.two_pi, turns

    def unwind(self, angle: Number, turns: Number) -> Number:
        """angle + 2 pi turns [rad]."""
        return angle + turns * self.two_pi
