"""The points of a sweep: computed one by one, in batches, and gathered in a table."""

import math
import time
import traceback
from collections import defaultdict
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibsim.cases import CaseError
from vibsim.engine.blocks import Block
from vibsim.engine.columns import state_columns
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import RUNS_AT_ONCE, Trajectory, advance_together, suits_lanes
from vibsim.physics.elementary import total
from vibsim.physics.parts import ROTOR, Scene
from vibsim.physics.rates import has_section, of_parts_alone, source_rates, turning_columns
from vibsim.sweeps.computations import COMPUTATIONS, Computation
from vibsim.sweeps.contact_computations import Task
from vibsim.sweeps.quantities import DONE, FAILED, MISSING, NAME
from vibsim.sweeps.statistics import (
    GivenUpError,
    MeasuredRun,
    Statistics,
    TooFineError,
    sampled_for_statistics,
)
from vibsim.sweeps.sweep_plan import Index, PointSettings, Start, SweepPlan

if TYPE_CHECKING:
    from vibsim.analysis.attractor import KnownOrbits
    from vibsim.cases import Case
    from vibsim.sweeps.attractor_labels import EarlyLabel


# One point of a sweep: computed here, in whatever thread, process or machine it falls to.


Steps = Generator["SweepPoint | Trajectory | None", float | None, None]
Measured = tuple[dict[str, float], dict[str, np.ndarray]]

NOTHING_TO_CARRY = (
    "the run after the transient holds no whole excitation period, so there is no state to carry on from"
)
TURN = 2 * math.pi
NO_PERIOD = "forces and base have no common period, so there is no state to carry on from"


@dataclass(frozen=True)
class SweepPoint:
    """Result of one point.

    Attributes
    ----------
    index : position on every axis, then of the direction
    status : DONE or FAILED
    sha256 : fingerprint of the point's case, its start included; empty where the case is not allowed
    error : why it failed
    values : statistics, totals and end state by name (see `columns`); what does not apply is missing
    arrays : what has a further dimension, such as the last stroboscopic points, by name
    """

    index: Index
    status: int
    sha256: str
    error: str = ""
    values: dict[str, float] = field(default_factory=dict)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """Whether it was computed and did not fail."""
        return self.status == DONE


def compute_point(
    settings: PointSettings,
    index: Index,
    changes: Mapping[str, str],
    start: Start | None,
    go_on: Callable[[], bool] | None = None,
) -> SweepPoint | None:
    """Run one point and take its statistics.

    Parameters
    ----------
    changes : what the point replaces in the case of the settings
    start : where a state is carried, the end of the point before
    go_on : asked every few milliseconds; the point is given up (None) when it says False

    A point that cannot be run is returned as FAILED with the reason; it raises nothing for that.
    """
    steps = run_point(settings, index, made_case(settings, changes, start), go_on)
    return next((point for point in steps if isinstance(point, SweepPoint)), None)


class MadeCase(NamedTuple):
    """The values that a point replaces in the case, the case that results, or why that is not allowed,
    and how long that took [s].
    """

    changes: Mapping[str, str]
    case: "Case | CaseError"
    seconds: float


def made_case(settings: PointSettings, changes: Mapping[str, str], start: Start | None = None) -> MadeCase:
    """The case of a point, with its scene and fingerprint."""
    began = time.perf_counter()
    case: Case | CaseError
    try:
        case = settings.point_case(changes, start)
        with suppress(Exception):  # the point comes upon it, too, and tells
            case.scene(), case.sha256
    except CaseError as error:
        case = error
    return MadeCase(changes, case, time.perf_counter() - began)


def run_point(
    settings: PointSettings, index: Index, made: MadeCase, go_on: Callable[[], bool] | None
) -> Steps:
    """As `compute_point`, of a point whose case is made, in steps. It yields None while its run is held. It
    yields its `Trajectory` where that can be advanced beside others; the time that this took [s] is sent
    then. At last it yields the point; nothing if the point is given up.
    """
    changes, case, seconds = made
    began = time.perf_counter() - seconds
    if isinstance(case, CaseError):
        yield SweepPoint(index, FAILED, "", str(case))
        return
    try:
        scene = sampled_for_statistics(case.scene(), settings.every)
        measurement = Measurement(scene, settings, go_on, _known(settings, changes, go_on))
        if measurement.run.hold():
            left = time.perf_counter()
            yield None
            began += time.perf_counter() - left
        steps = measurement.steps()
        while (measured := next(steps)) is None:
            left = time.perf_counter()
            took = yield measurement.run.begun
            began += time.perf_counter() - left - (took or 0.0)
        values, arrays = measured
    except (EngineError, TooFineError) as error:
        label = _run_away(settings, error)
        if label is None:
            yield SweepPoint(index, FAILED, case.sha256, str(error))
            return
        values, arrays = label
    except GivenUpError:
        return
    except Exception as error:  # a bug that shows at one point must not cost all the others
        yield SweepPoint(index, FAILED, case.sha256, described_bug(error))
        return
    if settings.carry and not any(name.startswith("end_") for name in values):
        yield SweepPoint(index, FAILED, case.sha256, NOTHING_TO_CARRY if has_section(scene) else NO_PERIOD)
        return
    values["wall_time"] = time.perf_counter() - began
    yield SweepPoint(index, DONE, case.sha256, "", values, arrays)


def described_bug(error: Exception) -> str:
    """The error of a bug and its place, in one line."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{Path(frame.filename).name}:{frame.lineno}"
    return f"a bug in vibsim, please report it: {type(error).__name__}: {error} ({place})"


def _known(
    settings: PointSettings, changes: Mapping[str, str], go_on: Callable[[], bool] | None
) -> "KnownOrbits | None":
    """Orbits of the point's scene that are known beforehand; none unless attractors are asked for."""
    if NAME not in settings.compute:
        return None
    from vibsim.sweeps.attractor_labels import known_orbits

    return known_orbits(settings, changes, partial(_ask, go_on))


def _ask(go_on: Callable[[], bool] | None) -> None:
    if go_on is not None and not go_on():
        raise GivenUpError


def _of_label(stored: dict[str, Any], t_reached: float) -> Measured:
    """Values of a run of which its attractor alone is known."""
    numbers = {name: value for name, value in stored.items() if isinstance(value, float)}
    arrays = {name: value for name, value in stored.items() if not isinstance(value, float)}
    return {"t_reached": t_reached, **numbers}, arrays


def _run_away(settings: PointSettings, error: EngineError | TooFineError) -> Measured | None:
    """Values of a run that went to infinity in a finite time, where attractors are asked for and
    nothing else: its label. None of any other failure.
    """
    if settings.compute != (NAME,) or settings.carry or not isinstance(error, EngineError):
        return None
    from vibsim.sweeps.attractor_labels import label_of_failure, values_of

    label = label_of_failure(error)
    return None if label is None else _of_label(values_of(label), float(error.state.t))


class Measurement:
    """The measurements of one run of a scene.

    known : orbits of the scene with which the run is compared. Where nothing but its attractor is asked, and
        that is sure before the transient ends, the statistics, which count from there on, are missing
    """

    def __init__(
        self,
        scene: Scene,
        settings: PointSettings,
        go_on: Callable[[], bool] | None,
        known: "KnownOrbits | None" = None,
    ):
        begin = settings.discard.time(scene.t_end)
        kinds = [COMPUTATIONS[name] for name in settings.compute]
        if not any(kind.samples for kind in kinds):
            scene = scene.without_samples()
        self._scene, self._section = scene, settings.section
        self._statistics = Statistics(scene, settings.of, begin)
        task = Task(scene, settings.of, begin, settings.section, known)
        self._computed = [kind.make(task) for kind in kinds]
        self._early: EarlyLabel | None = None
        if known and settings.compute == (NAME,) and not settings.carry:
            from vibsim.sweeps import attractor_labels

            self._early = attractor_labels.EarlyLabel(scene, begin, known)
        self.run = MeasuredRun(scene, settings.of, begin, go_on, _watchers(self._computed), self._early)

    def values(self) -> Measured:
        """Statistics, totals and end state by name; what has a further dimension, as sections, by name."""
        return next(filter(None, self.steps()))

    def steps(self) -> Iterator[Measured | None]:
        """The same, with None before it wherever the run `begun` can be computed beside others."""
        run, scene, statistics = self.run, self._scene, self._statistics
        is_timed, end = _is_timed(scene), None
        for block in run.blocks_beside():
            if block is None:
                yield None
                continue
            statistics.update(block)
            for computation in self._computed:
                computation.update(block)
            table = block.section if is_timed else block.events
            if len(table["time" if is_timed else "t"]):
                end = table
        if self._early is not None and self._early.label is not None:
            from vibsim.sweeps.attractor_labels import values_of

            yield _of_label(values_of(self._early.label), self._early.time)
            return
        values = {
            **statistics.values(run),
            **run.totals,
            "t_reached": run.t_reached,
            **_end_state(scene, end),
        }
        measured: dict[str, Any] = dict(statistics.section(self._section))
        if run.late:
            for computation in self._computed:
                measured |= computation.values(statistics.window(run), run, measured)
        numbers = {name: value for name, value in measured.items() if isinstance(value, float)}
        arrays = {name: value for name, value in measured.items() if not isinstance(value, float)}
        yield {**values, **numbers}, arrays


def _watchers(computed: list[Computation]) -> Callable[[Block], None] | None:
    """Shows blocks of the transient to those computations that take them; None where none does."""
    taking = [computation.transient for computation in computed if hasattr(computation, "transient")]
    if not taking:
        return None

    def show(block: Block) -> None:
        for take in taking:
            take(block)

    return show


def _end_state(scene: Scene, last: Mapping[str, np.ndarray] | None) -> dict[str, float]:
    """State from which a carried sweep is continued, of the last points or events of a run that has any."""
    if last is None:
        return {}
    states = {name: float(last[name][-1]) for name in state_columns(scene)}
    if scene.has_motor:
        states["phi"] = float(last["phase"][-1])
    for phi in (body.columns[0] for body in scene.bodies if body.kind == ROTOR):
        if phi is not None:
            states[phi] = float(np.mod(states[phi], TURN))
    return {f"end_{name}": value for name, value in states.items()}


@of_parts_alone
def _is_timed(scene: Scene) -> bool:
    """Whether forces or a moving base say when a period ends: these begin the next point as they began this
    one, so that the last stroboscopic point is the end whose motion they continue.
    """
    return scene.motor is None and turning_columns(scene) is None and bool(source_rates(scene))


# A batch: points that one worker computes one after another, and gives back together.
#
# It is made of pieces. Within a piece a state is carried from point to point where the sweep does so; the
# pieces have nothing to do with each other.


@dataclass(frozen=True)
class BatchPiece:
    """Neighbours of one chain: index of each and what it changes in the case; where the first begins."""

    points: tuple[tuple[Index, dict[str, str]], ...]
    start: Start | None = None

    def __len__(self) -> int:
        return len(self.points)


Pieces = tuple[BatchPiece, ...]
TOGETHER = 64  # points: what is held of their runs takes some megabytes at most
SIDE_BY_SIDE = 2 * RUNS_AT_ONCE  # points whose runs share lanes, at most 64; with samples half as many


def compute_batch(
    settings: PointSettings, pieces: Pieces, go_on: Callable[[], bool] | None = None
) -> list[SweepPoint]:
    """The points of all pieces, in their order; those that were done before `go_on` said False."""
    follow = _carried if settings.carry else _independent
    return list(follow(settings, pieces, go_on))


def _independent(
    settings: PointSettings, pieces: Pieces, go_on: Callable[[], bool] | None
) -> Iterator[SweepPoint]:
    """Points that nothing is carried between, some at a time: their cases are made, then short ones are run,
    or steps taken side by side, then measured. What does either falls out of the processor's caches while the
    engine runs, and takes twice the time between two runs.
    """
    left = (point for piece in pieces for point in piece.points)
    at_once = TOGETHER
    if suits_lanes(settings.case.scene()):
        sampled = any(COMPUTATIONS[name].samples for name in settings.compute)
        at_once = RUNS_AT_ONCE if sampled else SIDE_BY_SIDE
    while together := list(islice(left, at_once)):
        made = [(index, made_case(settings, changes)) for index, changes in together]
        running: list[Steps] = []
        points: list[SweepPoint | Trajectory | None] = []
        for index, case in made:
            steps = run_point(settings, index, case, go_on)
            try:
                points.append(next(steps))
            except StopIteration:  # it was given up
                break
            running.append(steps)
        _advance(points, running)
        count = 0
        for point, steps in zip(points, running, strict=True):
            done = point or next(steps, None)
            if isinstance(done, SweepPoint):
                count += 1
                yield done
        if count < len(made):
            return


def _advance(points: list[Any], running: list[Steps]) -> None:
    """Advance runs side by side, and put each point in the place of its run; None where it is given up."""
    times: dict[int, float] = defaultdict(float)  # of those that wait, since their steps [s]
    while runs := {i: run for i, run in enumerate(points) if isinstance(run, Trajectory)}:
        began = time.perf_counter()
        advance_together(list(runs.values()))
        share = (time.perf_counter() - began) / len(runs)
        for i in runs:
            times[i] += share
            if runs[i].advanced:
                try:
                    points[i] = running[i].send(times.pop(i))
                except StopIteration:
                    points[i] = None


def _carried(
    settings: PointSettings, pieces: Pieces, go_on: Callable[[], bool] | None
) -> Iterator[SweepPoint]:
    """Points that begin where the one before in their piece ended, or where that began if it failed."""
    for piece in pieces:
        start = piece.start
        for index, changes in piece.points:
            point = compute_point(settings, index, changes, start, go_on)
            if point is None:
                return
            if point.done:
                start = settings.start_after(point.values)
            yield point


# The points of a sweep as arrays by name, over the axes and the direction.


TEXTS_AND_STATUS = ("status", "sha256", "error")
PIECE = 2**20  # numbers


class Table:
    """All points; what was not computed is NaN, its status MISSING.

    Attributes
    ----------
    numbers : name -> array of the sweep's shape, or with a further dimension such as (*shape, section)
    status : codes of `columns.STATUS_FLAGS` (shape)
    sha256, error : texts (shape)
    """

    def __init__(self, plan: SweepPlan):
        shape = self.shape = plan.shape
        self._further = {name for name, column in plan.columns.items() if column.dimension}
        self.numbers = {name: _unknown(plan.shape_of(name)) for name in plan.columns}
        self.status = np.full(shape, MISSING, dtype="i1")
        self.sha256 = np.full(shape, "", dtype=object)
        self.error = np.full(shape, "", dtype=object)

    def column(self, name: str) -> np.ndarray:
        """A column of numbers, or status, sha256 or error."""
        return getattr(self, name) if name in TEXTS_AND_STATUS else self.numbers[name]

    def fill(self, read: Callable[[str], np.ndarray]) -> None:
        """Take over all columns as `read` gives them."""
        for name in (*self.numbers, *TEXTS_AND_STATUS):
            self.column(name)[...] = read(name)

    def put(self, point: SweepPoint) -> None:
        """Store a point, in place of what was there; what is shorter than its dimension gets NaN in front."""
        for name, array in self.numbers.items():
            if name not in self._further:
                array[point.index] = point.values.get(name, np.nan)
                continue
            row, values = array[point.index], point.arrays.get(name)
            row[...] = np.nan
            if values is not None:
                row[len(row) - len(values) :] = values
        self.status[point.index] = point.status
        self.sha256[point.index] = point.sha256
        self.error[point.index] = point.error

    def point(self, index: Index) -> SweepPoint:
        """The point at `index`, as it was put."""
        further = self._further
        values = {name: float(array[index]) for name, array in self.numbers.items() if name not in further}
        arrays = {name: array[index].copy() for name, array in self.numbers.items() if name in further}
        status, sha256, error = self.status[index], self.sha256[index], self.error[index]
        return SweepPoint(index, int(status), str(sha256), str(error), values, arrays)

    def count(self, status: int) -> int:
        """Number of points of a status."""
        return int(np.count_nonzero(self.status == status))

    @property
    def complete(self) -> bool:
        """Whether every point was computed, failed ones included."""
        return self.count(MISSING) == 0

    @property
    def done(self) -> bool:
        """Whether every point was computed and none failed."""
        return self.count(DONE) == self.status.size

    def failures(self) -> Iterator[tuple[Index, str]]:
        """Index and reason of each failed point."""
        for index in np.argwhere(self.status == FAILED).tolist():
            yield tuple(index), str(self.error[tuple(index)])


def _unknown(shape: Index) -> np.ndarray:
    """An array of NaN, filled piece by piece: memory can come slowly, and Ctrl-C is heard between pieces."""
    array = np.empty(shape)
    flat = array.reshape(-1)
    for first in range(0, flat.size, PIECE):
        flat[first : first + PIECE] = np.nan
    return array


# What the members of an ensemble have in common: means and quantiles, and probabilities with intervals.


CONFIDENT = 1.959963984540054  # standard deviations either side that hold 95 % of a normal distribution


@dataclass(frozen=True)
class Summary:
    """A statistic over the members, arrays over what is left of the sweep; NaN where no member has it.

    Attributes
    ----------
    count : members that have it
    mean, deviation : mean and standard deviation (of a sample, so NaN for fewer than two members)
    least, median, greatest : quantiles
    """

    count: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray
    least: np.ndarray
    median: np.ndarray
    greatest: np.ndarray


@dataclass(frozen=True)
class Share:
    """A probability, estimated as a share of members.

    Attributes
    ----------
    count : members that count
    estimate : share of them; NaN for none
    low, high : Wilson's interval of 95 %, which holds for shares near 0 and 1 and for few members too
    """

    count: np.ndarray
    estimate: np.ndarray
    low: np.ndarray
    high: np.ndarray


def summary(values: np.ndarray, dimension: int) -> Summary:
    """Sum up `values` along a dimension; NaN does not count."""
    known = ~np.isnan(values)
    count = known.sum(axis=dimension)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = _along(np.where(known, values, 0.0), dimension) / count
        apart = np.where(known, values - np.expand_dims(mean, dimension), 0.0)
        deviation = np.sqrt(_along(apart * apart, dimension) / np.where(count > 1, count - 1, np.nan))
    ordered = np.sort(values, axis=dimension)  # NaN last
    return Summary(
        count, mean, deviation, *(_quantile(ordered, count, dimension, q) for q in (0.0, 0.5, 1.0))
    )


def quantile(values: np.ndarray, dimension: int, q: float) -> np.ndarray:
    """The q-quantile of `values` along a dimension, linear between members; NaN does not count."""
    count = (~np.isnan(values)).sum(axis=dimension)
    return _quantile(np.sort(values, axis=dimension), count, dimension, q)


def _along(values: np.ndarray, dimension: int) -> np.ndarray:
    """Sum along a dimension."""
    return total(np.moveaxis(values, dimension, -1))


def _quantile(ordered: np.ndarray, count: np.ndarray, dimension: int, q: float) -> np.ndarray:
    """Quantile of the first `count` along the dimension, linear between members."""
    place = q * np.maximum(count - 1, 0)
    ends = [np.expand_dims(edge(place).astype(int), dimension) for edge in (np.floor, np.ceil)]
    low, high = (np.take_along_axis(ordered, end, dimension).squeeze(dimension) for end in ends)
    return np.asarray(low + (place - np.floor(place)) * (high - low))


def share(condition: np.ndarray, counts: np.ndarray, dimension: int) -> Share:
    """Share of those that count for which a condition holds, along a dimension; both of one shape, boolean.

    Wilson (1927): centre (p + z^2/2n) / (1 + z^2/n), half width z sqrt(p (1 - p)/n + z^2/4n^2) / (1 + z^2/n).
    """
    n = counts.sum(axis=dimension)
    with np.errstate(invalid="ignore", divide="ignore"):
        p = (condition & counts).sum(axis=dimension) / n
        squared = CONFIDENT * CONFIDENT / n
        centre = (p + squared / 2) / (1 + squared)
        half = CONFIDENT * np.sqrt(p * (1 - p) / n + squared / (4 * n)) / (1 + squared)
    return Share(n, p, np.where(n > 0, np.maximum(centre - half, 0), 0), np.where(n > 0, centre + half, 1))
