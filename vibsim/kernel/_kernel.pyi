"""The C engine's functions, on memory that the caller owns; see module.c."""

from typing import Any

def run_size() -> int: ...
def start(
    run: bytearray,
    scene: Any,
    resume: Any,
    samples: Any,
    sample_modes: Any,
    events: Any,
    event_codes: Any,
    section: Any,
) -> tuple[int, int]: ...
def advance(
    run: bytearray, samples: Any, sample_modes: Any, events: Any, event_codes: Any, section: Any
) -> tuple[int, int, int, int, int]: ...
def state_at(run: bytearray, t: float) -> tuple[float, ...]: ...
def tally(run: bytearray) -> dict[str, Any]: ...
def growth(
    run: bytearray,
) -> tuple[int, int, tuple[float, ...], float, float, float, tuple[float, float, float, float]]: ...
