"""Runs of scenes made of parts: one contract, two engines that agree bit for bit on doubles.

trajectory = open_trajectory(scene, engine="auto")
for block in trajectory.blocks(): ...
trajectory.totals
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import inf, nan
from typing import TYPE_CHECKING, Any, Generic, TypedDict

import numpy as np

from vibsim.engine.choice import check_method, engine_name
from vibsim.engine.columns import (
    before_columns,
    event_columns,
    moving_columns,
    part_columns,
    sample_columns,
    section_columns,
)
from vibsim.engine.driver import Driver, Happening
from vibsim.engine.events.impacts.chatter import LOWEST
from vibsim.engine.extremes import Gap
from vibsim.engine.modes.status import LIFTED, Status
from vibsim.engine.modes.ties import Edge
from vibsim.engine.resume import Point, Row, resume_point
from vibsim.engine.state import State
from vibsim.engine.tangent.bundle.tangent_bundle import TangentBundle
from vibsim.engine.tangent.bundle.tangent_totals import tangent_totals
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.totals import ledger_totals, rigid_totals, totals_of
from vibsim.physics.arithmetic.numbers import Doubles, Kit, N
from vibsim.physics.modes import EVENT_KINDS, RIGID_KINDS
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from typing_extensions import Unpack

SAMPLES, PIECES = 2048, 4096  # of the Python engine between two blocks
SECONDS = 0.1  # the same: Ctrl-C is heard there
OFFSETS = {
    "contact_begin": "stops",
    "contact_end": "stops",
    "violation_begin": "clearances",
    "violation_end": "clearances",
    **dict.fromkeys(RIGID_KINDS, "stops"),
}


class Wishes(TypedDict, total=False):
    """What a run is to keep besides samples and events; see `open_trajectory`.

    tangent : number of disturbances, and from when their growth counts [s]
    extremes : columns of the pairs, the stops whose gaps are watched, since when [s]; lowest : see there
    """

    section: bool
    ledger: bool
    momentum: bool
    tangent: tuple[int, float]
    extremes: tuple[Sequence[Edge], Sequence[Gap], float] | None
    lowest: int


@dataclass(frozen=True)
class Block:
    """Samples, events and section by column name, 1-D arrays.

    section: time [s] and states at the ends of the periods, empty unless asked for. t_reached: time up to
    which the motion is known [s]; worked_to: time up to which all that goes with it is worked out, the
    ledger say [s]; within a long stretch without events that is further. extremes: least, then greatest of
    every pair in the period that each section point ends, (2 * pairs, points); empty unless asked for.
    """

    samples: dict[str, np.ndarray]
    events: dict[str, np.ndarray]
    section: dict[str, np.ndarray]
    t_reached: float
    worked_to: float
    extremes: np.ndarray


def open_trajectory(
    scene: Scene,
    engine: str = "auto",
    resume: Row | Sequence[Row] | None = None,
    section: bool = False,
    ledger: bool = False,
    momentum: bool = False,
    tangent: int = 0,
    tangent_from: float = 0.0,
    extremes: tuple[Sequence[Edge], float] | None = None,
    lowest: int = LOWEST,
) -> Trajectory:
    """A run of `scene` (a `vibsim.physics.parts.Scene`) from its start, not yet computed.

    Parameters
    ----------
    scene : Scene
    engine : "auto" (C where it was built, else Python), "c" or "python"
    resume : one stored event row (t, kind, part, states, phase, part states by name) to go on from, all rows
        of one instant in their order, or None
    section : whether the blocks carry the stroboscopic section, the state at the end of every period of what
        drives the scene
    ledger : whether the totals carry the energy ledger
    momentum : whether they carry the momentum ledger, and with it that of energy
    tangent : number of disturbances to carry along, for as many Lyapunov exponents in the totals
    tangent_from : time [s] from which their growth counts
    extremes : (pairs of ends P, Q as of a part, time [s] from which on), or None. Least and greatest
        x_P - x_Q of each pair, then of the rotor's speed, exact to rounding: by period in the blocks, where
        they carry the section, and of all in `extremes` of the object returned, with the smallest gap at a
        turn without contact of each stop between the ends of a pair
    lowest : height of the hops under friction with which a sequence of impacts ends, in roundings of
        displacements

    Returns an object with `engine`, `blocks()` (an iterator of `Block`s; raises EngineError when the run
    fails) and `totals`. Raises ValueError for another engine or method, a row that no run has or more
    disturbances than the scene has directions, RuntimeError for "c" where it was not built.
    """
    check_method(scene)
    check_tangent(scene, tangent)
    wishes: Wishes = {
        "section": section,
        "ledger": ledger,
        "momentum": momentum,
        "tangent": (tangent, tangent_from),
        "extremes": extremes_of(scene, *extremes) if extremes else None,
        "lowest": lowest,
    }
    point = None if resume is None else resume_point(scene, resume)
    if engine_name(engine) == "python":
        return PythonTrajectory(scene, Doubles, point, **wishes)
    return CTrajectory(scene, point, **wishes)


def extremes_of(scene: Scene, ends: Sequence[Edge], since: float) -> tuple[list[Edge], list[Gap], float]:
    """What `Extremes` is told: columns of the pairs, the stops whose gap is told by one of them, the time."""
    pairs = [(scene.column(P), scene.column(Q)) for P, Q in ends]
    gaps: list[Gap] = []
    for i, stop in enumerate(scene.stops):
        P, Q = scene.column(stop.P), scene.column(stop.Q)
        if (P, Q) in pairs:
            gaps.append((i, pairs.index((P, Q)), stop.sense, stop.gap))
        elif (Q, P) in pairs:
            gaps.append((i, pairs.index((Q, P)), -stop.sense, stop.gap))
    return pairs, gaps, since


def state_at(
    scene: Scene, row: Row | Sequence[Row], times: Iterable[float], engine: str = "auto"
) -> dict[str, np.ndarray]:
    """States at `times` [s], restarted from the stored event `row`.

    row: as `resume` of `open_trajectory`; times: ascending, from row["t"] to before the next event. Returns
    arrays by column name.
    """
    return open_trajectory(scene, engine, resume=row).state_at(times)


def check_tangent(scene: Scene, tangent: int) -> None:
    """Raises ValueError where the scene has not so many directions."""
    if not 0 <= tangent <= dimension(scene):
        raise ValueError(f"tangent must be 0 to {dimension(scene)} for this scene, got {tangent}")


class Trajectory(Generic[N]):
    """What both engines share: how rows of numbers become columns by name."""

    engine = ""

    def __init__(self, scene: Scene[N]) -> None:
        self.scene = scene
        self.names, self.event_names = sample_columns(scene), event_columns(scene)
        self.timed_states, self.parts = section_columns(scene), part_columns(scene)
        self.states_happened = "t", *moving_columns(scene), "phase", *before_columns(scene)
        self.first_part = part_offsets(scene)

    def blocks(self) -> Iterator[Block]:
        """Yield `Block`s until the run ends; raises EngineError when it fails."""
        raise NotImplementedError

    @property
    def totals(self) -> dict[str, Any]:
        """Counts and margins so far, and the ledgers and exponents where they are kept, as doubles."""
        raise NotImplementedError

    @property
    def left_out(self) -> list[tuple[float, float]]:
        """(time [s], distance [m] that ends of infinite sequences of impacts have left out from then on)."""
        raise NotImplementedError

    @property
    def extremes(self) -> tuple[list[float], list[float], list[float]]:
        """Least and greatest of every pair so far, and the smallest gap of every stop that is watched."""
        raise NotImplementedError

    def state_at(self, times: Iterable[float]) -> dict[str, np.ndarray]:
        """States at ascending times before the next event, as columns."""
        raise NotImplementedError

    def block(
        self,
        samples: np.ndarray,
        sample_codes: np.ndarray,
        events: np.ndarray,
        event_codes: np.ndarray,
        section: np.ndarray,
        reached: tuple[float, float],
    ) -> Block:
        """A block from rows: (time, states), part states; (t, states, phase, velocities before), (kind, part,
        part states); (time, states); (time reached, time worked out to).
        """
        table = dict(zip(self.timed_states, samples, strict=False))
        table |= dict(zip(self.parts, sample_codes, strict=True))
        happened = dict(zip(self.states_happened, events, strict=False))
        happened |= {"kind": event_codes[0], "part": self._parts(event_codes[0], event_codes[1])}
        happened |= dict(zip(self.parts, event_codes[2:], strict=True))
        width = 3 + 2 * len(self.scene.bodies)  # of a state
        return Block(
            {name: table[name] for name in self.names},
            {name: happened[name] for name in self.event_names},
            dict(zip(self.timed_states, section, strict=False)),
            reached[0],
            reached[1],
            section[width:],
        )

    def columns_of(self, states: np.ndarray, codes: Iterable[Any]) -> dict[str, np.ndarray]:
        """Columns by name of rows (time, states) and part states: one for all rows, or one for each."""
        table = dict(zip(self.timed_states, states, strict=False))
        for name, code in zip(self.parts, codes, strict=True):
            table[name] = np.full(states.shape[1], code, dtype="i1")
        return {name: table[name] for name in self.names}

    def _parts(self, kinds: np.ndarray, parts: np.ndarray) -> np.ndarray:
        """Index among `part_columns`, from the index among parts of its sort; -1 for none.

        Engines give bytes; read without a sign they number 255 parts of a sort, and -1 is the last number.
        """
        numbers = parts.view("u1").astype("i2")
        return np.where(parts == -1, -1, numbers + self.first_part[kinds]).astype("i2")


def part_offsets(scene: Scene[N]) -> np.ndarray:
    """By kind of event: index among `part_columns` of the first part of its sort."""
    first = {"stops": 0, "frictions": len(scene.stops)}
    first["clearances"] = first["frictions"] + len(scene.frictions)
    return np.array([first[OFFSETS.get(kind, "frictions")] for kind in EVENT_KINDS])


class PythonTrajectory(Trajectory[N]):
    """A run on the Python engine, with numbers of `kit`; wishes: section, ledger and others of `Driver`."""

    engine = "python"

    def __init__(
        self, scene: Scene[N], kit: Kit[N], point: Point[N] | None = None, **wishes: Unpack[Wishes]
    ) -> None:
        super().__init__(scene)
        self.kit, self.driver = kit, Driver(scene, kit, point, **wishes)

    def blocks(self) -> Iterator[Block]:
        """Yield `Block`s until the run ends."""
        while True:
            self.driver.run(PIECES, SAMPLES, SECONDS)
            yield self._block(*self.driver.take())
            if self.driver.finished:
                return

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
        events: Sequence[Happening[N]],
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
        return np.array(rows, dtype="f8").reshape(-1, width).T

    def _row(self, s: State[N], phase: bool = False) -> tuple[N, ...]:
        """Numbers of the engine: time, x and v of each body, phi, phidot and phase."""
        moving = [value for pair in zip(s.x, s.v, strict=True) for value in pair]
        return (s.t, *moving, self.kit.unwind(s.phase, s.turns), s.w, *([s.phase] if phase else []))

    def _before(self, events: Sequence[Happening[N]]) -> np.ndarray:
        """Velocities of bodies and rotor in front of events, one row each; none where nothing is struck."""
        count = len(before_columns(self.scene))
        rows = [self.kit.rounded([*v, w])[:count] for *_, (v, w) in events]
        return np.array(rows, dtype="f8").reshape(len(events), count).T

    def _codes(self, statuses: Sequence[Status]) -> np.ndarray:
        parts = len(self.parts)
        return np.array([status.codes for status in statuses], dtype="i1").reshape(len(statuses), parts).T

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


class CTrajectory(Trajectory[float]):
    """A run on the C engine; wishes: section, ledger and others of `CRun`."""

    engine = "c"

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
        return self.run.automaton.rigid.chatter.cut_off.ends

    def blocks(self) -> Iterator[Block]:
        """Yield `Block`s until the run ends; raises EngineError when it fails."""
        for rows in self.run.blocks():
            yield self.block(*rows)

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
        if self.run.meters:
            now = State(*tally["state"]), self.run.statuses[tally["mode"]]
            where = self.run.first, now
            totals |= ledger_totals(self.scene, Doubles, self.run.meters.names, tally["entries"], *where)
        cut = self.run.automaton.rigid.chatter.cut_off
        totals |= rigid_totals(self.scene, tally["counts"], (cut.time, cut.speed, cut.distance))
        if self.run.moving:
            _, _, margin, margin_time = tally["certificate"]
            totals |= tangent_totals(self.scene, Doubles, self.run.disturbances, margin, margin_time)
        return totals

    def state_at(self, times: Iterable[float]) -> dict[str, np.ndarray]:
        """States at ascending times before the next event, as columns.

        A lifted stop opens without a record, and where a row does not tell every zero of its instant an event
        may come once more: what follows an event is Python's.
        """
        times = list(times)
        rows = [] if self.point is not None and LIFTED in self.point[1].stops else self._rows_at(times)
        if len(rows) < len(times):
            return PythonTrajectory(self.scene, Doubles, self.point).state_at(times)
        width = 3 + 2 * len(self.scene.bodies)
        table = np.array(rows, dtype="f8").reshape(-1, width).T
        return self.columns_of(table, self.run.statuses[self.run.tally["mode"]].codes)

    def _rows_at(self, times: Iterable[float]) -> list[tuple[float, ...]]:
        """(time, states) at ascending times, up to the first event."""
        rows: list[tuple[float, ...]] = []
        for t in times:
            row = self.run.state_at(t)
            if row is None:
                break
            rows.append(row)
        return rows
