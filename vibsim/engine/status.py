"""What a mode says of each part: one small number per stop, friction and clearance, in the order of the
scene.
"""

from dataclasses import dataclass

OPEN, CONTACT, LIFTED = 0, 1, 2  # a stop; LIFTED: depth above zero, but the damper would have to pull
FORWARD, STICK, BACKWARD = 1, 0, -1  # a friction: sign of v_rel
KEPT, VIOLATED = 0, 1  # a clearance


@dataclass(frozen=True)
class Status:
    """A mode: the state of every part that has several."""

    stops: tuple[int, ...]
    frictions: tuple[int, ...]
    clearances: tuple[int, ...]

    def with_stop(self, i, value):
        return Status(replaced(self.stops, i, value), self.frictions, self.clearances)

    def with_frictions(self, values):
        """values: {index: status}."""
        frictions = tuple(values.get(i, old) for i, old in enumerate(self.frictions))
        return Status(self.stops, frictions, self.clearances)

    def with_clearance(self, i, value):
        return Status(self.stops, self.frictions, replaced(self.clearances, i, value))

    @property
    def codes(self):
        """One tuple: stops, frictions, clearances."""
        return self.stops + self.frictions + self.clearances


def replaced(values, i, value):
    return values[:i] + (value,) + values[i + 1 :]
