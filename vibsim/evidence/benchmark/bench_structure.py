"""What a bench file must hold."""

from vibsim.engine.columns import state_columns
from vibsim.evidence.benchmark.columns import COUNTS, ROW, TEXTS
from vibsim.evidence.benchmark.row import STATUS_FLAGS
from vibsim.evidence.peers.attempt import EVERY_KIND
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene
from vibsim.results.structure import LIST, NUMBER, TEXT, WHOLE, Attribute, Dataset
from vibsim.results.trajectory_structure import PROVENANCE

WORDS = ("methods", "not_installed", "processor", "scipy_version", "heyoka_version")
TRUTH = ("truth_sha256", "truth_library")
ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in (*WORDS, *TRUTH)),
    *(Attribute(name, WHOLE) for name in ("truth_digits", "truth_digits_right", "cores")),
    *(Attribute(name, NUMBER) for name in ("truth_wall_time_s", "t_end_s", "limit_s")),
    Attribute("check_times_s", LIST),
    Attribute("complete", WHOLE, allowed=(0, 1)),
]


def datasets_of(scene: Scene) -> list[Dataset]:
    """The datasets of a bench of that scene."""
    return [*_truth(scene), *_rows()]


LENGTHS = {"kind": len(EVERY_KIND)}  # of the dimensions that are known


def _truth(scene: Scene) -> list[Dataset]:
    times = [Dataset("truth/time", "f8", ("time",), ascending=True)]
    states = [Dataset(f"truth/{name}", "f8", ("time",)) for name in state_columns(scene)]
    kinds = frozenset(EVENT_KINDS.values())
    kind = Dataset("truth/events/kind", "i1", ("event",), kinds)
    return [*times, *states, Dataset("truth/events/t", "f8", ("event",), ascending=True), kind]


def _rows() -> list[Dataset]:
    texts = [Dataset(name, "text", ("row",)) for name in TEXTS]
    status = Dataset("status", "i1", ("row",), frozenset(STATUS_FLAGS.values()))
    numbers = [Dataset(name, column.dtype, ("row",), missing=True) for name, column in ROW.items()]
    errors = Dataset("error", "f8", ("row", "time"), missing=True)
    return [*texts, status, *numbers, errors, *(Dataset(name, "i8", ("row", "kind")) for name in COUNTS)]
