"""Laws by which a friction force falls with the speed of slip, one module each.

The force is constant + drop f(s), s = rate |v_rel|, with f(0) = 1 and f falling to 0. A module has

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

from vibsim.physics.arithmetic.numbers import Kit, N
from vibsim.physics.friction_laws import exponential, hyperbolic

HYPERBOLIC, EXPONENTIAL = "stribeck hyperbolic", "stribeck exponential"


class Law(Protocol):
    """What each of the modules has."""

    @property
    def NUMBER(self) -> int: ...
    def start(self, kit: Kit[N], s: N, /) -> N: ...
    def argument(self, n: int, s: N, /) -> N: ...
    def following(self, total: N, f: list[N], inverse: N, /) -> N: ...
    def slope(self, f: N, /) -> N: ...
    def slopes(self, f: list[N], /) -> list[N]: ...
    def reach(self, arguments: list[N], tolerance_exponent: float, longest: float, /) -> float: ...


LAWS: dict[str, Law] = {HYPERBOLIC: hyperbolic, EXPONENTIAL: exponential}
