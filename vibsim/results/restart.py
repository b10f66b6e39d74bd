"""States between samples: the engine restarted from stored events."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene as PartsScene
from vibsim.physics.scene import Scene as TwoBlocks
from vibsim.results.columns import tables_of
from vibsim.results.engines import open_run


def states_at(
    scene: TwoBlocks | PartsScene, events: Mapping[str, np.ndarray], t: float | np.ndarray, t_reached: float
) -> dict[str, np.ndarray]:
    """Columns at the instants `t` [s], each computed from the last of the `events` that is not after it.

    Returns name -> array of the shape of `t`. Raises ValueError for times before 0 or after `t_reached`.
    """
    times = np.asarray(t, dtype="f8")
    flat = times.ravel()
    if not np.all((flat >= 0) & (flat <= t_reached)):
        raise ValueError(f"times must lie between 0 and {t_reached:g} s, the span of the run")
    order = np.argsort(flat, kind="stable")
    ascending = flat[order]
    starts = events["t"][events["kind"] != EVENT_KINDS["end"]]  # nothing starts at the end
    last_event = np.searchsorted(starts, ascending, side="right") - 1
    pieces = []
    for event in np.unique(last_event):
        rows = _rows_of_one_instant(events, starts, event)
        resume = rows[-1] if isinstance(scene, TwoBlocks) else rows
        pieces.append(open_run(scene, resume=resume).state_at(ascending[last_event == event]))
    columns = {name: [piece[name] for piece in pieces] for name in tables_of(scene).samples}
    return {name: _in_order(parts, order, times.shape) for name, parts in columns.items()}


def _rows_of_one_instant(
    events: Mapping[str, np.ndarray], starts: np.ndarray, event: int
) -> list[dict[str, Any]]:
    """The rows of the events at the instant of number `event`, up to it, values by column name."""
    first = int(np.searchsorted(starts, starts[event], side="left"))
    return [{name: column[i].item() for name, column in events.items()} for i in range(first, int(event) + 1)]


def _in_order(pieces: list[np.ndarray], order: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    ascending = np.concatenate(pieces) if pieces else np.empty(0)
    values = np.empty_like(ascending)
    values[order] = ascending
    return values.reshape(shape)
