"""States between samples: the engine restarted from stored events."""

from collections.abc import Mapping

import numpy as np

from vibsim.engine.resume import rows_of_instant
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene
from vibsim.results.columns import tables_of


def states_at(
    scene: Scene, events: Mapping[str, np.ndarray], t: float | np.ndarray, t_reached: float
) -> dict[str, np.ndarray]:
    """Columns at the instants `t` [s], each computed from the last of the `events` that is not after it.

    Returns name -> array of the shape of `t`. Raises ValueError for times before 0 or after `t_reached`.
    """
    try:
        times = np.asarray(t, dtype="f8")
    except (TypeError, ValueError):
        raise TypeError(f"times must be numbers [s], got {t!r:.60}") from None
    flat = times.ravel()
    if not np.all((flat >= 0) & (flat <= t_reached)):
        raise ValueError(f"times must lie between 0 and {t_reached:g} s, the span of the run")
    order = np.argsort(flat, kind="stable")
    ascending = flat[order]
    starts = events["t"][events["kind"] != EVENT_KINDS["end"]]  # nothing starts at the end
    last_event = np.searchsorted(starts, ascending, side="right") - 1
    pieces = []
    for event in np.unique(last_event):
        rows = rows_of_instant(events, int(event))
        pieces.append(open_trajectory(scene, resume=rows).state_at(ascending[last_event == event]))
    columns = {name: [piece[name] for piece in pieces] for name in tables_of(scene).samples}
    return {name: _in_order(parts, order, times.shape) for name, parts in columns.items()}


def _in_order(pieces: list[np.ndarray], order: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    ascending = np.concatenate(pieces) if pieces else np.empty(0)
    values = np.empty_like(ascending)
    values[order] = ascending
    return values.reshape(shape)
