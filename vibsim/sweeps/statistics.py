"""Statistics of one run, taken stretch by stretch: what a sweep stores per point."""

import math
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from itertools import starmap
from operator import add, itemgetter
from typing import Any, Protocol

import numpy as np

from vibsim.cases.validation import MOST_SAMPLES
from vibsim.engine.blocks import Block
from vibsim.engine.columns import of_kinds, part_columns, section_columns, stop_column
from vibsim.engine.resume import Row, rows_of_instant
from vibsim.engine.trajectory import Trajectory, open_trajectory, suits_lanes
from vibsim.physics.elementary import dot, mean
from vibsim.physics.parts import BASE, BODY, EVENT_KINDS, GROUND, IMPACTS, Link, Scene, Stop, columns_of
from vibsim.physics.rates import (
    fastest_of_formulas,
    has_section,
    mobility,
    of_parts_alone,
    source_rates,
    spins,
)
from vibsim.results.columns import base_motion
from vibsim.sweeps.quantities import MeasuredMotion, Quantities

States = Mapping[str, np.ndarray]  # time [s] and the states by name, each (n)

# One run of a scene for its statistics: the transient, of which nothing is recorded but events, and the rest.
#
# What counts is shown from the last event of the transient on, which stands as a start. A run is kept for the
# next point in the same thread: where that differs in numbers alone, C has most of what it is to know.


COUNTED_IN_ALL = ("impacts", "sticks", "events", "uncertified", "grazing_margin")
START = {"kind": EVENT_KINDS["start"], "part": -1}
BEFORE = "before_"  # of velocities in front of an event, which impacts on rigid stops change


class _KeptRuns(threading.local):
    """The runs of a thread that came to their ends, with their settings."""

    def __init__(self) -> None:
        self.runs: list[tuple[Any, Trajectory]] = []


_kept = _KeptRuns()


class GivenUpError(Exception):
    """The run was given up because nobody wants it any more."""


class EarlyEnd(Protocol):
    """A condition that ends a run before its transient is over.

    stages : ascending times [s], the last one the end of the transient, at which it is asked
    """

    stages: list[float]

    def take(self, block: Block) -> None:
        """Take the next block, which may reach beyond the next stage."""

    def is_sure(self, stage: float) -> bool:
        """Whether the run can end, as far as it has come by a stage [s]."""


class MeasuredRun:
    """A run of `scene`: its blocks from about the time `begin` [s] on, with stroboscopic points.

    `totals` are those of the whole run, up to date after the last block. `extremes` are least and greatest
    displacements and smallest gaps of the time from `begin` on, see `extremes.c`, of the motions that are
    measured.
    `begun` is the run of the engine. `watch_transient` is shown the blocks of the transient, which have no
    samples, and `early` may end the run there. `go_on` is asked before every block, those of the transient
    too; where it says False, GivenUpError is raised.
    """

    def __init__(
        self,
        scene: Scene,
        of: Quantities,
        begin: float,
        go_on: Callable[[], bool] | None = None,
        watch_transient: Callable[[Block], None] | None = None,
        early: EarlyEnd | None = None,
    ):
        self.scene, self.of, self.begin = scene, of, begin
        self._go_on, self._watch_transient, self._early = go_on, watch_transient, early
        self.totals: dict[str, float] = {}
        self.extremes: tuple[Sequence[float], Sequence[float], Sequence[float]] = ([], [], [])
        self.t_reached = 0.0
        self._instant: tuple[Mapping[str, np.ndarray], int, Sequence[Row]] | None = None
        self._last: Mapping[str, np.ndarray] = {}  # events of the last block that has some
        self._at_begin: dict[str, np.ndarray] = {}
        self.begun: Trajectory | None = None
        self.suits_lanes = suits_lanes(scene)
        self._held: Iterable[Block] | None = None
        ends = [(motion.P, motion.Q) for motion in of.motions]
        self._settings = ends, begin, watch_transient is not None or early is not None

    def hold(self) -> bool:
        """Compute a short run and keep it apart, so that the engine can begin others before `blocks` is asked
        for; whether it is one.
        """
        if self._early or self._watch_transient or self.suits_lanes:
            return False
        trajectory = self.begun = self._trajectory()
        trajectory.pause_at(math.inf)
        rows = trajectory.whole()
        if rows is None:
            return False
        self.t_reached, _ = rows[-1]
        self._held = starmap(trajectory.columns.block, [rows])
        self._end(trajectory)
        self.begun = None
        _kept.runs.append((self._settings, trajectory))
        self.ask()
        return True

    def blocks(self) -> Iterator[Block]:
        """The blocks from the last event before `begin` on; none where the run ended before."""
        return filter(None, self.blocks_beside())

    def blocks_beside(self) -> Iterator[Block | None]:
        """The same, with None wherever the run `begun` can be computed beside others that suit lanes."""
        shown = self.begin == 0
        for block in self._held or self._computed():
            if block is None:
                yield None
                continue
            if len(block.events["t"]):
                self._last = block.events
            if shown:
                yield block
                continue
            if self._watch_transient is not None:
                self._watch_transient(block)
            start = self._pass_transient(block.events)
            shown = self.t_reached >= self.begin or self._is_late(block)
            if shown:
                yield self._from(start, block)

    def _computed(self) -> Iterator[Block | None]:
        """The blocks as the engine computes them."""
        trajectory = self.begun = self.begun or self._trajectory()
        stages = deque(self._early.stages if self._early else ())
        trajectory.pause_at(stages[0] if stages else math.inf)
        for block in trajectory.blocks_beside() if self.suits_lanes else trajectory.blocks():
            self.ask()
            if block is None:
                yield None
                continue
            self.t_reached = block.t_reached
            if stages and self._ends_early(stages, block, trajectory):
                break
            yield block
        else:
            if not (stages and self._early and self._early.is_sure(stages[0])):
                self._end(trajectory)
        _kept.runs.append((self._settings, trajectory))

    def _ends_early(self, stages: deque[float], block: Block, trajectory: Trajectory) -> bool:
        """Whether the run ends at one of the stages that a block has come to, which are done with."""
        assert self._early is not None
        self._early.take(block)
        while stages and self.t_reached >= stages[0]:
            if self._early.is_sure(stages.popleft()):
                return True
            trajectory.pause_at(stages[0] if stages else math.inf)
        return False

    def _end(self, trajectory: Trajectory) -> None:
        """Take what the whole run has come to."""
        if self.late:
            self.extremes, self._at_begin = trajectory.extremes, trajectory.at_begin
        totals = trajectory.totals
        self.totals = {name: float(totals[name]) for name in COUNTED_IN_ALL}

    @property
    def late(self) -> bool:
        """Whether the run came to `begin`."""
        return self.t_reached >= self.begin

    @property
    def rows(self) -> list[Row] | None:
        """The rows of the last instant of events before `begin`, from which a run goes on as this one; None
        where that is the start.
        """
        return None if self._instant is None else rows_of_instant(*self._instant)

    def _trajectory(self) -> Trajectory:
        """The run, not yet computed: the kept one where that can begin anew."""
        settings, trajectory = _kept.runs.pop() if _kept.runs else (None, None)
        if trajectory is not None and settings == self._settings and trajectory.restart(self.scene):
            return trajectory
        ends, begin, watched = self._settings
        record_from = begin, 0.0 if watched else begin
        return open_trajectory(self.scene, section=True, extremes=(ends, begin), record_from=record_from)

    def _pass_transient(self, events: Mapping[str, np.ndarray]) -> int:
        """Number of the events of a block that belong to the transient: those before `begin`, and the first
        at it.
        """
        times = events["t"]
        count = int(times.searchsorted(self.begin))
        count += count < len(times) and times[count] == self.begin
        if count:
            self._instant = events, count - 1, self.rows or ()
        return count

    def _is_late(self, block: Block) -> bool:
        """Whether a stretch that ends behind `begin` has begun to be recorded."""
        return any(
            len(times) and times[-1] >= self.begin for times in (block.samples["time"], block.section["time"])
        )

    def _from(self, count: int, block: Block) -> Block:
        """The rest of a block behind so many events, in front of it the last of the transient as a start."""
        assert self._instant is not None  # a run begins with an event
        events, at, _ = self._instant
        if count:  # it is in front of them, so that nothing but what a start says otherwise is copied
            begun = {name: column[count - 1 :] for name, column in block.events.items()}
        else:
            begun = {
                name: np.concatenate((events[name][at : at + 1], rest)) for name, rest in block.events.items()
            }
        for name in begun:
            if name in START:
                begun[name] = _beginning(begun[name], START[name])
            elif name.startswith(BEFORE):
                begun[name] = _beginning(begun[name], begun[name.removeprefix(BEFORE)][0])
        section, extremes = block.section, block.extremes
        if len(section["time"]):
            late = section["time"] > begun["t"][0]
            section, extremes = {name: column[late] for name, column in section.items()}, extremes[:, late]
        return Block(block.samples, begun, section, block.t_reached, block.worked_to, extremes)

    def ends(self) -> dict[str, np.ndarray]:
        """Time, and states that statistics ask for, at `begin` and at the end of the run, each (2)."""
        last = {**self._last, "time": self._last["t"]}
        names = section_columns(self.scene)
        return {name: np.array([self._at_begin[name][0], last[name][-1]]) for name in names}

    def ask(self) -> None:
        """Raise GivenUpError where nobody wants the run any more; for those who run more of it themselves."""
        if self._go_on is not None and not self._go_on():
            raise GivenUpError


def _beginning(column: np.ndarray, first: float) -> np.ndarray:
    """A copy of a column that begins with another value."""
    column = column.copy()
    column[0] = first
    return column


# The statistics of one point, taken block by block from its run; no trajectory is kept.
#
# Everything is taken from the time `begin` on. A period is one of the excitation, from one stroboscopic point
# to the next; only whole periods count. Where there is none (no source, a motor that stands), what is meant
# per period is NaN, and amplitudes are half the peak-to-peak of the whole time. Extremes are the engine's,
# see `vibsim/engine/extremes.c`.


TURN = 2 * math.pi
COUNTED = {"impacts_per_period": IMPACTS, "sticks_per_period": ("stick_begin",)}  # by kinds of events
CODES = {name: of_kinds(kinds) for name, kinds in COUNTED.items()}


class Statistics:
    """Running statistics of one run. Memory grows with its periods and impacts, not with its length."""

    def __init__(self, scene: Scene, of: Quantities, begin: float):
        self.scene, self.of, self.begin = scene, of, begin
        self._has_periods = _has_periods(scene)
        self._points: list[dict[str, np.ndarray]] = []
        self._extremes: list[np.ndarray] = []
        self._begun: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {name: [] for name in COUNTED}
        self._whole: dict[str, np.ndarray] | None = None

    def update(self, block: Block) -> None:
        """Take the next block of a `MeasuredRun`."""
        if not self._has_periods:  # extremes of the whole run are all that is taken
            return
        late = block.section["time"] >= self.begin
        self._whole = None
        self._points.append({name: column[late] for name, column in block.section.items()})
        self._extremes.append(block.extremes[:, late])
        for name, begun in self._begun.items():
            of_kind = CODES[name][block.events["kind"]]
            begun.append((block.events["t"][of_kind], block.events["part"][of_kind]))

    def values(self, run: MeasuredRun) -> dict[str, float]:
        """The statistics by name, see `columns`; empty where the run ended before `begin`."""
        if not run.late:
            return {}
        periods = self.periods
        points = self.points() if periods else run.ends()
        return {
            **self._amplitudes(run, periods),
            **self._per_period(points["time"], periods),
            **self._drift(points),
            **self._speeds(points, run),
        }

    @property
    def periods(self) -> int:
        """Number of whole periods."""
        return max(sum(len(part["time"]) for part in self._points) - 1, 0)

    def window(self, run: MeasuredRun) -> tuple[float, float]:
        """Begin and end of the whole periods [s]; of everything that was taken where there is none."""
        if not self.periods:
            return self.begin, run.t_reached
        times = self.points()["time"]
        return float(times[0]), float(times[-1])

    def points(self) -> dict[str, np.ndarray]:
        """The stroboscopic points: time and states by name, each (n)."""
        if self._whole is None:
            parts = self._points
            self._whole = {
                name: np.concatenate([part[name] for part in parts]) if parts else np.empty(0)
                for name in section_columns(self.scene)
            }
        return self._whole

    def section(self, count: int) -> dict[str, np.ndarray]:
        """The last `count` stroboscopic points, NaN in front where there are fewer.

        By column: displacements [m] and velocities [m/s], motor speed [Hz].
        """
        if not count:
            return {}
        points = {name: column[max(len(column) - count, 0) :] for name, column in self.points().items()}
        known = len(points["time"])
        section = {}
        for name, taken in self._sections().items():
            section[name] = np.full(count, np.nan)
            if known:
                section[name][count - known :] = taken(points)
        return section

    def _sections(self) -> dict[str, Callable[[States], np.ndarray]]:
        """The function that takes each column of `section` from points."""

        def of_motion(motion: MeasuredMotion, is_rate: bool) -> Callable[[States], np.ndarray]:
            return lambda points: (velocities if is_rate else displacements)(self.scene, (motion,), points)[0]

        def of_speed(name: str) -> Callable[[States], np.ndarray]:
            return lambda points: points[name] / TURN

        columns = {name: of_motion(*told) for name, told in self.of.sections.items()}
        if self.scene.has_motor:
            columns["section_speed"] = of_speed("phidot")
        columns |= {f"section_{w}": of_speed(w) for _, w in self.of.rotors.values()}
        return columns | {f"section_{name}": itemgetter(name) for name in self.of.states}

    def _amplitudes(self, run: MeasuredRun, periods: int) -> dict[str, float]:
        least, greatest, _ = run.extremes
        if periods:  # of every whole period, else of everything
            low, high = np.split(np.concatenate(self._extremes, axis=1)[:, 1:], 2)
            halves = (high - low) / 2
            means, largest = mean(halves).tolist(), halves.max(axis=1).tolist()
        else:
            means = largest = [(high - low) / 2 for low, high in zip(least, greatest, strict=True)]
        amplitudes = {}
        for i, motion in enumerate(self.of.motions):
            amplitudes[f"amplitude_{motion.name}"] = means[i]
            amplitudes[f"amplitude_{motion.name}_max"] = largest[i]
        for name, motion in self.of.ranged.items():
            i = self.of.motions.index(motion)
            amplitudes[f"{name}_min"], amplitudes[f"{name}_max"] = float(least[i]), float(greatest[i])
        return amplitudes

    def _per_period(self, times: np.ndarray, periods: int) -> dict[str, float]:
        """Events in the whole periods, divided by their number."""
        per_period: dict[str, float] = {"periods": float(periods)}
        parts = {"impacts_per_period": self.of.stops, "sticks_per_period": self.of.frictions}
        for name, begun in self._begun.items():
            if not periods:
                per_period |= dict.fromkeys((name, *(f"{name}_{one}" for one in parts[name])), math.nan)
                continue
            happened, part = (np.concatenate([[], *column]) for column in zip(*begun, strict=True))
            counted = (happened >= times[0]) & (happened < times[-1])
            per_period[name] = np.count_nonzero(counted) / periods
            for one in parts[name]:
                count = np.count_nonzero(counted & (part == self._number(one)))
                per_period[f"{name}_{one}"] = count / periods
        return per_period

    def _number(self, part: str) -> int | None:
        """Number of a part among those of the events table; None where it is not in the scene: mu = 0."""
        columns = part_columns(self.scene)
        name = stop_column(part) if part in self.of.stops else part
        return columns.index(name) if name in columns else None

    def _drift(self, points: dict[str, np.ndarray]) -> dict[str, float]:
        """Slopes of the lines of least squares through displacements at the stroboscopic points [m/s]."""
        t = points["time"] - mean(points["time"])
        square = float(dot(t, t))
        drifts = {}
        for name, motion in self.of.drifting.items():
            x = displacements(self.scene, (motion,), points)[0]
            x = x - x[0]
            drifts[name] = float(dot(t, x - mean(x))) / square if square else math.nan
        return drifts

    def _speeds(self, points: dict[str, np.ndarray], run: MeasuredRun) -> dict[str, float]:
        """Mean speeds over the whole periods, extremes of that of a motor over everything [Hz]."""
        span = points["time"][-1] - points["time"][0]
        if not self.scene.has_motor:
            return {
                f"mean_speed_{name}": float((points[phi][-1] - points[phi][0]) / TURN / span)
                if span
                else math.nan
                for name, (phi, _) in self.of.rotors.items()
            }
        mean = (points["phi"][-1] - points["phi"][0]) / TURN / span if span else math.nan
        least, greatest, _ = run.extremes
        return {
            "mean_speed": float(mean),
            "min_speed": least[-1] / TURN,
            "max_speed": greatest[-1] / TURN,
        }


@of_parts_alone
def _has_periods(scene: Scene) -> bool:
    """Whether a run of a scene has stroboscopic points."""
    return has_section(scene)


# Displacements and velocities of motions, from the states of many rows at once.


def displacements(scene: Scene, motions: Sequence[MeasuredMotion], states: States) -> np.ndarray:
    """x_P - x_Q [m] of each motion (motions, n)."""
    return _rows([difference(*(place(scene, end, states) for end in (m.P, m.Q))) for m in motions])


def velocities(scene: Scene, motions: Sequence[MeasuredMotion], states: States) -> np.ndarray:
    """v_P - v_Q [m/s] of each motion (motions, n)."""
    return _rows([difference(*(speed(scene, end, states) for end in (m.P, m.Q))) for m in motions])


def _rows(columns: Sequence[np.ndarray]) -> np.ndarray:
    """Columns as the rows of one array; of a single one its view, sooner than a stack."""
    return columns[0][None] if len(columns) == 1 else np.stack(columns)


def place(scene: Scene, end: int, states: States) -> np.ndarray | None:
    """Displacement of an end of a part [m] (n); None for the ground."""
    if end == GROUND:
        return None
    return (
        base_motion(scene, states["time"])[0]
        if end == BASE
        else states[columns_of(scene.bodies[end].name)[0]]
    )


def speed(scene: Scene, end: int, states: States) -> np.ndarray | None:
    """Velocity of an end of a part [m/s] (n); None for the ground."""
    if end == GROUND:
        return None
    return (
        base_motion(scene, states["time"])[1]
        if end == BASE
        else states[columns_of(scene.bodies[end].name)[1]]
    )


def difference(one: np.ndarray | None, other: np.ndarray | None) -> np.ndarray:
    """Difference of one end of a part against the other (n); None is the ground, which is not both."""
    if one is None:
        assert other is not None
        return -other
    return one if other is None else one - other


# The sampling of a point's run, for what is taken from samples: it resolves the motion.


# Samples h apart miss an extreme of a vibration at w rad/s by up to (w h)^2 / 8 of it:
LARGEST_ANGLE_IN_CONTACT = 1.1  # 15 % of the depth of penetration
LARGEST_ANGLE = 0.4  # 2 % of the amplitude


class TooFineError(ValueError):
    """A motion so fast, or an output interval so short, that a run has more samples than it may."""


def sampled_for_statistics(scene: Scene, every: Fraction | None = None) -> Scene:
    """The scene with the output interval `every` [s], or with the longest that its motion allows.

    Raises TooFineError where that makes more samples than a run may have.
    """
    num, den = (1, math.ceil(samples_per_second(scene))) if every is None else every.as_integer_ratio()
    top, bottom = float(scene.t_end).as_integer_ratio()
    if top * den > MOST_SAMPLES * bottom * num:  # whole numbers, so that it is exact
        raise TooFineError(
            "the run takes more than 1e10 samples to resolve its motion; make it shorter"
            if every is None
            else f"samples every {float(every):.3g} s are more than 1e10 in this run; take a longer interval"
        )
    return scene.but(every_num=num, every_den=den)


def samples_per_second(scene: Scene) -> float:
    """Samples [1/s] that resolve free vibration, vibration in contact and sources."""
    rate, start_tells = _samples_for_parts(scene)
    if not start_tells:
        return rate
    return max(rate, max([fastest_of_formulas(scene), *spins(scene)]) / LARGEST_ANGLE)


@of_parts_alone
def _samples_for_parts(scene: Scene) -> tuple[float, bool]:
    """The part that does not depend on the start; whether another part does (rotors, formulas that push)."""
    rate = max([fastest(scene, scene.links), *source_rates(scene)]) / LARGEST_ANGLE
    stops = [stop for _, stop in scene.elastic_stops]
    if stops:
        rate = max(rate, fastest(scene, (*scene.links, *stops)) / LARGEST_ANGLE_IN_CONTACT)
    moved = any(body.kind != BODY for body in scene.bodies) or scene.has_motor
    pushed = any(link.force for link in scene.links) or any(force.formula for force in scene.forces)
    return max(rate, 1 / scene.t_end), moved or pushed


def fastest(scene: Scene, springs: Sequence[Link | Stop]) -> float:
    """A bound of the rates [1/s] at which bodies vibrate on springs.

    y'' + B K y = 0 in the differences y of the pairs of ends that springs join: B_ij sums 1 / mass over the
    bodies that pairs i and j share. By Gershgorin's theorem no eigenvalue of B K exceeds the largest sum over
    j of B_ij k_j: exact for one pair, and for a long chain of equal bodies. Dampers make vibrations slower;
    what dies out at once need not be resolved. A motor's m3 is left out: where the rotor cannot follow, its
    body vibrates alone.
    """
    pairs: dict[frozenset[int], float] = {}
    for part in springs:
        ends = frozenset((part.P, part.Q))
        pairs[ends] = pairs.get(ends, 0.0) + part.k
    shares = [[mobility(scene, ends & others) * k for others, k in pairs.items()] for ends in pairs]
    return math.sqrt(max((reduce(add, of_pair) for of_pair in shares), default=0.0))
