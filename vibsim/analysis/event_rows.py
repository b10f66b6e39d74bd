"""The events of a span; of a file only their rows are read."""

import numpy as np

from vibsim.results.result import Result
from vibsim.results.windows import Window, rows_within


def events_within(result: Result, window: Window, *names: str, before: int = 0) -> dict[str, np.ndarray]:
    """Event columns by name (all without names) within the window [s], both ends included.

    before : how many events before the window to add, as far as there are any
    """
    rows = rows_within(result.event_column("t"), window)
    rows = slice(max(0, rows.start - before), rows.stop)
    return {name: np.asarray(result.event_column(name)[rows]) for name in names or result.events}
