"""One run of a scene for its statistics: first the transient, without output, then the rest.

A run resumed from a stored event goes on bit for bit as the uninterrupted one. So the transient is run
without samples up to its end, and the part that counts begins at the last event before that.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from vibsim.engine.resume import rows_of_instant
from vibsim.engine.trajectory import Block, open_trajectory
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.two_blocks import TwoBlocks

Row = dict[str, Any]
SUMMED = ("impacts", "sticks", "events", "uncertified")


class GivenUpError(Exception):
    """The run was given up because nobody wants it any more."""


class MeasuredRun:
    """A run of `scene`: its blocks from about the time `begin` [s] on, with stroboscopic points.

    `totals` are those of the whole run, up to date after the last block; `late` those of the blocks that were
    shown, which begin with the events `rows` of one instant (None: with the run), with the energy ledger if
    that is wanted.
    `watch_transient` is shown the blocks of the transient, which have no samples. `go_on` is asked before
    every block, those of the transient too; where it says False, GivenUpError is raised.
    """

    def __init__(
        self,
        scene: TwoBlocks,
        begin: float,
        engine: str,
        go_on: Callable[[], bool] | None = None,
        ledger: bool = False,
        watch_transient: Callable[[Block], None] | None = None,
    ):
        self.scene, self.begin, self.engine, self.ledger = scene, begin, engine, ledger
        self._go_on, self._watch_transient = go_on, watch_transient
        self.totals: dict[str, float] = dict.fromkeys(SUMMED, 0.0) | {"grazing_margin": math.nan}
        self.late: dict[str, Any] = {}
        self.rows: list[Row] | None = None
        self.t_reached = 0.0

    def blocks(self) -> Iterator[Block]:
        """The blocks from the last event before `begin` on; none where the run ended before."""
        self.rows = self._transient() if self.begin > 0 else None
        if self.t_reached < self.begin:
            return
        parts = self.scene.as_parts()
        trajectory = open_trajectory(parts, self.engine, self.rows, section=True, ledger=self.ledger)
        yield from self._asked(trajectory)
        self.late = trajectory.totals
        self._add(self.late)

    def _transient(self) -> list[Row] | None:
        """Run up to `begin`; the rows of the last instant of events."""
        long = 2 * math.ceil(self.scene.t_end)
        scene = replace(self.scene, t_end=self.begin, every_num=long, every_den=1)
        watch = self._watch_transient
        trajectory = open_trajectory(scene.as_parts(), self.engine, section=watch is not None)
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
            yield block

    def _add(self, totals: dict[str, Any]) -> None:
        for name in SUMMED:
            self.totals[name] += float(totals[name])
        margins = [self.totals["grazing_margin"], float(totals["grazing_margin"])]
        self.totals["grazing_margin"] = min((m for m in margins if not math.isnan(m)), default=math.nan)
