"""The number kit of any precision, on python-flint's arb: the Python engine runs on it unchanged.

Arb numbers carry a radius. The state is stripped of it where a segment starts (`State.settled`), because
radii follow worst cases while the right digits of a chaotic run are told by its own error growth: compare
two precisions. Inside a segment decisions are those of doubles: event functions are compared without radii,
so that one that rests at zero is zero. The unit round-off `eps` stands GUARD_BITS above the working
precision: radii are far below what a decision allows for rounding.
"""

import math
from fractions import Fraction

import flint

from vibsim.physics.numbers import beyond
from vibsim.physics.precision import GUARD_BITS, WorkingPrecision


class Balls(WorkingPrecision[flint.arb]):
    """Arithmetic of `digits` decimal digits. There is one working precision in a process at a time: the last
    kit made sets it.
    """

    name = "arb"
    library = f"python-flint {flint.__version__}"

    def __init__(self, digits: int) -> None:
        super().__init__(digits)
        self.activate()
        self.eps = flint.arb(2) ** -self.bits
        self.inf = flint.arb("inf")
        self.pi = flint.arb.pi()
        self.two_pi = 2 * self.pi

    def activate(self) -> None:
        """Make this kit's precision that of the process."""
        flint.ctx.prec = self.bits + GUARD_BITS

    @staticmethod
    def exact(t: flint.arb) -> flint.arb:
        """The time `t` without its radius."""
        return t.mid()

    @staticmethod
    def all_exact(values: list[flint.arb]) -> list[flint.arb]:
        """The list `values` without radii."""
        return [value.mid() for value in values]

    @staticmethod
    def number(value: flint.arb | float | Fraction) -> flint.arb:
        """`value` as arb."""
        if isinstance(value, Fraction):
            return flint.arb(flint.fmpq(value.numerator, value.denominator))
        return flint.arb(value)

    sin = staticmethod(lambda x: x.sin())
    cos = staticmethod(lambda x: x.cos())
    sine_cosine = staticmethod(lambda x: x.sin_cos())
    exp = staticmethod(lambda x: x.exp())
    expm1 = staticmethod(lambda x: x.expm1())
    log = staticmethod(lambda x: x.log())
    sinh = staticmethod(lambda x: x.sinh())
    cosh = staticmethod(lambda x: x.cosh())
    tanh = staticmethod(lambda x: x.tanh())
    asin = staticmethod(lambda x: x.asin())
    acos = staticmethod(lambda x: x.acos())
    atan = staticmethod(lambda x: x.atan())
    finite = staticmethod(lambda x: x.is_finite())

    def rounded_sine_cosine(self, angle: flint.arb) -> tuple[flint.arb, flint.arb]:
        """Sine and cosine of an angle [rad] that is rounded: 0 where rounding hides them."""
        return beyond(self.eps * abs(angle), angle.sin_cos(), self.number(0))

    @staticmethod
    def sqrt(x: flint.arb) -> flint.arb:
        """Square root; of the non-negative part where x is zero but for its radius."""
        return x.nonnegative_part().sqrt() if not x > 0 else x.sqrt()

    def power(self, a: flint.arb, p: flint.arb) -> flint.arb:
        """a**p for a >= 0, nan of a below 0. Of a that is zero but for its radius: from 0 to the power of the
        greatest that it may be; infinite for p < 0.
        """
        if a > 0 and a.is_finite():
            return a**p
        if p == 0 or a < 0 or not (a >= 0 or a.is_finite()):
            return self.number(1) if p == 0 else self.number(math.nan)
        if p < 0 or not a.is_finite():
            return self.number(0) if p < 0 and a > 0 else self.inf
        return (a.nonnegative_part().upper() ** p).union(self.number(0)) if a != 0 else a

    def next_after(self, t: flint.arb, _towards: float) -> flint.arb:
        """The next larger time: one unit in the last place on."""
        return (t + (abs(t) + self.eps) * self.eps).mid()

    @staticmethod
    def parts(x: flint.arb) -> tuple[int, int]:
        """Whole numbers m, e of the middle m 2**e of x."""
        mantissa, exponent = x.mid().man_exp()
        return int(mantissa), int(exponent)

    @staticmethod
    def of_parts(mantissa: int, exponent: int) -> flint.arb:
        """mantissa 2**exponent, exactly."""
        return flint.arb((mantissa, exponent))

    @staticmethod
    def power_of_two(y: float) -> flint.arb:
        """2**y for a float y."""
        return flint.arb(2) ** flint.arb(y)

    def turn_angle(self, cycles: flint.arb, cycles_lo: flint.arb, t: flint.arb) -> flint.arb:
        """2 pi (cycles + cycles_lo) t reduced to [-pi, pi] [rad]."""
        turns = (self.number(cycles) + cycles_lo) * t
        return self.two_pi * (turns - nearest(turns))

    def reduce_angle(self, angle: flint.arb) -> tuple[flint.arb, flint.arb]:
        """`angle` [rad] moved into [-pi, pi], and the whole turns taken out."""
        turns = nearest(angle / self.two_pi)
        return angle - turns * self.two_pi, turns

    def unwind(self, angle: flint.arb, turns: flint.arb) -> flint.arb:
        """angle + 2 pi turns [rad]."""
        return angle + turns * self.two_pi


def nearest(turns: flint.arb) -> flint.arb:
    """The whole number nearest to the middle of `turns`. Rounding is taken off before the floor: that of a
    ball which holds a whole number is two numbers.
    """
    return (turns.mid() + 0.5).mid().floor()
