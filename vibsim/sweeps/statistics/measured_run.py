"""One run of a scene for its statistics: first the transient, without output, then the rest.

A run resumed from a stored event goes on bit for bit as the uninterrupted one. So the transient is run
without samples up to its end, and the part that counts begins at the last event before that.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibsim.engine.columns import section_columns
from vibsim.engine.resume import Row, rows_of_instant
from vibsim.engine.trajectories.blocks import Block
from vibsim.engine.trajectory import open_trajectory, state_at
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene
from vibsim.sweeps.statistics.quantities import Quantities

SUMMED = ("impacts", "sticks", "events", "uncertified")


class GivenUpError(Exception):
    """The run was given up because nobody wants it any more."""


class MeasuredRun:
    """A run of `scene`: its blocks from about the time `begin` [s] on, with stroboscopic points.

    `totals` are those of the whole run, up to date after the last block; `late` those of the blocks that were
    shown, which begin with the events `rows` of one instant (None: with the run), with the energy ledger if
    that is wanted.
    `extremes` are least and greatest displacements and smallest gaps of the time from `begin` on, see
    `vibsim.engine.extremes`, of the motions that are measured.
    `watch_transient` is shown the blocks of the transient, which have no samples. `go_on` is asked before
    every block, those of the transient too; where it says False, GivenUpError is raised.
    """

    def __init__(
        self,
        scene: Scene,
        of: Quantities,
        begin: float,
        engine: str,
        go_on: Callable[[], bool] | None = None,
        ledger: bool = False,
        watch_transient: Callable[[Block], None] | None = None,
    ):
        self.scene, self.of, self.begin = scene, of, begin
        self.engine, self.ledger = engine, ledger
        self._go_on, self._watch_transient = go_on, watch_transient
        self.totals: dict[str, float] = dict.fromkeys(SUMMED, 0.0) | {"grazing_margin": math.nan}
        self.late: dict[str, Any] = {}
        self.extremes: tuple[Sequence[float], Sequence[float], Sequence[float]] = ([], [], [])
        self.rows: list[Row] | None = None
        self.t_reached = 0.0
        self._start: list[Row] = []  # the first event of the run
        self._last: Row = {}  # the last event so far

    def blocks(self) -> Iterator[Block]:
        """The blocks from the last event before `begin` on; none where the run ended before."""
        self.rows = self._transient() if self.begin > 0 else None
        if self.t_reached < self.begin:
            return
        ends = [(motion.P, motion.Q) for motion in self.of.motions]
        trajectory = open_trajectory(
            self.scene,
            self.engine,
            self.rows,
            section=True,
            ledger=self.ledger,
            extremes=(ends, self.begin),
        )
        yield from self._asked(trajectory)
        self.late, self.extremes = trajectory.totals, trajectory.extremes
        self._add(self.late)

    def ends(self) -> dict[str, np.ndarray]:
        """Time and states at `begin` and at the end of the run, each (2)."""
        times = np.array([self.begin, self.t_reached])
        states = state_at(self.scene, self.rows or self._start, times[:1], self.engine)
        return {name: np.array([states[name][0], self._last[name]]) for name in section_columns(self.scene)}

    def _transient(self) -> list[Row] | None:
        """Run up to `begin`; the rows of the last instant of events."""
        scene = replace(self.scene, t_end=self.begin).without_samples()
        watch = self._watch_transient
        trajectory = open_trajectory(scene, self.engine, section=watch is not None)
        rows: list[Row] | None = None
        for block in self._asked(trajectory):
            if watch is not None:
                watch(block)
            before = np.flatnonzero(block.events["kind"] != EVENT_KINDS["end"])
            if len(before):
                rows = rows_of_instant(block.events, int(before[-1]), rows or ())
        self._add(trajectory.totals)
        return rows

    def ask(self) -> None:
        """Raise GivenUpError where nobody wants the run any more; for those who run more of it themselves."""
        if self._go_on is not None and not self._go_on():
            raise GivenUpError

    def _asked(self, trajectory: Any) -> Iterator[Block]:
        for block in trajectory.blocks():
            self.ask()
            self.t_reached = block.t_reached
            if len(block.events["t"]):
                last = {name: column[-1] for name, column in block.events.items()}
                self._last = {**last, "time": last["t"]}
                self._start = self._start or [{name: column[0] for name, column in block.events.items()}]
            yield block

    def _add(self, totals: dict[str, Any]) -> None:
        for name in SUMMED:
            self.totals[name] += float(totals[name])
        margins = [self.totals["grazing_margin"], float(totals["grazing_margin"])]
        self.totals["grazing_margin"] = min((m for m in margins if not math.isnan(m)), default=math.nan)
