"""Files of the short form from before events named their part and a rest distance had a state."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibsim.engine.trajectories.blocks import part_offsets
from vibsim.files.declarations import Column
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Clearance, Scene
from vibsim.results.columns import Tables

Table = Mapping[str, np.ndarray]
NO_PARTS = [EVENT_KINDS["start"], EVENT_KINDS["end"]]


def older_tables(tables: Tables, scene: Scene) -> Tables:
    """The columns that such a file has."""
    added = {"part", *(clearance.name for clearance in scene.clearances)}

    def without(columns: Mapping[str, Column]) -> dict[str, Column]:
        return {name: column for name, column in columns.items() if name not in added}

    return replace(tables, samples=without(tables.samples), events=without(tables.events))


class CompletedEvents(dict[str, np.ndarray]):
    """The events of such a file with the columns that it lacks: their kinds tell the parts."""

    def __init__(self, events: Table, scene: Scene):
        kind = np.asarray(events["kind"])
        part = np.where(np.isin(kind, NO_PARTS), -1, part_offsets(scene)[kind])
        super().__init__({**events, "part": part.astype("i1")})
        for clearance in scene.clearances:
            self[clearance.name] = _violated(events, clearance)


def _violated(events: Table, clearance: Clearance) -> np.ndarray:
    """Whether the distance is violated behind each event."""
    kind, far = np.asarray(events["kind"]), np.asarray(events["x1"] - events.get("x2", 0.0))
    begun = (kind == EVENT_KINDS["violation_begin"]).astype(int)
    ended = (kind == EVENT_KINDS["violation_end"]).astype(int)
    return (int(far[0] > clearance.distance) + np.cumsum(begun - ended)).astype("i1")
