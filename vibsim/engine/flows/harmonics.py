"""Harmonic functions of time: forces and the motion of the base, with their derivatives."""

from collections.abc import Iterable

from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Harmonic


def sine_and_cosine(kit: Kit[N], term: Harmonic[N], t: N) -> tuple[N, N]:
    """sin and cos of omega t + phase, without forming a large product."""
    angle = kit.turn_angle(term.cycles, term.cycles_lo, t) + term.phase
    return kit.sine_cosine(angle)


def quarter_turns(sine: N, cosine: N) -> tuple[N, N, N, N]:
    """The derivatives of order 0 to 3 of sin at the point, each over omega to that order."""
    return sine, cosine, -sine, -cosine


def value_and_rate(kit: Kit[N], terms: Iterable[Harmonic[N]], t: N) -> tuple[N, N]:
    """Sum of harmonics at t and its rate of change."""
    value = rate = kit.number(0)
    for term in terms:
        sine, cosine = sine_and_cosine(kit, term, t)
        value = value + term.amplitude * sine
        rate = rate + term.amplitude * term.omega * cosine
    return value, rate
