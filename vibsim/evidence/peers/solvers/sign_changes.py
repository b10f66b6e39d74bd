"""Contacts read off a run without events: where the depth of a stop changes sign between two steps."""

from collections.abc import Callable, Sequence

from vibsim.evidence.peers.equations.compiled import state_count
from vibsim.evidence.peers.equations.of_motion import Equations
from vibsim.evidence.peers.equations.straight_line import Tape
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene

BEGIN, END = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]

Depths = Callable[[float, Sequence[float]], tuple[float, ...]]


def depths_of(scene: Scene) -> Depths:
    """The depths [m] of the stops of a scene at (t, state)."""
    tape = Tape(state_count(scene))
    at = Equations(scene, tape, tape.t, tape.states)
    return tape.function([at.depth(stop) for stop in scene.stops])


class SignChanges:
    """Collects `events` (time [s], kind) while it is shown the states of a run step by step."""

    def __init__(self, depths: Depths, state: Sequence[float]):
        self.events: list[tuple[float, int]] = []
        self._depths, self._t, self._last = depths, 0.0, depths(0.0, state)

    def look(self, t: float, state: Sequence[float]) -> None:
        """The next state; a sign that has changed since the last is a contact, timed on the chord."""
        depths = self._depths(t, state)
        for depth, last in zip(depths, self._last, strict=True):
            if (depth >= 0) != (last >= 0):
                crossing = self._t + (t - self._t) * last / (last - depth)
                self.events.append((crossing, BEGIN if depth >= 0 else END))
        self._t, self._last = t, depths
