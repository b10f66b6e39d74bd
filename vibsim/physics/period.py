"""The period of what drives a scene from outside: of all its harmonics together, where there is one."""

from fractions import Fraction
from math import lcm
from typing import Any, NamedTuple, overload

import numpy as np

from vibsim.physics.parts import Scene

MOST = 1000  # largest denominator of a ratio of frequencies that counts as exact
EXACT = Fraction(1, 2**100)  # relative: a frequency is a double-double of 107 bits


class Period(NamedTuple):
    """`turns` turns of a harmonic of cycles + cycles_lo [Hz], a double-double."""

    cycles: float
    cycles_lo: float
    turns: int

    @overload
    def end(self, k: float) -> float: ...
    @overload
    def end(self, k: np.ndarray) -> np.ndarray: ...
    def end(self, k: Any) -> Any:
        """End of period k [s], or of several."""
        t = k * self.turns / self.cycles
        return t - t * (self.cycles_lo / self.cycles)


def common_period(scene: Scene[Any]) -> Period | None:
    """The shortest period of all forces and the base, or None where nothing moves them or their frequencies
    have no common one: ratios count as exact within the rounding of double-doubles. Amplitudes of 0 count
    where there are no others: what a sweep begins with at 0 N has a clock already.
    Frequencies are doubles or fractions.
    """
    terms = [term for term in scene.harmonics if term.cycles != 0]
    if len(terms) == 1:
        return Period(terms[0].cycles, terms[0].cycles_lo, 1)
    strong = [term for term in terms if term.amplitude != 0]
    pitches = list(dict.fromkeys((term.cycles, term.cycles_lo) for term in strong or terms))
    if not pitches:
        return None
    if len(pitches) == 1:
        return Period(*pitches[0], 1)
    exact = [Fraction(cycles) + Fraction(cycles_lo) for cycles, cycles_lo in pitches]
    turns = 1
    for frequency in exact[1:]:
        ratio = frequency / exact[0]
        near = ratio.limit_denominator(MOST)
        if abs(near - ratio) > EXACT * ratio:
            return None
        turns = lcm(turns, near.denominator)
    return Period(*pitches[0], turns)
