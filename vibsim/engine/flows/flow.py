"""The flow of a run: closed form in the modes that have one, Taylor series in the others.

Short hops on a rigid stop are taken by Taylor series, which count depths from where the hop begins: the last
ones of an infinite sequence of impacts are lower than the rounding of displacements, in which the closed form
looks for the next impact. So are stretches at whose start more derivatives of an event function are zero than
the closed form takes, as at the end of a chain whose other end is shaken.
"""

from __future__ import annotations

from math import inf
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.events.records import Certificate
from vibsim.engine.flows.closed.closed_form import ClosedForm
from vibsim.engine.flows.closed.reaches import leaves_flat
from vibsim.engine.flows.motion import Advance
from vibsim.engine.flows.taylor import Taylor
from vibsim.engine.ledger_integrals import LedgerIntegrals, QuadratureNode
from vibsim.engine.modes.rows import STRIKE, Event, Known, ModeRows
from vibsim.physics.elementary import Quadrature
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Scene


class Flow(Generic[N]):
    """Enters each mode by the flow that suits it; `scene.method` may demand one of them.

    order : of the Taylor series; that of the scene, unless derivatives at a state are all that is asked for
    """

    def __init__(
        self,
        scene: Scene[N],
        kit: Kit[N],
        certificate: Certificate[N] | None = None,
        order: int | None = None,
    ) -> None:
        self.kit = kit
        self.certificate: Certificate[N] = certificate or Certificate(kit)
        self.taylor = Taylor(scene, kit, self.certificate, order)
        self.closed = ClosedForm(scene, kit, self.certificate)
        self.method = scene.method
        self.now: Taylor[N] | ClosedForm[N] = self.taylor

    def suits(self, rows: ModeRows[N]) -> Taylor[N] | ClosedForm[N]:
        """The flow for the mode of `rows`."""
        if self.method == "taylor" or not self.closed.covers(rows):
            return self.taylor
        return self.closed

    def enter(self, state: State[N], rows: ModeRows[N], known: Known) -> None:
        self.now = self.suits(rows)
        if self.now is self.closed and leaves_flat(self.closed, state, rows, known):
            self.now = self.taylor
        self.now.enter(state, rows, known)
        if self.now is self.closed and self._hops(rows, known):
            self.now = self.taylor
            self.now.enter(state, rows, known)

    def order_of(self, event: Event[N]) -> int:
        """Order of the zero of an event function that the stretch began with; 0 for none."""
        return self.now.known.get(event.key, 0)

    def meeting(self, event: Event[N], end: N) -> N:
        """How long after its start the flow reaches the zero of the STRIKE `event` that it found at the time
        `end` [s], which lies on the grid of time: the zero itself does not.
        """
        tau = end - self.now.t0
        value, slope = self.now.value_and_slope(event, tau)
        if not slope < 0:
            return tau
        step = self.kit.exact(value / slope)
        return tau - step if abs(step) <= self.kit.next_after(end, inf) - end else tau

    def _hops(self, rows: ModeRows[N], known: Known) -> bool:
        """Whether a rigid stop that was struck here will be again within the window of the closed form."""
        for event in rows.events:
            if event.kind == STRIKE and known.get(event.key, 0) == 1:
                _, speed, drive = self.closed.derivatives(event, 2)
                if drive < 0 and 2 * speed < -drive * self.closed.modal.window:
                    return True
        return False

    @property
    def t0(self) -> N:
        """Start of what the flow of now was entered for [s]."""
        return self.now.t0

    @property
    def start(self) -> State[N]:
        """State there."""
        return self.now.start

    @property
    def rows(self) -> ModeRows[N]:
        """Rows of the mode."""
        return self.now.rows

    @property
    def evaluations(self) -> int:
        """Evaluations of the motion by the flow of now."""
        return self.now.evaluations

    @property
    def steps(self) -> int:
        """Steps of the flow of now."""
        return self.now.steps

    def carry_on(self, state: State[N]) -> None:
        self.now.carry_on(state)

    def advance(self, limit: N) -> Advance[N]:
        return self.now.advance(limit)

    def value_and_slope(self, event: Event[N], tau: N) -> tuple[N, N]:
        return self.now.value_and_slope(event, tau)

    def derivatives(self, event: Event[N], count: int) -> list[N]:
        return self.now.derivatives(event, count)

    def state_at(self, t: N) -> State[N]:
        return self.now.state_at(t)

    def state_after(self, tau: N) -> State[N]:
        return self.now.state_after(tau)

    def longest_piece(self, tau: N) -> N:
        return self.now.longest_piece(tau)

    @property
    def quadrature(self) -> Quadrature:
        return self.now.quadrature

    def open_nodes(self, integrals: LedgerIntegrals[N]) -> None:
        self.now.open_nodes(integrals)

    def node(self, tau: N, integrals: LedgerIntegrals[N]) -> QuadratureNode[N]:
        return self.now.node(tau, integrals)

    def spin_rate(self, tau: N) -> N:
        """Rate of the speed of the rotor [rad/s^2], which moves by Taylor series alone."""
        return self.taylor.spin_rate(tau)
