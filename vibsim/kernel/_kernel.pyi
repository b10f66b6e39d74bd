"""The C engine's functions; see module.c. A run is a capsule: `start` makes it."""

from typing import Any

Run = Any

def start(
    scene: Any,
    resume: Any,
    samples: Any,
    sample_modes: Any,
    events: Any,
    event_codes: Any,
    section: Any,
) -> tuple[Run, int, int]: ...
def advance(
    run: Run, samples: Any, sample_modes: Any, events: Any, event_codes: Any, section: Any
) -> tuple[int, int, int, int, int]: ...
def state_at(run: Run, t: float) -> tuple[float, ...] | None: ...
def tally(run: Run) -> dict[str, Any]: ...
def growth(
    run: Run,
) -> tuple[int, int, tuple[float, ...], float, float, float, tuple[float, float, float, float]]: ...
