"""Small disturbances that are carried through modes and events: the derivative of the motion.

Between events they obey the equations of the mode, linearised; an event multiplies them by its saltation
matrix; ties that begin give tied bodies one velocity, momentum kept, and rigid stops that come to rest one
displacement of their ends.
"""

from collections.abc import Iterator, Sequence
from typing import Any, Generic

from vibsim.engine.errors import State
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts
from vibsim.engine.flows.accelerations import joined
from vibsim.engine.flows.expansion import highest_derivative
from vibsim.engine.flows.flow import Flow
from vibsim.engine.flows.taylor_rounding import PythonExpansion
from vibsim.engine.modes.rows import Event, ModeRows
from vibsim.engine.tangent.impact_saltation import ImpactSaltation, Undefined
from vibsim.engine.tangent.saltation import Jump, resting, saltation
from vibsim.engine.tangent.tangencies import Tangencies
from vibsim.engine.tangent.tangent_closed_form import ClosedFormTangent
from vibsim.engine.tangent.tangent_space import seated
from vibsim.engine.tangent.tangent_taylor import TaylorTangent
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Scene


class Disturbances(Generic[N]):
    """Carries `vectors`, rows (dx of each body, dv of each body, dphi, dw), over the stretches of a run, as
    they are.

    possible : how many of them move
    pieces : stretches that they moved over at once
    """

    def __init__(
        self, scene: Scene[N], kit: Kit[N], flow: Flow[N], vectors: Sequence[Sequence[N]] = ()
    ) -> None:
        self.scene, self.kit, self.flow = scene, kit, flow
        self.vectors, self.possible = [list(vector) for vector in vectors], len(vectors)
        self.tangents: dict[str, TaylorTangent[N] | ClosedFormTangent[N]] = {
            "taylor": TaylorTangent(scene, kit, flow.taylor),
            "closed_form": ClosedFormTangent(scene, kit, flow.closed),
        }
        order = highest_derivative(scene) + 1
        self.expansion: Any = PythonExpansion(scene, kit, flow.certificate, order)
        self.tangencies = Tangencies(scene, kit, self.expansion)
        self.pieces = 0

    def open(self, state: State[N], rows: ModeRows[N]) -> None:
        """At the start: what the ties of the mode allow of the disturbances."""
        self.tangencies.pass_by(state, rows)
        self._join(state, rows)

    def gather(self, start: State[N], end: N, tau: N, state: State[N], at_event: bool) -> Iterator[N]:
        """Carry the disturbances over the stretch from the state `start` to `state` at the time `end`, `tau`
        [s] after the start of the flow, where an event is or none; the instant of an impact is not on the
        grid of time.

        A generator, which yields how far it is [s] after every piece.
        """
        t, tangent, exact = start.t, self.tangents[self.flow.now.method], self.kit.all_exact
        tangent.event_at = end if at_event else None
        late: N | int = tau - (end - self.flow.t0)
        while t < end or late != 0:
            ahead = tangent.piece_end(t, end, self._mark(end)) if t < end else end
            tangent.prepare(t, ahead, late if ahead >= end else 0)
            moved = [exact(tangent.moved(self.vectors[i])) for i in range(self.possible)]
            while tangent.is_too_long and t < (half := self.kit.exact(t + (ahead - t) / 2)) < ahead:
                ahead = half
                tangent.prepare(t, ahead)
                moved = [exact(tangent.moved(self.vectors[i])) for i in range(self.possible)]
            if tangent.is_undefined:
                self.tangencies.refuse(t)
            late = 0 if ahead >= end else late
            self.vectors[: self.possible] = moved
            self.pieces += 1
            self._moved(t, ahead)
            t = ahead
            yield t
        self.tangencies.pass_by(state, self.flow.rows)

    def cross(
        self,
        event: Event[N],
        state: State[N],
        before: ModeRows[N],
        after: ModeRows[N],
        touch: SimultaneousImpacts[N] | None = None,
    ) -> None:
        """Take `event` at `state` from the mode of the rows `before` to that of `after`; touch: of rigid
        stops, where it was one.
        """
        if before is after and touch is None:
            return
        jump = saltation(self.scene, self.kit, state, before, after, event, self.expansion, touch)
        self.tangencies.judge(event, state, before, after, jump)
        if isinstance(jump, ImpactSaltation):
            self.tangencies.struck_at(event.part, state, before)
        jump = None if isinstance(jump, Undefined) else jump
        if jump is not None:
            for i in range(self.possible):
                self.vectors[i] = jump.applied(self.vectors[i])
        if before.leader != after.leader or resting(before.status) != resting(after.status):
            self._change_ties(state, after)
        elif jump is not None:
            self._jumped(jump)

    def _join(self, state: State[N], rows: ModeRows[N]) -> None:
        for i in range(self.possible):
            vector = seated(self.scene, self.kit, rows.status, self.vectors[i])
            self.vectors[i] = joined(self.scene, self.kit, rows, state, vector)

    def _mark(self, end: N) -> N:
        """Time [s] that no piece goes beyond."""
        return end

    def _moved(self, t: N, ahead: N) -> None:
        """Called after a piece from t to `ahead` [s]."""

    def _jumped(self, jump: Jump[N]) -> None:
        """Called after an event that changed no ties."""

    def _change_ties(self, state: State[N], after: ModeRows[N]) -> None:
        self._join(state, after)
