"""The columns of a trajectory: what each is called, its unit and its meaning, the same in every file."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from vibsim.engine.columns import FLAGS, part_columns
from vibsim.physics.modes import CONTACT_FLAGS, EVENT_KINDS, FRICTION_FLAGS
from vibsim.physics.parts import Scene as PartsScene
from vibsim.physics.parts import columns_of
from vibsim.physics.scene import Scene as TwoBlocks


@dataclass(frozen=True)
class Column:
    """One column: HDF5 type ("f8", "i1", "i2"), UDUNITS unit (None: a flag), meaning, names of its flags."""

    dtype: str
    units: str | None
    long_name: str
    flags: dict[str, int] = field(default_factory=dict)


TIMES = {
    "time": Column("f8", "s", "time"),
    "t": Column("f8", "s", "time of the event"),
}
KINDS = {
    "kind": Column("i1", None, "kind of the event", EVENT_KINDS),
}
ROTOR = {
    "phi": Column("f8", "rad", "rotor angle"),
    "phidot": Column("f8", "rad s-1", "rotor speed"),
}
PHASE = {
    "phase": Column("f8", "rad", "rotor angle reduced to one turn"),
}
STATES = {
    "x1": Column("f8", "m", "displacement of block 1"),
    "v1": Column("f8", "m s-1", "velocity of block 1"),
    "x2": Column("f8", "m", "displacement of block 2"),
    "v2": Column("f8", "m s-1", "velocity of block 2"),
    **ROTOR,
    **PHASE,
}
MODES = {
    "contact": Column("i1", None, "contact at the stop", CONTACT_FLAGS),
    "friction": Column("i1", None, "friction mode of block 2", FRICTION_FLAGS),
}
JUDGEMENTS = {
    "error_estimate": Column("f8", "m", "estimated error of the displacements"),
}
COLUMNS = {**TIMES, **KINDS, **STATES, **MODES, **JUDGEMENTS}  # of two blocks, in file order
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


def tables_of(scene: TwoBlocks | PartsScene) -> Tables:
    """The columns of a run of `scene`."""
    return _tables_of_two_blocks(scene) if isinstance(scene, TwoBlocks) else _tables_of_parts(scene)


def _tables(states: dict[str, Column], parts: dict[str, Column], of_event: dict[str, Column]) -> Tables:
    phase = PHASE if "phi" in states else {}
    return Tables(
        {"time": TIMES["time"], **states, **parts},
        {"t": TIMES["t"], **KINDS, **of_event, **states, **phase, **parts},
        tuple(states),
    )


def _tables_of_two_blocks(scene: TwoBlocks) -> Tables:
    names = scene.columns()
    states, modes = ({name: known[name] for name in names if name in known} for known in (STATES, MODES))
    return _tables(states, modes, {})


def _tables_of_parts(scene: PartsScene) -> Tables:
    states: dict[str, Column] = {}
    for body in scene.bodies:
        x, v = columns_of(body.name)
        states[x] = Column("f8", "m", f"displacement of {body.name}")
        states[v] = Column("f8", "m s-1", f"velocity of {body.name}")
    if scene.has_motor:
        states |= ROTOR
    parts = dict(zip(part_columns(scene), _part_states(scene), strict=True))
    return _tables(states, parts, {"part": _part_of_event(scene)})


def _part_states(scene: PartsScene) -> Iterable[Column]:
    """A column of flags for each part that has states, in the order of `part_columns`."""
    kinds: tuple[tuple[str, str, tuple[Any, ...]], ...] = (
        ("stops", "stop", scene.stops),
        ("frictions", "friction", scene.frictions),
        ("clearances", "clearance", scene.clearances),
    )
    for kind, word, parts in kinds:
        for part in parts:
            ends = f"{scene.end_name(part.P)} and {scene.end_name(part.Q)}"
            yield Column("i1", None, f"state of the {word} {part.name} between {ends}", FLAGS[kind])


def part_names(scene: PartsScene) -> tuple[str, ...]:
    """Names of the parts that have states, in the order of `part_columns`."""
    parts: tuple[Any, ...] = (*scene.stops, *scene.frictions, *scene.clearances)
    return tuple(part.name for part in parts)


def _part_of_event(scene: PartsScene) -> Column:
    """The part that an event is of, by its number among those that have states."""
    flags = {NO_PART: -1} | {name: i for i, name in enumerate(part_names(scene))}
    return Column("i1" if len(flags) < 128 else "i2", None, "part that the event is of", flags)
