"""A bench as an HDF5 file: written whole beside its name and renamed, so that it opens at every moment."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.evidence.benchmark.bench_structure import datasets_of
from vibsim.evidence.benchmark.columns import COUNTS, NONE, ROW, TEXTS
from vibsim.evidence.benchmark.event_counts import EventCount
from vibsim.evidence.benchmark.families import family_of
from vibsim.evidence.benchmark.row import Row
from vibsim.evidence.benchmark.truth import Truth
from vibsim.evidence.peers.attempt import kinds_of
from vibsim.files.writing import write_hdf5
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene

OWN = ("method", "setting", "problem", "status", *ROW, "error")  # what a Row has by the same name


def write_bench(
    path: Path, attrs: Mapping[str, Any], scene: Scene, truth: Truth, rows: Sequence[Row]
) -> None:
    """Write a bench of `scene` to `path`, replacing what is there in one instant. Raises ResultFileError."""
    kinds = kinds_of(scene)
    known = {**attrs, "truth_sha256": truth.fingerprint, **truth.attrs}
    values = {
        **{f"truth/{name}": column for name, column in truth.samples.items()},
        **{f"truth/events/{name}": column for name, column in truth.events.items()},
        "row": np.arange(len(rows)),
        "time": truth.samples["time"],
        "kind": [EVENT_KINDS[name] for name in kinds],
        "label": [family_of(row.method).label for row in rows],
        **{name: [getattr(row, name) for row in rows] for name in OWN},
        **{name: [_count(row, kind, name) for row in rows for kind in kinds] for name in COUNTS},
    }
    write_hdf5(path, known, datasets_of(scene), values)


def _count(row: Row, kind: str, name: str) -> int:
    return getattr(row.events[kind], name) if kind in row.events else NONE


def read_truth(values: Mapping[str, Any], attrs: Mapping[str, Any]) -> Truth:
    """The truth in a bench file of these datasets and attributes."""
    events = {name: values[f"truth/events/{name}"] for name in ("t", "kind")}
    samples = {
        name.removeprefix("truth/"): column
        for name, column in values.items()
        if name.startswith("truth/") and not name.startswith("truth/events/")
    }
    known = {name: attrs[name] for name in attrs if name.startswith("truth_") and name != "truth_sha256"}
    return Truth(attrs["truth_sha256"], samples, events, known)


def read_rows(values: Mapping[str, Any], scene: Scene) -> list[Row]:
    """The rows in a bench file of these datasets, of a bench of `scene`."""
    count, kinds = len(values["row"]), kinds_of(scene)
    return [_row({name: values[name][i] for name in (*OWN, *COUNTS)}, kinds) for i in range(count)]


def _row(values: Mapping[str, Any], kinds: Sequence[str]) -> Row:
    own: dict[str, Any] = {name: str(values[name]) for name in TEXTS if name in OWN}
    own |= {name: values[name].item() for name in ("status", *ROW)}
    events = {
        kind: EventCount(**{name: int(values[name][k]) for name in COUNTS})
        for k, kind in enumerate(kinds)
        if values["found"][k] != NONE
    }
    return Row(**own, error=values["error"], events=events)
