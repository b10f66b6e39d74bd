"""The number kit of any precision, on python-flint's arb: the Python engine runs on it unchanged.

Arb numbers carry a radius. The state is stripped of it at the start of every segment (`settle`), because
radii follow worst cases while the right digits of a chaotic run are told by its own error growth: compare
two precisions. Inside a segment every decision is one between balls; the unit round-off `eps` stands
GUARD_BITS above the working precision so that rounding never blurs it.
"""

from fractions import Fraction
from math import log2

import flint

GUARD_BITS = 32
BITS_PER_DIGIT = 3.3219280948873626
MOST_DIGITS = 1000


class Balls:
    """Arithmetic of `digits` decimal digits. There is one working precision in a process at a time: the last
    kit made sets it.
    """

    name = "arb"
    no_exponent = -(10**6)

    def __init__(self, digits):
        self.digits = digits
        self.bits = int(digits * BITS_PER_DIGIT) + 1
        flint.ctx.prec = self.bits + GUARD_BITS
        self.eps = flint.arb(2) ** -self.bits
        self.two_pi = 2 * flint.arb.pi()
        self.series_terms = self._terms()

    def _terms(self):
        """Terms after which 2^n / n! is below round-off."""
        n, exponent = 1, 1.0
        while exponent > -self.bits - 4:
            n += 1
            exponent += 1 - log2(n)
        return n

    def order(self, _scene):
        """Order of the Taylor flow: half the logarithm of the precision, where the work per time is least."""
        return max(20, int(0.36 * self.bits))

    def tolerance_exponent(self, _scene):
        """The Taylor flow goes to the working precision."""
        return -float(self.bits)

    @staticmethod
    def exact(t):
        """The time `t` without its radius."""
        return t.mid()

    @staticmethod
    def number(value):
        """`value` (int, float, Fraction, arb) as arb."""
        if isinstance(value, Fraction):
            return flint.arb(flint.fmpq(value.numerator, value.denominator))
        return flint.arb(value)

    sin = staticmethod(lambda x: x.sin())
    cos = staticmethod(lambda x: x.cos())
    exp = staticmethod(lambda x: x.exp())
    expm1 = staticmethod(lambda x: x.expm1())
    sinh = staticmethod(lambda x: x.sinh())
    cosh = staticmethod(lambda x: x.cosh())
    finite = staticmethod(lambda x: x.is_finite())

    @staticmethod
    def sqrt(x):
        """Square root; of the non-negative part where x is zero but for its radius."""
        return x.nonnegative_part().sqrt() if not x > 0 else x.sqrt()

    def next_after(self, t, _towards):
        """The next larger time: one unit in the last place on."""
        return (t + (abs(t) + self.eps) * self.eps).mid()

    @staticmethod
    def exponent(x):
        """Binary exponent of x; `no_exponent` for x = 0."""
        mantissa, exponent = x.mid().man_exp()
        return int(exponent) + int(abs(mantissa)).bit_length() if mantissa != 0 else Balls.no_exponent

    @staticmethod
    def power_of_two(y):
        """2**y for a float y."""
        return flint.arb(2) ** flint.arb(y)

    def turn_angle(self, cycles, cycles_lo, t):
        """2 pi (cycles + cycles_lo) t reduced to [-pi, pi] [rad]."""
        turns = (self.number(cycles) + cycles_lo) * t
        return self.two_pi * (turns - (turns.mid() + 0.5).floor())

    def reduce_angle(self, angle):
        """`angle` [rad] moved into [-pi, pi], and the whole turns taken out."""
        turns = (angle / self.two_pi).mid() + 0.5
        turns = turns.floor()
        return angle - turns * self.two_pi, turns

    def unwind(self, angle, turns):
        """angle + 2 pi turns [rad]."""
        return angle + turns * self.two_pi

    @staticmethod
    def settle(state):
        """`state` without the radii of its numbers."""
        return type(state)(*(value.mid() for value in vars(state).values()))
