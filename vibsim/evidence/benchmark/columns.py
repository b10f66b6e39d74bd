"""The columns of a bench file: what each row of it holds."""

from vibsim.evidence.benchmark.row import STATUS_FLAGS
from vibsim.evidence.peers.attempt import kinds_of
from vibsim.files.declarations import Column
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene

NONE = -1  # of a count that a method does not give


def scales_of(scene: Scene) -> dict[str, Column]:
    """What counts rows, instants and kinds of events."""
    flags = {name: EVENT_KINDS[name] for name in kinds_of(scene)}
    return {
        "row": Column("1", "row of the bench", dtype="i4"),
        "time": Column("s", "time"),
        "kind": Column("1", "kind of the events", dtype="i1", flags=flags),
    }


TEXTS = {
    "method": Column(None, "family of methods", dtype="text"),
    "label": Column(None, "family of methods in words", dtype="text"),
    "setting": Column(None, "setting of the method", dtype="text"),
    "problem": Column(None, "why the method failed", dtype="text"),
}
ROW = {
    "wall_time": Column("s", "wall time of a run, least"),
    "cpu_time": Column("s", "CPU time of a run, least"),
    "setup_time": Column("s", "wall time before the first run, such as compiling"),
    "runs": Column("1", "runs of which the least is taken", dtype="i4"),
    "steps": Column("1", "steps of a run", dtype="i8", missing=NONE),
    "evaluations": Column("1", "right-hand sides evaluated in a run", dtype="i8", missing=NONE),
    "t_reached": Column("s", "time of the motion until which the method ran"),
    "faithful_time": Column("s", "time until which the displacements are faithful"),
}
STATUS = Column("1", "what came of the row", dtype="i1", flags=STATUS_FLAGS)
ERROR = Column("m", "largest error of the displacements")
COUNTS = {
    "found": Column("1", "true events found, up to faithful_time", dtype="i8", missing=NONE),
    "missed": Column("1", "true events missed, up to faithful_time", dtype="i8", missing=NONE),
    "spurious": Column("1", "events reported that are not, up to faithful_time", dtype="i8", missing=NONE),
}
