"""Blocks of the results of a run: columns by name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

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
