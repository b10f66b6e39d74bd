"""What a bench file holds."""

from vibsim.evidence.benchmark.columns import COUNTS, ERROR, ROW, STATUS, TEXTS, scales_of
from vibsim.evidence.peers.attempt import kinds_of
from vibsim.files.declarations import LIST, NUMBER, TEXT, WHOLE, Attribute, Dataset
from vibsim.files.provenance import PROVENANCE
from vibsim.physics.parts import Scene
from vibsim.results.columns import tables_of

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


def lengths_of(scene: Scene) -> dict[str, int]:
    """Lengths of the dimensions that are known."""
    return {"kind": len(kinds_of(scene))}


def datasets_of(scene: Scene) -> list[Dataset]:
    """The datasets of a bench of that scene."""
    return [*_truth(scene), *_rows(scene)]


def _truth(scene: Scene) -> list[Dataset]:
    tables = tables_of(scene)
    states = [Dataset(f"truth/{name}", tables.samples[name], ("time",)) for name in tables.states]
    return [
        Dataset("truth/time", tables.samples["time"], ("time",), ascending=True),
        *states,
        Dataset("truth/events/t", tables.events["t"], ("t",), ascending=True),
        Dataset("truth/events/kind", tables.events["kind"], ("t",)),
    ]


def _rows(scene: Scene) -> list[Dataset]:
    scales = [Dataset(name, column, (name,)) for name, column in scales_of(scene).items()]
    of_rows = {**TEXTS, "status": STATUS, **ROW}
    rows = [Dataset(name, column, ("row",), gaps=True) for name, column in of_rows.items()]
    errors = Dataset("error", ERROR, ("row", "time"), gaps=True)
    counts = [Dataset(name, column, ("row", "kind")) for name, column in COUNTS.items()]
    return [*scales, *rows, errors, *counts]
