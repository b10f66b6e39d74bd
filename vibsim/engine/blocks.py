"""Blocks of the results of a run: columns by name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np

from vibsim.engine.columns import (
    event_columns,
    part_columns,
    sample_columns,
    stored_at_events,
    stored_columns,
)
from vibsim.physics.numbers import N
from vibsim.physics.parts import EVENT_KINDS, RIGID_KINDS, SWITCH, Scene

OFFSETS = {
    "contact_begin": "stops",
    "contact_end": "stops",
    "violation_begin": "clearances",
    "violation_end": "clearances",
    **dict.fromkeys(RIGID_KINDS, "stops"),
    SWITCH: "every",
}


@dataclass(frozen=True)
class Block:
    """Samples, events and section by column name, 1-D arrays.

    section: time [s] and states at the ends of the periods, empty unless asked for. t_reached: time up to
    which the motion is known [s]; worked_to: time up to which all that goes with it is worked out, the
    ledger say [s]; within a long stretch without events that is further. extremes: least, then greatest of
    every pair in the period that each section point ends, (2 * pairs, points); empty unless asked for.
    """

    samples: dict[str, np.ndarray]
    events: dict[str, np.ndarray]
    section: dict[str, np.ndarray]
    t_reached: float
    worked_to: float
    extremes: np.ndarray


class ColumnMaker(Generic[N]):
    """Makes columns by name of the rows of numbers that the engine fills.

    switches : names of the columns of events that tell the sides of switches
    """

    def __init__(self, scene: Scene[N], switches: Sequence[str] = ()) -> None:
        self.names, self.event_names = sample_columns(scene), (*event_columns(scene), *switches)
        self.timed_states, self.parts = ("time", *stored_columns(scene)), part_columns(scene)
        self.states_happened = (*stored_at_events(scene), *switches)
        self.first_part = part_offsets(scene)
        self.width = 3 + 2 * len(scene.bodies)  # of a state

    def block(
        self,
        samples: np.ndarray,
        sample_codes: np.ndarray,
        events: np.ndarray,
        event_codes: np.ndarray,
        section: np.ndarray,
        reached: tuple[float, float],
    ) -> Block:
        """A block from rows: (time, states), part states; (t, states, phase, velocities before, sides
        of switches), (kind, part, part states); (time, states); (time reached, time worked out to).
        """
        sampled = by_name(self.timed_states, samples) | dict(zip(self.parts, sample_codes, strict=True))
        happened = by_name(self.states_happened, events)
        happened |= {"kind": event_codes[0], "part": self._parts(event_codes[0], event_codes[1])}
        happened |= dict(zip(self.parts, event_codes[2:], strict=True))
        return Block(
            sampled,
            {name: happened[name] for name in self.event_names},
            by_name(self.timed_states, section),
            reached[0],
            reached[1],
            section[self.width :],
        )

    def samples(self, states: np.ndarray, codes: np.ndarray) -> dict[str, np.ndarray]:
        """Columns in the order of samples from rows (time, states) and part states."""
        table = by_name(self.timed_states, states) | dict(zip(self.parts, codes, strict=True))
        return {name: table[name] for name in self.names}

    def _parts(self, kinds: np.ndarray, parts: np.ndarray) -> np.ndarray:
        """Index among `event_parts`, from the index among parts of its sort; -1 for none. Of a switch it is
        that index already.

        Engines give bytes; read without a sign they number 255 parts of a sort, and -1 is the last number.
        """
        numbers: np.ndarray = parts.view("u1") + self.first_part[kinds]
        numbers[parts == -1] = -1
        return numbers


def by_name(names: Iterable[str | None], rows: np.ndarray) -> dict[str, np.ndarray]:
    """Rows by their names, as many as there are; those without a name are left out."""
    table = dict(zip(names, rows, strict=False))
    table.pop(None, None)
    return table  # type: ignore[return-value]  # no name is None


def part_offsets(scene: Scene[N]) -> np.ndarray:
    """By kind of event: index among `event_parts` of the first part of its sort."""
    first = {"stops": 0, "frictions": len(scene.stops), "every": 0}
    first["clearances"] = first["frictions"] + len(scene.frictions)
    return np.array([first[OFFSETS.get(kind, "frictions")] for kind in EVENT_KINDS], dtype="i2")
