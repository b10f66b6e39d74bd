"""Results of a run: blocks of columns by name, totals, states between events."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypedDict

import numpy as np

from vibsim.engine.columns import (
    event_columns,
    part_columns,
    sample_columns,
    stored_at_events,
    stored_columns,
)
from vibsim.engine.modes.ties import Edge
from vibsim.physics.numbers import N
from vibsim.physics.parts import EVENT_KINDS, RIGID_KINDS, SWITCH, Scene

Gap = tuple[int, int, int, float]  # stop, its place among the pairs, sense, gap [m]
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


class Wishes(TypedDict, total=False):
    """Options of what a run keeps besides samples and events; see `open_trajectory`.

    tangent : number of disturbances, and from when their growth counts [s]
    extremes : columns of the pairs, the stops whose gaps are watched, since when [s]
    early, dither, record_from : see there
    """

    section: bool
    ledger: bool
    momentum: bool
    tangent: tuple[int, float]
    extremes: tuple[Sequence[Edge], Sequence[Gap], float] | None
    early: bool
    dither: int
    record_from: tuple[float, float]


class Trajectory(Generic[N]):
    """Base of runs in doubles and in words: makes columns by name of rows of numbers."""

    def __init__(self, scene: Scene[N]) -> None:
        self.scene = scene
        self.names, self.event_names = sample_columns(scene), event_columns(scene)
        self.timed_states, self.parts = ("time", *stored_columns(scene)), part_columns(scene)
        self.states_happened = stored_at_events(scene)
        self.first_part = part_offsets(scene)

    def blocks(self) -> Iterator[Block]:
        """Yield `Block`s until the run ends; raises EngineError when it fails."""
        raise NotImplementedError

    def stop(self) -> None:
        """Have `blocks` end with what is computed, from any thread; at once where it decides what follows."""
        raise NotImplementedError

    @property
    def totals(self) -> dict[str, Any]:
        """Counts and margins so far, and the ledgers and exponents where they are kept, as doubles."""
        raise NotImplementedError

    @property
    def left_out(self) -> list[tuple[float, float]]:
        """(time [s], distance [m] that ends of infinite sequences of impacts have left out from then on)."""
        raise NotImplementedError

    @property
    def extremes(self) -> tuple[list[float], list[float], list[float]]:
        """Least and greatest of every pair so far, and the smallest gap of every stop that is watched."""
        raise NotImplementedError

    def state_at(self, times: Iterable[float]) -> dict[str, np.ndarray]:
        """States at ascending times before the next event, as columns."""
        raise NotImplementedError

    def block(
        self,
        samples: np.ndarray,
        sample_codes: np.ndarray,
        events: np.ndarray,
        event_codes: np.ndarray,
        section: np.ndarray,
        reached: tuple[float, float],
    ) -> Block:
        """A block from rows: (time, states), part states; (t, states, phase, velocities before), (kind, part,
        part states); (time, states); (time reached, time worked out to).
        """
        sampled = by_name(self.timed_states, samples) | dict(zip(self.parts, sample_codes, strict=True))
        happened = by_name(self.states_happened, events)
        happened |= {"kind": event_codes[0], "part": self._parts(event_codes[0], event_codes[1])}
        happened |= dict(zip(self.parts, event_codes[2:], strict=True))
        width = 3 + 2 * len(self.scene.bodies)  # of a state
        return Block(
            sampled,
            {name: happened[name] for name in self.event_names},
            by_name(self.timed_states, section),
            reached[0],
            reached[1],
            section[width:],
        )

    def restart(self, scene: Scene[N]) -> None:
        """Begin anew, from the start of a scene that differs from that of the run in its start alone.

        What the blocks before have shown holds no longer.
        """
        raise NotImplementedError

    def pause_at(self, time: float) -> None:
        """Have the block end with which the run reaches a time [s]; the next one where there is no other."""
        raise NotImplementedError

    @property
    def at_begin(self) -> dict[str, np.ndarray]:
        """Time and state from which samples are recorded, as columns of one."""
        raise NotImplementedError

    def columns_of(self, states: np.ndarray, codes: Iterable[Any]) -> dict[str, np.ndarray]:
        """Columns by name of rows (time, states) and part states: one for all rows, or one for each."""
        table = by_name(self.timed_states, states)
        for name, code in zip(self.parts, codes, strict=True):
            table[name] = np.full(states.shape[1], code, dtype="i1")
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
