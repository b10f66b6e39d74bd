"""The columns of a trajectory: what each is called, its unit and its meaning, the same in every file."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from vibsim.physics.modes import CONTACT_FLAGS, EVENT_KINDS, FRICTION_FLAGS


@dataclass(frozen=True)
class Column:
    """One column: HDF5 type ("f8", "i1"), UDUNITS unit (None: a flag), meaning, names of flag values."""

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
STATES = {
    "x1": Column("f8", "m", "displacement of block 1"),
    "v1": Column("f8", "m s-1", "velocity of block 1"),
    "x2": Column("f8", "m", "displacement of block 2"),
    "v2": Column("f8", "m s-1", "velocity of block 2"),
    "phi": Column("f8", "rad", "rotor angle"),
    "phidot": Column("f8", "rad s-1", "rotor speed"),
    "phase": Column("f8", "rad", "rotor angle reduced to one turn"),
}
MODES = {
    "contact": Column("i1", None, "contact at the stop", CONTACT_FLAGS),
    "friction": Column("i1", None, "friction mode of block 2", FRICTION_FLAGS),
}
JUDGEMENTS = {
    "error_estimate": Column("f8", "m", "estimated error of the displacements"),
}
COLUMNS = {**TIMES, **KINDS, **STATES, **MODES, **JUDGEMENTS}  # in file order


def in_file_order(names: Iterable[str]) -> list[str]:
    """Column names in file order; names of other vibsim versions come last."""
    known = list(COLUMNS)
    return sorted(names, key=lambda name: known.index(name) if name in COLUMNS else len(known))


def event_columns(sample_columns: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the event columns, in file order, of a trajectory with these sample columns."""
    states = [name for name in sample_columns if name in STATES]
    phase = ["phase"] if "phi" in states else []
    modes = [name for name in sample_columns if name in MODES]
    return ("t", "kind", *states, *phase, *modes)
