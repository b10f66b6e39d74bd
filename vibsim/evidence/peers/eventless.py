"""Equations of motion with the switches left inside: what is written down when nobody looks for events.

The stop acts wherever g >= 0, and friction follows a function of v2: sgn as printed in Eq. (2.7), or
tanh(v2 / width), which smooths it (then block 2 creeps instead of sticking).
"""

from collections.abc import Callable, Sequence
from math import copysign, tanh

from vibsim.evidence.peers.equations import Equations


def sgn(v2: float) -> float:
    """sgn(v2), 0 at 0."""
    return copysign(1.0, v2) if v2 else 0.0


def smoothed(width: float) -> Callable[[float], float]:
    """tanh(v2 / width); width [m/s]."""
    return lambda v2: tanh(v2 / width)


class EventlessMotion:
    """d state/dt at (t, state), whatever the mode there."""

    def __init__(self, equations: Equations, law: Callable[[float], float]):
        self.equations, self.law = equations, law
        self.has_stop = equations.scene.has_stop

    def __call__(self, t: float, state: Sequence[float]) -> tuple[float, ...]:
        equations = self.equations
        S = equations.force(state, self.has_stop and equations.gap(state) >= 0)
        a2 = 0.0 if equations.fixed else (S - equations.N * self.law(state[3])) / equations.scene.m2
        return equations.rates(t, state, S, a2)
