"""Interface of every flow: the motion of one mode from where it was entered."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from vibsim.engine.errors import State
from vibsim.engine.events.records import Certificate
from vibsim.engine.ledger_integrals import LedgerIntegrals, QuadratureNode
from vibsim.engine.modes.rows import Event, Known, ModeRows
from vibsim.physics.elementary import Quadrature
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Harmonic

Advance = tuple[N, Event[N] | None]  # a time [s], and the event that is met there


class Motion(Protocol[N]):
    """A flow in one mode, entered at `start`, time `t0` [s]; `rows` are those of the mode."""

    t0: N
    start: State[N]
    rows: ModeRows[N]

    @property
    def method(self) -> str: ...
    @property
    def certificate(self) -> Certificate[N]: ...
    @property
    def quadrature(self) -> Quadrature: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def steps(self) -> int: ...
    def enter(self, state: State[N], rows: ModeRows[N], known: Known) -> None: ...
    def carry_on(self, state: State[N]) -> None: ...
    def advance(self, limit: N) -> Advance[N]: ...
    def value_and_slope(self, event: Event[N], tau: N) -> tuple[N, N]: ...
    def derivatives(self, event: Event[N], count: int) -> list[N]: ...
    def state_at(self, t: N) -> State[N]: ...
    def state_after(self, tau: N) -> State[N]: ...
    def longest_piece(self, tau: N, /) -> N: ...
    def open_nodes(self, integrals: LedgerIntegrals[N]) -> None: ...
    def node(self, tau: N, integrals: LedgerIntegrals[N]) -> QuadratureNode[N]: ...


# Harmonic functions of time: forces and the motion of the base, with their derivatives.


ROUNDING = 16  # of a product of an amplitude, powers of a rate and a sine, in units of eps


def sine_and_cosine(kit: Kit[N], term: Harmonic[N], t: N) -> tuple[N, N]:
    """sin and cos of omega t + phase, without forming a large product."""
    angle = kit.turn_angle(term.cycles, term.cycles_lo, t) + term.phase
    return kit.rounded_sine_cosine(angle)


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


def series_rounding(kit: Kit[N], terms: Iterable[Harmonic[N]], t: N, count: int) -> list[N]:
    """Rounding bounds of the first coefficients in tau of the sum of harmonics at t + tau.

    A sine is as wrong as its angle times its cosine; at a quarter turn, where motions start, it is 0 or 1.
    """
    bounds = [kit.number(0)] * count
    for term in terms:
        turns = [abs(turn) for turn in quarter_turns(*sine_and_cosine(kit, term, t))]
        angle = abs(kit.turn_angle(term.cycles, term.cycles_lo, t)) + abs(term.phase)
        size = ROUNDING * kit.eps * abs(term.amplitude)
        for n in range(count):
            turn, other = turns[n % 4], turns[(n + 1) % 4]
            if n > 0 or turn != 1 or other != 0:
                bounds[n] = bounds[n] + size * (turn + angle * other)
            size = size * term.omega / (n + 1)
    return bounds
