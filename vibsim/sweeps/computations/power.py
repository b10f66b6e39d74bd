"""Where the power goes: what sources give on the average, and what dampers, friction and storage take.

From the energy ledger of the engine, over the whole periods after the transient; so what is given = what is
taken, to round-off (first law). In a scene of named parts each force, damper, stop, friction and belt has a
column of its own beside the sums.
"""

from dataclasses import replace
from typing import Any

from vibsim.engine.resume import Row, rows_of_instant
from vibsim.engine.trajectories.blocks import Block
from vibsim.engine.trajectory import open_trajectory
from vibsim.files.declarations import Column
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

TITLE = "mean power of the sources, and where it goes"
_SPAN = "over the whole periods after the transient"
SUMS = {  # column -> total of the ledger
    "power_source": "work_source",
    "power_base": "work_base",
    "power_belts": "work_belt",
    "power_damper": "loss_viscous",
    "power_stops": "loss_stops",
    "power_friction": "loss_friction",
}
WORDS = {
    "power_source": "mean power that forces and motor give",
    "power_base": "mean power that the moving base gives",
    "power_belts": "mean power that belts give",
    "power_damper": "mean power that the dampers of links take",
    "power_stops": "mean power that stops take",
    "power_friction": "mean power that friction takes",
}
STORED = Column("W", f"mean rate at which the stored energy grows, {_SPAN}")

Rows = list[Row]


def columns(of: Quantities) -> Columns:
    """Sums and, in a scene of named parts, the power of each part; none without a source."""
    if not of.is_powered:
        return {}
    if not of.of_parts:
        return {
            "power_source": Column("W", f"mean power that the source gives, {_SPAN}"),
            "power_damper": Column("W", f"mean power that the damper takes, {_SPAN}"),
            "power_friction": Column("W", f"mean power that friction takes, {_SPAN}"),
            "power_stored": STORED,
        }
    sums = {name: Column("W", f"{words}, {_SPAN}") for name, words in WORDS.items()}
    each = {name: Column("W", f"{words}, {_SPAN}") for name, (_, words) in of.powers.items()}
    return {**sums, "power_stored": STORED, **each}


class Power:
    """Mean powers [W] of one run."""

    def __init__(self, task: Task):
        self._scene = task.scene
        self._entries = {**SUMS, **{name: entry for name, (entry, _) in task.of.powers.items()}}
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
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """Changes of the ledger's entries within the window, by its length; nothing of one without length.

        The ledger begins at the events `run.rows` and ends with the run. What lies outside the window, from
        that event to the first period and from the last one on, is run once more and taken off.
        """
        first, last = window
        if not last > first:
            return {}
        sums = _less(self._energies(run.late), self._ledger(run, run.rows, first))
        if last < run.t_reached:
            behind = [self._ledger(run, self._before_period_end, t) for t in (last, run.t_reached)]
            sums = _less(sums, _less(behind[1], behind[0]))
        return {name: energy / (last - first) for name, energy in sums.items()}

    def _ledger(self, run: MeasuredRun, rows: Rows | None, t_end: float) -> dict[str, float]:
        """The ledger from an instant of events to a later time [s], which is as the run itself had it."""
        quiet = replace(self._scene, t_end=t_end).without_samples()
        trajectory = open_trajectory(quiet, run.engine, resume=rows, ledger=True)
        for _ in trajectory.blocks():
            run.ask()
        return self._energies(trajectory.totals)

    def _energies(self, totals: dict[str, Any]) -> dict[str, float]:
        """Energies [J] by column; a part that is not in the scene, as friction with mu = 0, has none."""
        stored = totals["energy_end"] - totals["energy_start"]
        return {"power_stored": stored, **{name: totals.get(at, 0.0) for name, at in self._entries.items()}}


def _less(energies: dict[str, float], others: dict[str, float]) -> dict[str, float]:
    return {name: value - others[name] for name, value in energies.items()}
