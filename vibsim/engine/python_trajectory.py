"""A run on the Python engine, in numbers of any kit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import inf, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.blocks import Block, Trajectory, Wishes
from vibsim.engine.columns import stored_before
from vibsim.engine.driver import Driver, EventRecord
from vibsim.engine.errors import State, Stopped
from vibsim.engine.ledger import ledger_totals, rigid_totals, totals_of
from vibsim.engine.modes.status import Status
from vibsim.engine.resume import Point
from vibsim.engine.tangent.bundle import TangentBundle, tangent_totals
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from typing_extensions import Unpack


SAMPLES, PIECES = 2048, 4096  # of the engine between two blocks
SECONDS = 0.1  # the same: Ctrl-C is heard there


class PythonTrajectory(Trajectory[N]):
    """A run on the Python engine, with numbers of `kit`; wishes: section, ledger and others of `Driver`."""

    engine = "python"

    def __init__(
        self, scene: Scene[N], kit: Kit[N], point: Point[N] | None = None, **wishes: Unpack[Wishes]
    ) -> None:
        super().__init__(scene)
        self.kit, self.driver = kit, Driver(scene, kit, point, **wishes)

    def blocks(self) -> Iterator[Block]:
        """Yield `Block`s until the run ends, one of them where it ends at its start."""
        ended = False
        while not ended:
            try:
                self.driver.run(PIECES, SAMPLES, SECONDS)
                ended = self.driver.finished
            except Stopped:
                ended = True
            yield self._block(*self.driver.take())

    def stop(self) -> None:
        """Have `blocks` end with what is computed, from any thread; at once where it decides what follows."""
        self.driver.automaton.departures.stopped.set()

    @property
    def extremes(self) -> tuple[list[float], list[float], list[float]]:
        """Least and greatest of every pair so far, and the smallest gap of every stop that is watched."""
        own = self.driver.extremes
        if own is None:
            return [], [], []
        least, greatest, margins = (self.kit.rounded(of) for of in (own.least, own.greatest, own.margins))
        return least, greatest, margins

    @property
    def left_out(self) -> list[tuple[float, float]]:
        """(time [s], distance [m] that ends of infinite sequences of impacts have left out from then on)."""
        rounded = (self.kit.rounded(list(end)) for end in self.driver.automaton.rigid.chatter.cut_off.ends)
        return [(t, distance) for t, distance in rounded]

    def _block(
        self,
        samples: Sequence[tuple[State[N], Status]],
        events: Sequence[EventRecord[N]],
        section: Sequence[State[N]],
        extremes: Sequence[tuple[N, ...]],
    ) -> Block:
        pairs = np.array([[kind, part] for kind, part, *_ in events], dtype="i2")
        kinds = pairs.astype("i1").reshape(-1, 2).T
        return self.block(
            self._states([state for state, _ in samples]),
            self._codes([status for _, status in samples]),
            np.vstack([self._states([one[2] for one in events], phase=True), self._before(events)]),
            np.vstack([kinds, self._codes([one[3] for one in events])]),
            self._section(section, extremes),
            self._reached(),
        )

    def _section(self, states: Sequence[State[N]], extremes: Sequence[tuple[N, ...]]) -> np.ndarray:
        """Rows of states, and behind them those of extremes where they are kept."""
        rows = self._states(states)
        if self.driver.extremes is None:
            return rows
        width = 2 * self.driver.extremes.count
        return np.vstack([rows, np.array(extremes, dtype="f8").reshape(-1, width).T])

    def _reached(self) -> tuple[float, float]:
        reached, worked_to = self.kit.rounded([self.driver.state.t, self.driver.worked_to])
        return reached, worked_to

    def _states(self, states: Iterable[State[N]], phase: bool = False) -> np.ndarray:
        rows = [self.kit.rounded(self._row(state, phase)) for state in states]
        width = 3 + 2 * len(self.scene.bodies) + phase
        return np.transpose(np.array(rows, dtype="f8").reshape(-1, width))

    def _row(self, s: State[N], phase: bool = False) -> tuple[N, ...]:
        """Numbers of the engine: time, x and v of each body, phi, phidot and phase."""
        moving = [value for pair in zip(s.x, s.v, strict=True) for value in pair]
        return (s.t, *moving, self.kit.unwind(s.phase, s.turns), s.w, *([s.phase] if phase else []))

    def _before(self, events: Sequence[EventRecord[N]]) -> np.ndarray:
        """Velocities of bodies and rotor in front of events, one row each; none where nothing is struck."""
        count = len(stored_before(self.scene))
        rows = [self.kit.rounded([*v, w])[:count] for *_, (v, w) in events]
        return np.transpose(np.array(rows, dtype="f8").reshape(len(events), count))

    def _codes(self, statuses: Sequence[Status]) -> np.ndarray:
        codes = np.array([status.codes for status in statuses], dtype="i1")
        return np.transpose(codes.reshape(len(statuses), len(self.parts)))

    @property
    def totals(self) -> dict[str, Any]:
        """Counts and margins so far, and the ledgers and exponents where they are kept, as doubles."""
        driver, certificate = self.driver, self.driver.flow.certificate
        margin = inf if certificate.margin == inf else self.kit.rounded([certificate.margin])[0]
        first_doubt, margin_time = self.kit.rounded([certificate.first_doubt, certificate.margin_time])
        totals = totals_of(
            driver.counts,
            (certificate.uncertified, first_doubt, margin, margin_time),
            (driver.flow.taylor.steps + driver.flow.closed.steps, driver.flow.closed.evaluations),
            nan if driver.first_violation is None else self.kit.rounded([driver.first_violation])[0],
        )
        cut = driver.automaton.rigid.chatter.cut_off
        left_out = self.kit.rounded([cut.time, cut.speed, cut.distance])
        totals |= rigid_totals(self.scene, driver.counts, left_out)
        if driver.ledger:
            where = driver.start, (driver.state, driver.status)
            ledger = ledger_totals(self.scene, self.kit, driver.ledger.names, driver.ledger.entries, *where)
            totals |= dict(zip(ledger, self.kit.rounded(list(ledger.values())), strict=True))
        if isinstance(driver.tangent, TangentBundle):
            totals |= tangent_totals(self.scene, self.kit, driver.tangent.entries(), margin, margin_time)
        return totals

    def state_at(self, times: Iterable[float]) -> dict[str, np.ndarray]:
        """States at ascending times before the next event, as columns."""
        states: list[State[N]] = []
        statuses: list[Status] = []
        for t in times:
            states.append(self.driver.state_at(self.kit.number(t)))
            statuses.append(self.driver.status)
        return self.columns_of(self._states(states), self._codes(statuses))
