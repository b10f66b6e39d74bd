"""One row of a bench: a method at a setting, what it took and how right it was."""

from dataclasses import dataclass, field
from math import nan

import numpy as np

from vibsim.evidence.benchmark.event_counts import EventCount

DONE, SLOWER, FAILED = 1, 2, 3
STATUS_FLAGS = {"done": DONE, "slower": SLOWER, "failed": FAILED}


@dataclass
class Row:
    """What came of one method at one setting.

    Attributes
    ----------
    method, setting : name of the family, entry of its ladder
    status : DONE; SLOWER where the time limit stopped it at t_reached; FAILED, then `problem` says how
    wall_time, cpu_time : of a run, the least of `runs`, which other processes disturb least [s]
    setup_time : before the first run, such as compiling [s]
    steps, evaluations : steps and right-hand sides of a run; -1 where there is no such number
    t_reached : time until which it ran [s]
    faithful_time : time until which the error is within 1e-3 m [s]
    error : of the displacements [m] at each instant compared, NaN from t_reached on
    events : counts up to faithful_time by kind, of the kinds that the method reports
    """

    method: str
    setting: str
    status: int
    problem: str = ""
    wall_time: float = nan
    cpu_time: float = nan
    setup_time: float = nan
    runs: int = 0
    steps: int = -1
    evaluations: int = -1
    t_reached: float = 0.0
    faithful_time: float = 0.0
    error: np.ndarray = field(default_factory=lambda: np.empty(0))
    events: dict[str, EventCount] = field(default_factory=dict)

    @property
    def time_per_second(self) -> float:
        """Processor time per second of motion [s/s]; NaN where nothing was run."""
        return self.cpu_time / self.t_reached if self.t_reached else nan

    def error_until(self, time: np.ndarray, t: float) -> float:
        """Largest error [m] at the instants `time` [s] up to `t`; NaN where the run ended before."""
        until = self.error[: np.searchsorted(time, t, side="right")]
        return float(until.max()) if len(until) else nan

    def counted(self) -> EventCount | None:
        """Events of all kinds that it reports; None for a row that failed."""
        if not self.events:
            return None
        counts = self.events.values()
        return EventCount(
            sum(c.found for c in counts), sum(c.missed for c in counts), sum(c.spurious for c in counts)
        )
