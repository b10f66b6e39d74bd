"""A run on the C engine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.blocks import Block, Trajectory, Wishes, by_name
from vibsim.engine.errors import State
from vibsim.engine.ledger import ledger_totals, rigid_totals, totals_of
from vibsim.engine.resume import Point
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from typing_extensions import Unpack


class CTrajectory(Trajectory[float]):
    """A run on the C engine; wishes: section, ledger and others of `CRun`."""

    def __init__(self, scene: Scene, point: Point | None = None, **wishes: Unpack[Wishes]) -> None:
        super().__init__(scene)
        from vibsim.engine.c_engine import CRun

        self.point = point
        self.run = CRun(scene, point, **wishes)

    @property
    def extremes(self) -> tuple[list[float], list[float], list[float]]:
        """Least and greatest of every pair so far, and the smallest gap of every stop that is watched."""
        return self.run.run.extremes()

    @property
    def left_out(self) -> list[tuple[float, float]]:
        """(time [s], distance [m] that ends of infinite sequences of impacts have left out from then on)."""
        return self.run.automaton.rigid.chatter.cut_off.ends if self.scene.rigid_stops else []

    def restart(self, scene: Scene) -> None:
        """Begin anew from the start of another scene, see `Trajectory.restart`."""
        self.scene, self.point = scene, None
        self.run.begin_anew(scene)

    def pause_at(self, time: float) -> None:
        """Have the block end with which the run reaches a time [s]."""
        self.run.run.pause_at(time)

    @property
    def at_begin(self) -> dict[str, np.ndarray]:
        """Time and state from which samples are recorded, as columns of one."""
        row = self.run.form.empty(3 + 2 * self.run.n, 1)
        self.run.run.at_begin(row)
        return by_name(self.timed_states, row)

    def blocks(self) -> Iterator[Block]:
        """Yield `Block`s until the run ends; raises EngineError when it fails."""
        for rows in self.run.blocks():
            yield self.block(*rows)

    def stop(self) -> None:
        """Have `blocks` end with what is computed, from any thread; at once where it decides what follows."""
        self.run.stopped.set()

    @property
    def totals(self) -> dict[str, Any]:
        """Counts and margins so far, and the ledgers and exponents where they are kept."""
        tally = self.run.tally
        totals = totals_of(
            tally["counts"],
            tally["certificate"],
            (tally["steps"], tally["evaluations"]),
            tally["first_violation"] if tally["violated_once"] else nan,
        )
        if self.run.integrals:
            now = self.run.left_at or State(*tally["state"]), self.run.statuses[tally["mode"]]
            where = self.run.first, now
            totals |= ledger_totals(self.scene, Doubles, self.run.integrals.names, tally["entries"], *where)
        if self.scene.rigid_stops:
            cut = self.run.automaton.rigid.chatter.cut_off
            totals |= rigid_totals(self.scene, tally["counts"], (cut.time, cut.speed, cut.distance))
        if self.run.moving:
            from vibsim.engine.tangent.tangencies import tangent_totals

            _, _, margin, margin_time = tally["certificate"]
            totals |= tangent_totals(self.scene, Doubles, self.run.disturbances, margin, margin_time)
        return totals

    def state_at(self, times: Iterable[float]) -> dict[str, np.ndarray]:
        """States at ascending times [s] as columns; events on the way are taken."""
        return self.columns_of(*self.run.states_at(list(times)))
