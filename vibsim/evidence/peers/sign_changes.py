"""Contacts read off a run without events: where the gap function changes sign between two steps."""

from collections.abc import Sequence

from vibsim.evidence.peers.equations import Equations
from vibsim.physics.modes import EVENT_KINDS

BEGIN, END = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]


class SignChanges:
    """Collects `events` (time [s], kind) while it is shown the states of a run step by step."""

    def __init__(self, equations: Equations, state: Sequence[float]):
        self.events: list[tuple[float, int]] = []
        self._gap_at = equations.gap if equations.scene.has_stop else None
        self._t, self._gap = 0.0, self._gap_at(state) if self._gap_at else -1.0

    def look(self, t: float, state: Sequence[float]) -> None:
        """The next state; a sign that has changed since the last is a contact, timed on the chord."""
        if self._gap_at is None:
            return
        gap = self._gap_at(state)
        if (gap >= 0) != (self._gap >= 0):
            crossing = self._t + (t - self._t) * self._gap / (self._gap - gap)
            self.events.append((crossing, BEGIN if gap >= 0 else END))
        self._t, self._gap = t, gap
