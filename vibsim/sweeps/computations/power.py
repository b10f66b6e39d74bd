"""Where the power goes: what the source gives on the average, and what damper, friction and storage take.

From the energy ledger of the engine, over the whole periods after the transient; so source = damper +
friction + storage, to round-off (first law).
"""

import math
from dataclasses import replace
from typing import Any

from vibsim.engine.resume import rows_of_instant
from vibsim.engine.trajectory import Block, open_trajectory
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.sweeps.statistics.columns import Column
from vibsim.sweeps.statistics.measured_run import MeasuredRun

TITLE = "mean power of the source, and where it goes"
_SPAN = "over the whole periods after the transient"
COLUMNS = {
    "power_source": Column("W", f"mean power that the source gives, {_SPAN}", "source"),
    "power_damper": Column("W", f"mean power that the damper takes, {_SPAN}", "source"),
    "power_friction": Column("W", f"mean power that friction takes, {_SPAN}", "source"),
    "power_stored": Column("W", f"mean rate at which the stored energy grows, {_SPAN}", "source"),
}

Rows = list[dict[str, Any]]
Entries = tuple[float, ...]  # energy given, taken by the damper, by friction, stored [J]


class Power:
    """Mean powers [W] of one run."""

    def __init__(self, scene: TwoBlocks, begin: float, section: int):
        self._scene = scene
        self._last: Rows | None = None  # of events of one instant
        self._before_period_end: Rows | None = None  # events that the last period's end follows on

    def update(self, block: Block) -> None:
        """Remember the last event before the last stroboscopic point; the engine keeps the ledger."""
        times, marks = block.events["t"], block.section["time"]
        if len(marks):
            before = times.searchsorted(marks[-1], side="right")
            self._before_period_end = self._rows(block, before - 1) if before else self._last
        if len(times):
            self._last = self._rows(block, len(times) - 1)

    def _rows(self, block: Block, at: int) -> Rows:
        return rows_of_instant(block.events, at, self._last or ())

    def values(
        self, window: tuple[float, float], run: MeasuredRun, found: dict[str, Any]
    ) -> dict[str, float]:
        """Changes of the ledger's entries within the window, by its length; nothing of one without length.

        The ledger begins at the events `run.rows` and ends with the run. What lies outside the window, from
        that event to the first period and from the last one on, is run once more and taken off.
        """
        first, last = window
        if not last > first:
            return {}
        sums = _less(_entries(run.late), self._ledger(run, run.rows, first))
        if last < run.t_reached:
            behind = [self._ledger(run, self._before_period_end, t) for t in (last, run.t_reached)]
            sums = _less(sums, _less(behind[1], behind[0]))
        names = ("power_source", "power_damper", "power_friction", "power_stored")
        return {name: entry / (last - first) for name, entry in zip(names, sums, strict=True)}

    def _ledger(self, run: MeasuredRun, rows: Rows | None, t_end: float) -> Entries:
        """The ledger from an instant of events to a later time [s], which is as the run itself had it."""
        rarely = 2 * math.ceil(self._scene.t_end)
        quiet = replace(self._scene.as_parts(), t_end=t_end, every_num=rarely, every_den=1)
        trajectory = open_trajectory(quiet, run.engine, resume=rows, ledger=True)
        for _ in trajectory.blocks():
            run.ask()
        return _entries(trajectory.totals)


def _entries(totals: dict[str, Any]) -> Entries:
    stored = totals["energy_end"] - totals["energy_start"]
    return totals["work_source"], totals["loss_viscous"], totals["loss_friction"], stored


def _less(sums: Entries, others: Entries) -> Entries:
    return tuple(ours - theirs for ours, theirs in zip(sums, others, strict=True))
