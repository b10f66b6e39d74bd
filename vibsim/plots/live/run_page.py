"""What the page of a run holds: samples and events in one table, panels, and the relative motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibsim.physics.modes import EVENT_KINDS, IMPACTS
from vibsim.plots.errors import PlotError
from vibsim.plots.live.html_file import packed
from vibsim.plots.motion.natural_frequencies import shortest_period
from vibsim.plots.motion.pairs import pair_of
from vibsim.plots.page.quantities import scale_for
from vibsim.plots.subject import Subject
from vibsim.results.columns import part_names

KEYS = (
    "Wheel: zoom; drag: move; double click: everything. Keys: arrows, + and -, 0 everything, n and p the "
    "next impact and the one before, d light or dark."
)
MOST_ROWS = 600_000  # of samples and events: 20 MB; of longer runs the extremes are kept
PERIODS_ABOUT_IMPACT = 1.5  # of the fastest vibration, shown about an impact
PER_EXTREME = 2  # rows kept of each column and stretch, besides its first
Table = dict[str, np.ndarray]


def run_data(subject: Subject) -> dict[str, Any]:
    """The data of `run.js`. Raises PlotError for a run without samples."""
    result, scene = subject.result, subject.scene
    if len(result) < 2:
        raise PlotError(f"{subject.path}: the run holds {len(result)} samples: nothing to draw")
    rows = table_of(subject)
    pair = pair_of(subject)
    x, v = pair.plane({**rows, "time": rows["time"]})
    rows |= {"<x>": x, "<v>": v}
    scales = scale_for("m", x), scale_for("m/s", v)
    return {
        "t": packed(rows["time"], "f8"),
        "columns": {
            name: {"data": packed(values, _type(name)), "type": _type(name)}
            for name, values in rows.items()
            if name != "time"
        },
        "panels": panels(subject, rows),
        "portrait": {
            "x": "<x>",
            "y": "<v>",
            "factors": [scales[0].factor, scales[1].factor],
            "xLabel": scales[0].label("relative displacement"),
            "yLabel": scales[1].label("relative velocity"),
            "stops": [position for position, _ in pair.stops],
        },
        "events": _events(result),
        "kinds": {code: name for name, code in EVENT_KINDS.items()},
        "parts": part_names(scene),
        "impactKinds": [EVENT_KINDS[name] for name in IMPACTS],
        "impactSpan": PERIODS_ABOUT_IMPACT * (shortest_period(scene) or 1.0),
        "horizon": result.trust_horizon,
    }


def table_of(subject: Subject) -> Table:
    """Samples and events in ascending time; where velocities jump at an event, the state before it too."""
    result, states = subject.result, subject.tables.states
    samples = {name: np.asarray(result[name]) for name in ("time", *states)}
    events, after = result.events, {name: np.asarray(result.events[name]) for name in states}
    after["time"] = np.asarray(events["t"])
    parts = [samples, after]
    if any(f"before_{name}" in events for name in states):
        before = {name: events[f"before_{name}" if f"before_{name}" in events else name] for name in states}
        parts.insert(0, {**before, "time": after["time"]})
    joined = {name: np.concatenate([part[name] for part in parts]) for name in samples}
    order = np.argsort(joined["time"], kind="stable")
    rows = {name: values[order] for name, values in joined.items()}
    return rows if len(order) <= MOST_ROWS else thinned(rows, MOST_ROWS)


def thinned(rows: Table, most: int) -> Table:
    """About `most` rows: of every stretch the first, and those in which a column is least or greatest."""
    count, names = len(rows["time"]), [name for name in rows if name != "time"]
    stretch = -(-count * (1 + PER_EXTREME * len(names)) // most)
    whole = count // stretch * stretch
    begins = np.arange(0, whole, stretch)
    indices = [begins, np.arange(whole, count)]
    for name in names:
        blocks = rows[name][:whole].reshape(-1, stretch)
        indices += [begins + blocks.argmin(axis=1), begins + blocks.argmax(axis=1)]
    places = np.unique(np.concatenate(indices))
    return {name: values[places] for name, values in rows.items()}


def panels(subject: Subject, rows: Table) -> list[dict[str, Any]]:
    """Displacements, velocities, and the speed of a motor."""
    listed = []
    for words, unit in (("displacement", "m"), ("velocity", "m/s")):
        names = subject.columns_in(unit)
        scale = scale_for(unit, *(rows[name] for name in names))
        curves = [
            {"name": name, "column": name, "colour": i, **_interpolated(name)} for i, name in enumerate(names)
        ]
        listed.append(
            {"label": scale.label(words), "unit": scale.unit, "factor": scale.factor, "curves": curves}
        )
    if subject.scene.has_motor:
        curve = {"name": "motor speed", "column": "phidot", "colour": 2, "rate": None}
        listed.append({"label": "motor speed (Hz)", "unit": "Hz", "factor": 0.5 / np.pi, "curves": [curve]})
    return listed


def _interpolated(name: str) -> dict[str, Any]:
    """How a column is read between rows: a displacement by its velocity, this as the rate of that cubic."""
    if name.startswith("x"):
        return {"rate": f"v{name[1:]}"}
    return {"rate": None, "of": f"x{name[1:]}"}


def _type(name: str) -> str:
    """Displacements in full: their cubics lose the digits that neighbouring rows share."""
    return "f8" if name.startswith("x") or name == "<x>" else "f4"


def _events(result: Any) -> dict[str, str]:
    types = {"t": "f8", "kind": "i1", "part": "i2"}
    return {name: packed(result.events[name], dtype) for name, dtype in types.items()}
