"""Whether the motor was captured, and when: the verdict of `vibsim.analysis.capture` on the whole run."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.physics.modes import EVENT_KINDS, IMPACTS
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

if TYPE_CHECKING:
    from vibsim.analysis.capture import Capture

TITLE = "verdict on capture, with times"
VERDICTS = {"undecided": 0, "not met": 1, "passed": 2, "escaped": 3, "captured": 4}


def columns(of: Quantities) -> Columns:
    """Verdict, times and speeds; none without a motor."""
    if not of.has_motor:
        return {}
    return {
        "capture": Column("1", "verdict on capture, from the whole run", flags=VERDICTS),
        "capture_since": Column("s", "begin of the hold that decides the verdict"),
        "capture_until": Column("s", "its end; NaN where it lasts to the end of the run"),
        "capture_speed": Column("Hz", "mean speed over it"),
        "passage_time": Column("s", "when the mean speed last rose through a resonance"),
        "final_speed": Column("Hz", "mean speed over the last turns of the run"),
    }


class CaptureVerdict:
    """Verdict on one run of a motor. Memory grows with its turns and impacts."""

    def __init__(self, task: Task):
        self._scene = task.scene
        self._early: list[Block] = []
        self._late: list[Block] = []

    def transient(self, block: Block) -> None:
        """Take the next block of the transient."""
        self._early.append(_thinned(block))

    def update(self, block: Block) -> None:
        """Take the next block of the rest, which begins with the last event in the transient."""
        self._late.append(_thinned(block))

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The verdict and its times; NaN where there is none."""
        from vibsim.analysis.capture import capture_of_turns
        from vibsim.analysis.span import Span

        resumed = run.rows[-1]["t"] if run.rows else 0.0
        turns, impacts = (self._joined(table, resumed) for table in ("section", "events"))
        return _numbers(capture_of_turns(turns, impacts, self._scene, Span(0.0, run.t_reached)))

    def _joined(self, table: str, resumed: float) -> np.ndarray:
        """Times of the whole run: those of the transient up to where the rest goes on from, then the rest."""
        early = np.concatenate([[], *(getattr(block, table)["time"] for block in self._early)])
        late = [getattr(block, table)["time"] for block in self._late]
        return np.concatenate([early[early <= resumed], *late])


def _thinned(block: Block) -> Block:
    """What the verdict needs: the times of the turns and of the impacts."""
    begun = np.isin(block.events["kind"], [EVENT_KINDS[kind] for kind in IMPACTS])
    events, section = {"time": block.events["t"][begun]}, {"time": block.section["time"]}
    return replace(block, samples={}, events=events, section=section)


def _numbers(capture: "Capture") -> dict[str, float]:
    """The verdict as numbers by column."""
    last = max((passage.time for passage in capture.passages), default=math.nan)
    numbers = {
        "capture_since": capture.since,
        "capture_until": capture.until,
        "capture_speed": capture.speed_hz,
        "passage_time": last,
        "final_speed": capture.final_speed_hz,
    }
    known = {name: float(value) for name, value in numbers.items() if value is not None}
    return {"capture": float(VERDICTS[capture.verdict]), **known}
