"""Laws by which a friction force falls with the speed of slip, one class each.

The force is constant + drop f(s), s = rate |v_rel|, with f(0) = 1 and f falling to 0. A law has

    NUMBER                            of the law, the same in friction_laws.h
    start(kit, s)                     f(s)
    argument(n, s)                    from coefficient n > 0 of s, what the products of the recurrence take
    following(total, f, inverse)      coefficient n > 0 of f from the sum over i = 1 ... n of argument i times
                                      f_(n-i); inverse = 1/n
    slopes(f)                         series of df/ds, for small disturbances
    slope(f)                          the same of one value
    reach(arguments, exponent, longest)
                                      binary exponent of the longest step, up to `longest`, for which
                                      what the series of f leaves out is below 2^exponent
"""

from typing import Protocol

from vibsim.physics.numbers import Doubles, Kit, N
from vibsim.physics.parts import EXPONENTIAL, HYPERBOLIC


class Law(Protocol):
    """Interface of the friction laws."""

    @property
    def NUMBER(self) -> int: ...
    def start(self, kit: Kit[N], s: N, /) -> N: ...
    def argument(self, n: int, s: N, /) -> N: ...
    def following(self, total: N, f: list[N], inverse: N, /) -> N: ...
    def slope(self, f: N, /) -> N: ...
    def slopes(self, f: list[N], /) -> list[N]: ...
    def reach(self, arguments: list[N], tolerance_exponent: float, longest: float, /) -> float: ...


CIRCLES = (4, 3, 2, 5, 1, 6, 8, 12, 16)  # binary exponents of radius over step, the likeliest first
LN2 = 0.6875  # ln 2, a little less
ALLOWANCE = 4.0  # binary: sqrt(2 pi p), by which Cauchy's estimate lies above the terms of exp(-z)
HALVINGS = 256  # of the square of the step; more are needed by no order and tolerance that a case may ask for


def _converges(sizes: list[float], room: list[float], h: float) -> bool:
    """Whether g(2^k h) is within `room` on one of the circles."""
    for i, k in enumerate(CIRCLES):
        radius, growth = 2.0**k * h, 0.0
        for size in reversed(sizes):
            growth = growth * radius + size
        if growth <= room[i]:
            return True
    return False


class Hyperbolic:
    """f = 1 / (1 + s): then (1 + s) f = 1, and f_n = -f_0 sum s_i f_(n-i)."""

    NUMBER = 0

    @staticmethod
    def start(_kit: Kit[N], s: N) -> N:
        return 1 / (1 + s)

    @staticmethod
    def argument(_n: int, s: N) -> N:
        return s

    @staticmethod
    def following(total: N, f: list[N], _inverse: N) -> N:
        return -(f[0] * total)

    @staticmethod
    def slope(f: N) -> N:
        return -(f * f)

    @staticmethod
    def slopes(f: list[N]) -> list[N]:
        """Series of -f^2."""
        series = []
        for n in range(len(f)):
            total = f[0] * f[n]
            for i in range(1, n + 1):
                total = total + f[i] * f[n - i]
            series.append(-total)
        return series

    @staticmethod
    def reach(_arguments: list[N], _tolerance_exponent: float, longest: float) -> float:
        """`longest`: the terms of f shrink from each to the next as those do that a step is measured by."""
        return longest


class Exponential:
    """f = exp(-s): then f' = -s' f, and n f_n = -sum i s_i f_(n-i)."""

    NUMBER = 1

    @staticmethod
    def start(kit: Kit[N], s: N) -> N:
        return kit.exp(-s)

    @staticmethod
    def argument(n: int, s: N) -> N:
        return n * s

    @staticmethod
    def following(total: N, _f: list[N], inverse: N) -> N:
        return -(total * inverse)

    @staticmethod
    def slope(f: N) -> N:
        return -f

    @staticmethod
    def slopes(f: list[N]) -> list[N]:
        """Series of -f."""
        return [-value for value in f]

    @staticmethod
    def reach(arguments: list[N], tolerance_exponent: float, longest: float) -> float:
        """Binary exponent of the longest step, up to `longest`, for which the terms that the series of f
        leaves out stay below the tolerance beside f(0) = 1.

        Far from s = 0 the terms of f are as small as exp(-s_0), and those left out may yet grow up to 1: the
        last ones kept do not tell. With g(r) = sum |s_n| r^n, |f(z)| <= exp(g(|z|) - s_0), so by Cauchy's
        estimate what p terms leave out at h is about exp(g(R) - s_0) (h / R)^p at most, on any circle of
        radius R = 2^k h.
        """
        s = [float(value) for value in arguments]
        sizes = [0.0] + [abs(s[n]) / n for n in range(1, len(s))]
        room = [s[0] + LN2 * (len(s) * k + (tolerance_exponent + ALLOWANCE)) for k in CIRCLES]
        most = Doubles.exponent(room[-1])
        for n in range(1, len(s)):  # what the widest circle asks of each term alone
            if sizes[n] != 0.0:
                longest = min(longest, (most + 1 - Doubles.exponent(sizes[n])) / n - 1.0)
        for _ in range(HALVINGS):
            if longest >= 1000.0 or _converges(sizes, room, Doubles.power_of_two(longest)):
                break
            longest = longest - 0.5
        return longest


LAWS: dict[str, Law] = {HYPERBOLIC: Hyperbolic(), EXPONENTIAL: Exponential()}
