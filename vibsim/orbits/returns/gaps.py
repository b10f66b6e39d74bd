"""Gaps of stops and differences of ends on a motion that is known, and when two of them are zero at once."""

from typing import Any

import numpy as np

from vibsim.physics.arithmetic.sines import sine_cosine
from vibsim.physics.parts import BASE, Scene

ROUNDING = 2e-12  # of the size of a motion: what rounding and Newton's method leave of a gap that is zero
OF_STOPS = ("contact_begin", "contact_end", "impact", "transmitted")
OF_FRICTIONS = ("reversal", "stick_begin", "stick_end")


def at_once(scene: Scene, kind: str, part: int, t: float, state: np.ndarray) -> bool:
    """Whether an event of a kind at a part is due at the time t [s] of another but for rounding: its gap, or
    its sliding velocity, is zero to a share of the displacements, or velocities, there.
    """
    n = len(scene.bodies)
    if kind in OF_STOPS:
        gap = gap_of(scene, part, t, state)[0]
        return bool(abs(gap) <= ROUNDING * max(abs(state[:n]).max(), abs(scene.stops[part].gap)))
    if kind in OF_FRICTIONS:
        friction = scene.frictions[part]
        slip = apart(friction, state[n:], motion_of_base(scene, t)[1]) - friction.belt
        return bool(abs(slip) <= ROUNDING * max(abs(state[n : 2 * n]).max(), abs(friction.belt)))
    return False


def gap_of(
    scene: Any, number: int, t: Any, state: np.ndarray, rates: np.ndarray | None = None
) -> tuple[Any, Any, Any]:
    """Gap of a stop [m], its rate and acceleration at states (N, ...), with their rates of change."""
    stop, n = scene.stops[number], len(scene.bodies)
    base = motion_of_base(scene, t)
    values = state, state[n:], None if rates is None else rates[n:]
    gap, rate, bend = (
        0.0 if of is None else stop.sense * apart(stop, of, base[order]) for order, of in enumerate(values)
    )
    return stop.gap + gap, rate, bend


def apart(part: Any, values: Any, of_base: Any) -> Any:
    """P - Q of the ends of a part: `values` by body, that of the base, and 0 of the ground."""
    P, Q = (values[end] if end >= 0 else of_base if end == BASE else 0.0 for end in (part.P, part.Q))
    return P - Q


def motion_of_base(scene: Any, t: Any) -> tuple[Any, Any, Any]:
    """Displacement, velocity and acceleration of the base at the times t."""
    x = v = a = 0.0
    for term in scene.base:
        sine, cosine = sine_cosine(term.omega * t + term.phase)
        x = x + term.amplitude * sine
        v = v + term.amplitude * term.omega * cosine
        a = a - term.amplitude * term.omega**2 * sine
    return x, v, a
