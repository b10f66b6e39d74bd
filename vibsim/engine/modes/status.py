"""State of each part in a mode: one small number per stop, friction and clearance, in the order of the
scene.
"""

from collections.abc import Mapping
from typing import NamedTuple, TypeVar

OPEN, CONTACT, LIFTED = 0, 1, 2  # a stop; LIFTED: depth above zero, but the damper would have to pull
RESTING = 3  # a rigid stop; the others of these are open
FORWARD, STICK, BACKWARD = 1, 0, -1  # a friction: sign of v_rel
KEPT, VIOLATED = 0, 1  # a clearance


class Status(NamedTuple):
    """A mode: the state of every part that has several, and the side of each switch of a formula; None of
    those that no formula of the mode reads.
    """

    stops: tuple[int, ...]
    frictions: tuple[int, ...]
    clearances: tuple[int, ...]
    switches: tuple[int | None, ...] = ()

    def with_stop(self, i: int, value: int) -> "Status":
        return Status(replaced(self.stops, i, value), *self[1:])

    def with_frictions(self, values: Mapping[int, int]) -> "Status":
        """values: {index: status}."""
        frictions = tuple([values.get(i, old) for i, old in enumerate(self.frictions)])
        return Status(self.stops, frictions, *self[2:])

    def with_ties(self, values: Mapping[int, int]) -> "Status":
        """values: {number of the tie: status of a friction}; ties are the frictions, then the stops, of which
        those that do not stick are open.
        """
        count, after = len(self.frictions), self.with_frictions(values)
        if all(k < count for k in values):
            return after
        stops = tuple(
            old if count + i not in values else RESTING if values[count + i] == STICK else OPEN
            for i, old in enumerate(self.stops)
        )
        return Status(stops, *after[1:])

    @property
    def tied(self) -> list[int]:
        """Numbers of the ties that hold: frictions that stick, then stops that rest."""
        count = len(self.frictions)
        sticking = [i for i, value in enumerate(self.frictions) if value == STICK]
        if RESTING not in self.stops:
            return sticking
        return sticking + [count + i for i, value in enumerate(self.stops) if value == RESTING]

    def with_clearance(self, i: int, value: int) -> "Status":
        return Status(*self[:2], replaced(self.clearances, i, value), self.switches)

    @property
    def codes(self) -> tuple[int, ...]:
        """One tuple: stops, frictions, clearances; no switches."""
        return self.stops + self.frictions + self.clearances


Key = TypeVar("Key")
Value = TypeVar("Value")


class Kept(dict[Key, Value]):
    """Cache of what belongs to modes, all of which is forgotten where it comes to weigh more than
    `most`.

    A scene of many frictions meets modes without end, and comes back to few of them.
    """

    def __init__(self, most: int) -> None:
        super().__init__()
        self.most, self.weight = most, 0

    def keep(self, key: Key, value: Value, weight: int = 1) -> Value:
        """Keep a value, and return it; that of another thread, where there is one."""
        if self.weight + weight > self.most:
            self.clear()
            self.weight = 0
        self.weight += weight
        return self.setdefault(key, value)


def replaced(values: tuple[int, ...], i: int, value: int) -> tuple[int, ...]:
    return values[:i] + (value,) + values[i + 1 :]
