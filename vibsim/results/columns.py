"""The columns of a trajectory: what each is called, its unit and its meaning, the same in every file."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from vibsim.engine.columns import before_columns, flags_of_parts, part_columns
from vibsim.files.declarations import Column
from vibsim.physics.modes import EVENT_KINDS, RIGID_KINDS
from vibsim.physics.parts import Scene, columns_of

TIMES = {
    "time": Column("s", "time"),
    "t": Column("s", "time of the event"),
}
COMMON_KINDS = {name: code for name, code in EVENT_KINDS.items() if name not in RIGID_KINDS}
KINDS = {
    "kind": Column(None, "kind of the event", dtype="i1", flags=COMMON_KINDS),
}
KINDS_OF_RIGID_STOPS = {
    "kind": Column(None, "kind of the event", dtype="i1", flags=EVENT_KINDS),
}
ROTOR = {
    "phi": Column("rad", "rotor angle"),
    "phidot": Column("rad s-1", "rotor speed"),
}
PHASE = {
    "phase": Column("rad", "rotor angle reduced to one turn"),
}
JUDGEMENTS = {
    "error_estimate": Column("m", "estimated error of the displacements"),
}
NO_PART = "none"  # to which an event belongs: start, end


@dataclass(frozen=True)
class Tables:
    """The columns of the samples and of the events of a run, by name in file order.

    states : names of the sampled states; displacements : those of them that are displacements of bodies
    """

    samples: dict[str, Column]
    events: dict[str, Column]
    states: tuple[str, ...]

    @property
    def displacements(self) -> tuple[str, ...]:
        return tuple(name for name in self.states if self.samples[name].units == "m")

    @property
    def flags(self) -> tuple[str, ...]:
        """Names of the sampled columns that say the state of a part."""
        return tuple(name for name, column in self.samples.items() if column.flags)

    def judged(self, judgements: Iterable[str] = JUDGEMENTS) -> "Tables":
        """These, and columns that judge the samples."""
        return replace(self, samples=self.samples | {name: JUDGEMENTS[name] for name in judgements})


def tables_of(scene: Scene) -> Tables:
    """The columns of a run of `scene`."""
    states: dict[str, Column] = {}
    for body in scene.bodies:
        x, v = columns_of(body.name)
        states[x] = Column("m", f"displacement of {_called(body.name)}")
        states[v] = Column("m s-1", f"velocity of {_called(body.name)}")
    if scene.has_motor:
        states |= ROTOR
    parts = dict(zip(part_columns(scene), _part_states(scene), strict=True))
    kinds = KINDS_OF_RIGID_STOPS if scene.rigid_stops else KINDS
    in_full = {**states, **(PHASE if scene.has_motor else {})}
    in_full |= {name: _before(states[name.removeprefix("before_")]) for name in before_columns(scene)}
    return Tables(
        {"time": TIMES["time"], **states, **parts},
        {"t": TIMES["t"], **kinds, "part": _part_of_event(scene), **in_full, **parts},
        tuple(states),
    )


def _called(body: str) -> str:
    return f"block {body}" if body.isdigit() else body


def _before(column: Column) -> Column:
    return replace(column, long_name=f"{column.long_name} in front of the event")


def _part_states(scene: Scene) -> Iterable[Column]:
    """A column of flags for each part that has states, in the order of `part_columns`."""
    words = ["stop"] * len(scene.stops) + ["friction"] * len(scene.frictions)
    words += ["clearance"] * len(scene.clearances)
    parts: tuple[Any, ...] = (*scene.stops, *scene.frictions, *scene.clearances)
    for word, part, flags in zip(words, parts, flags_of_parts(scene), strict=True):
        called = word if part.name == word else f"{word} {part.name}"
        ends = f"{_called(scene.end_name(part.P))} and {_called(scene.end_name(part.Q))}"
        yield Column(None, f"state of the {called} between {ends}", dtype="i1", flags=flags)


def part_names(scene: Scene) -> tuple[str, ...]:
    """Names of the parts that have states, in the order of `part_columns`."""
    parts: tuple[Any, ...] = (*scene.stops, *scene.frictions, *scene.clearances)
    return tuple(part.name for part in parts)


def _part_of_event(scene: Scene) -> Column:
    """The part that an event is of, by its number among those that have states."""
    flags = {NO_PART: -1} | {name: i for i, name in enumerate(part_names(scene))}
    dtype = "i1" if len(flags) < 128 else "i2"
    return Column(None, "part that the event is of", dtype=dtype, flags=flags)
