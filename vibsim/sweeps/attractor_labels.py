"""The attractor that the run of one point of a sweep ends on, and the orbits that its neighbours end on.

Some starts of a sweep, the probes, are drawn once by its plan. Each worker follows them to their ends, in
their order, before the first point of a scene; the stable orbits on which they end are known from then on,
with their neighbourhoods. Every point is then compared with these as it runs, and stops where it is sure to
end on one. What is known depends on plan and parameters alone, and never on which points came before: so a
point has the same bits in whatever order, on whatever worker it is computed.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.analysis.analysis import StreamedVerdicts
from vibsim.analysis.attractor import (
    KnownOrbits,
    Label,
    label_of_points,
    label_of_set,
    orbit_of_free,
    rest_label,
    unknowns_at,
)
from vibsim.analysis.attractor import label_of as label_of_orbit
from vibsim.analysis.regime import STILL, exponent_of
from vibsim.analysis.sections import FEWEST
from vibsim.cases import CaseError
from vibsim.engine.blocks import Block
from vibsim.engine.columns import state_columns
from vibsim.engine.errors import EngineError
from vibsim.engine.modes.status import STICK
from vibsim.engine.resume import Row
from vibsim.engine.tangent.lyapunov import lyapunov_exponents
from vibsim.orbits.coordinates import Coordinates, OrbitError, coordinates_of_rest
from vibsim.orbits.newton import EVEN, solve
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.return_map import ReturnMap, returns, slowest_period
from vibsim.orbits.search import least
from vibsim.orbits.words import OF_FRICTION
from vibsim.physics.connections import whole_turn_angles
from vibsim.physics.parts import EVENT_KINDS, EVENT_NAMES, Scene
from vibsim.physics.rates import is_driven, source_period
from vibsim.sweeps.contact_computations import END_STATE, VERDICTS, EndState, Task
from vibsim.sweeps.quantities import INITIAL, KINDS, REASONS, Quantities, observed
from vibsim.sweeps.statistics import MeasuredRun, TooFineError, sampled_for_statistics

if TYPE_CHECKING:
    from vibsim.cases import Case


def coordinates_of(scene: Scene) -> Coordinates | None:
    """The unknowns of the orbits and rests of a scene; None where it has no section."""
    try:
        return coordinates_of_rest(scene)
    except OrbitError:
        return None


# One run, streamed block by block to its end.

PLACES = 16  # samples of a block that are kept
FAR = 0.8  # of the range of a displacement that runs away: how far it gets


class AttractorComputation:
    """Attractor of one run. Memory grows with its periods after the transient."""

    def __init__(self, task: Task):
        self._task, self._scene, self._begin = task, task.scene, task.begin
        self._known = task.known or KnownOrbits()
        self._driven = is_driven(task.scene)
        self._columns = state_columns(task.scene)
        self._ranges: list[tuple[float, list[float], list[float], list[float]]] = []  # time, and by column
        self._course: list[tuple[np.ndarray, np.ndarray]] = []  # times of some samples, and states there
        self._last: Row = {}

    # Runs that end early need none of these.

    @cached_property
    def _at(self) -> Coordinates | None:
        return coordinates_of(self._scene)

    @cached_property
    def _verdicts(self) -> StreamedVerdicts:
        return StreamedVerdicts(self._scene, self._begin)

    @cached_property
    def _end_state(self) -> EndState | None:
        return None if self._at is not None and self._at.section.timed else EndState(self._task)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._verdicts.update(block)
        if self._end_state is not None:
            self._end_state.update(block)
        late = block.samples["time"] >= self._begin
        if late.any():
            rows = [block.samples[name][late] for name in self._columns]
            low, high = [float(row.min()) for row in rows], [float(row.max()) for row in rows]
            ends = [float(row[-1]) for row in rows]
            self._ranges.append((float(block.samples["time"][late][-1]), low, high, ends))
            some = np.linspace(0, len(rows[0]) - 1, min(PLACES, len(rows[0]))).astype(int)
            course = np.stack([row[some] for row in rows], axis=1)
            self._course.append((block.samples["time"][late][some], course))
        if len(block.events["t"]):
            happened = np.flatnonzero(block.events["kind"] != EVENT_KINDS["end"])
            if len(happened):
                self._last = {name: column[happened[-1]].item() for name, column in block.events.items()}

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """The label by column."""
        return values_of(self.label(window, run))

    def label(self, window: tuple[float, float], run: MeasuredRun) -> Label:
        """The label of the attractor that the run ends on."""
        low, high = self._range()
        if not self._ranges:
            return Label("undecided", "too few cycles")
        if max(b - a for a, b in zip(low, high, strict=True)) <= STILL:
            return self._rest(low, high)
        if not self._driven:
            return self._of_free(window, run, low, high)
        if self._at is None:
            return Label("undecided", "no section")
        if self._comes_to_rest(window, run):
            return self._rest(low, high)
        return self._of_driven(run)

    def _comes_to_rest(self, window: tuple[float, float], run: MeasuredRun) -> bool:
        """Whether a rotor that torques of its own drive has stopped turning and its motion dies away."""
        if self._end_state is None or len(self._verdicts.late_section()["time"]):
            return False
        return self._end_state.values(window, run, {})[END_STATE] == VERDICTS["rest"]

    def _of_driven(self, run: MeasuredRun) -> Label:
        assert self._at is not None
        section = self._verdicts.late_section()
        times, points = section["time"], unknowns_at(self._at, section)
        label = self._known.reached(times[-1:], points[-1:])
        label = label or label_of_points(self._scene, times, points)
        if label is not None:
            return label
        judged = self._verdicts.judged()
        if judged.verdict == "undecided" and len(points) >= FEWEST:
            scene = self._scene.without_samples()
            growth = lyapunov_exponents(scene, 1, self._begin, run.ask).growth
            exponent = exponent_of(growth[:, 0], growth[:, 1]) if len(growth) else None
            judged = self._verdicts.judged(exponent)
        return label_of_set(judged, self._at.in_turn_of(points.copy(), np.zeros(self._at.count)))

    def _of_free(
        self, window: tuple[float, float], run: MeasuredRun, low: list[float], high: list[float]
    ) -> Label:
        assert self._end_state is not None
        codes = self._end_state.values(window, run, {})
        verdict = next(name for name, code in VERDICTS.items() if code == codes["end_state"])
        if verdict == "rest":
            return self._rest(low, high)
        label = met(self._known, self._scene, self._at, self._last)
        if label is not None:
            return label
        there = dict(zip(self._columns, self._ranges[-1][3], strict=True))
        orbit = orbit_of_free(self._scene, there)
        if orbit is not None:
            return label_of_orbit(orbit)
        drifting = self._drifting(window)
        if drifting:
            return self._turning(drifting) or Label("running away")
        return Label("undecided", "no stable orbit" if verdict == "vibration" else "still on its way")

    def _turning(self, drifting: dict[str, float]) -> Label | None:
        """Label of a run on which angles grow, by column with their mean speeds [rad/s], that whole turns
        bring back to where they were, and nothing else; its observables are these speeds.
        """
        turning = [self._scene.bodies[i].columns[0] for i in whole_turn_angles(self._scene)]
        places = [body.columns[0] for body in self._scene.line]  # where these grow evenly, speeds do not grow
        grown = [name for name in drifting if name in places]
        if self._at is None or not grown or not all(name in turning for name in grown):
            return None
        means = np.zeros(observed(self._scene))
        for i, name in enumerate(self._at.names):
            means[i] = drifting.get(name, 0.0) if name in grown else 0.0
        return Label("turning", state=np.full(self._at.count, nan), means=means, errors=np.zeros(len(means)))

    def _drifting(self, window: tuple[float, float]) -> dict[str, float]:
        """Mean velocities by column of the displacements that grow by as much in each third of the window,
        and swing by little more.
        """
        times = np.concatenate([times for times, _ in self._course])
        states = np.concatenate([states for _, states in self._course])
        thirds = [window[0] + (window[1] - window[0]) * k / 3 for k in range(4)]
        places = np.array([np.interp(thirds, times, column) for column in states.T])
        first, middle, last = np.diff(places, axis=1).T
        even = abs(last - 2 * middle + first) <= EVEN * abs(last)
        low, high = (np.array(side) for side in self._range())
        far = abs(first + middle + last) >= FAR * (high - low)
        grown = np.flatnonzero((first * last > 0) & even & far).tolist()
        span = window[1] - window[0]
        return {self._columns[i]: float(places[i, -1] - places[i, 0]) / span for i in grown}

    def _range(self) -> tuple[list[float], list[float]]:
        """Least and greatest states in the samples after the transient, in the order of their columns."""
        if not self._ranges:
            return [], []
        lows, highs = (np.array([each[k] for each in self._ranges]) for k in (1, 2))
        return lows.min(axis=0).tolist(), highs.max(axis=0).tolist()

    def _rest(self, low: list[float], high: list[float]) -> Label:
        held = any(self._last.get(friction.name, 1) == STICK for friction in self._scene.frictions)
        lowest, highest = (dict(zip(self._columns, values, strict=True)) for values in (low, high))
        return rest_label(self._at, held, lowest, highest)


def met(known: KnownOrbits, scene: Scene, at: Coordinates | None, last: Row) -> Label | None:
    """Label of a run that nothing drives, whose last event is that of a known orbit."""
    if not known or at is None or not last:
        return None
    kind, part = int(last["kind"]), int(last["part"])
    if EVENT_NAMES[kind] in OF_FRICTION:
        part -= len(scene.stops)
    X = unknowns_at(at, {name: [last[name]] for name in at.columns})[0]
    return known.met(kind, part, X, float(last["t"]))


BEYOND = 1e12  # SI: a run that fails at such a displacement or speed has run away


def label_of_failure(error: EngineError) -> Label | None:
    """Label of a run that failed on its way to infinity, which some motions reach in a finite time, as behind
    the edge of a well; None of any other failure.
    """
    state = error.state
    greatest = max(map(abs, (*map(float, state.x), *map(float, state.v))), default=0.0)
    return Label("running away", time=float(state.t)) if greatest > BEYOND else None


def values_of(label: Label) -> dict[str, Any]:
    """Values to store of a label, by column."""
    return {
        "attractor_kind": float(KINDS[label.kind]),
        "attractor_reason": float(REASONS[label.reason]),
        "attractor_period": float(label.period),
        "attractor_multiplier": float(label.multiplier),
        "attractor_time": float(label.time),
        "attractor_state": label.state,
        **({"attractor_means": label.means} if len(label.means) else {}),
        **({"attractor_errors": label.errors} if len(label.errors) else {}),
    }


# The same run, stopped as soon as it is sure where it ends.


FIRST_STAGE = 16  # periods until a run is first compared with the known orbits, then twice as many, ...


class EarlyLabel:
    """Label of a run that comes into the neighbourhood of a known orbit before `begin` [s].

    label, time : once it is sure, and the time [s] up to which the run counts then
    """

    def __init__(self, scene: Scene, begin: float, known: KnownOrbits) -> None:
        self.stages = list(_stages(scene, begin))
        self.label: Label | None = None
        self.time = nan
        self._scene, self._known, self._driven = scene, known, is_driven(scene)
        self._at = known.orbits[0].orbit.end.coordinates
        self._times, self._points = np.empty(0), np.empty((0, self._at.count))  # to be compared
        self._events: list[Mapping[str, np.ndarray]] = []  # in which the last one by the next stage is

    def take(self, block: Block) -> None:
        """Take the next block of the run."""
        if self._driven:
            self._times = np.concatenate([self._times, block.section["time"]])
            self._points = np.concatenate([self._points, unknowns_at(self._at, block.section)])
        elif len(block.events["t"]):
            self._events = [*self._events[-1:], block.events]

    def is_sure(self, stage: float) -> bool:
        """Whether the run is sure to end on a known orbit, as far as it has come by a stage [s]."""
        self.label, self.time = self._of_driven(stage) if self._driven else self._of_free(stage), stage
        return self.label is not None

    def _of_driven(self, stage: float) -> Label | None:
        count = int(self._times.searchsorted(stage, side="right"))
        label = self._known.reached(self._times[:count], self._points[:count])
        self._times, self._points = self._times[count:], self._points[count:]
        return label

    def _of_free(self, stage: float) -> Label | None:
        last: Row = {}
        for events in self._events:
            happened = np.flatnonzero((events["t"] <= stage) & (events["kind"] != EVENT_KINDS["end"]))
            if len(happened):
                last = {name: column[happened[-1]].item() for name, column in events.items()}
        label = met(self._known, self._scene, self._at, last)
        return label or _reached_at_returns(
            replace(self._scene, t_end=stage).without_samples(), self._at, self._known
        )


def _reached_at_returns(scene: Scene, at: Coordinates, known: KnownOrbits) -> Label | None:
    """Label of a run that nothing drives, by where it meets the section, where an orbit without events is
    known; None where it comes to none.
    """
    if not any(one.around for one in known.orbits):
        return None
    try:
        times, states = returns(scene, at)
    except OrbitError:
        return None
    return known.reached(times, at.of(states)) if len(times) else None


def _stages(scene: Scene, begin: float) -> Iterator[float]:
    """Ends [s] of the stages up to `begin`."""
    end = FIRST_STAGE * _pace(scene)
    while end < begin:
        yield end
        end *= 2
    if begin > 0:
        yield begin


def _pace(scene: Scene) -> float:
    """About how long one return to the section takes [s]."""
    return float(source_period(scene)) if is_driven(scene) else slowest_period(scene)


# Orbits on which the probes end, known to all points of their scene.


KEPT = 64  # scenes whose orbits a worker remembers

_orbits: OrderedDict[tuple[Any, ...], KnownOrbits] = OrderedDict()
_locks: dict[tuple[Any, ...], threading.Lock] = {}
_guard = threading.Lock()


def known_orbits(settings: Any, changes: Mapping[str, str], ask: Callable[[], None]) -> KnownOrbits:
    """The orbits that the probes of a sweep end on, at the parameters of a point.

    settings : a `PointSettings`; changes : of a point. A worker finds them once for each scene.
    """
    if not settings.probes:
        return KnownOrbits()
    parameters = tuple(sorted((k, v) for k, v in changes.items() if not k.startswith(INITIAL)))
    key = parameters, *settings.for_probes
    with _guard:
        lock = _locks.setdefault(key, threading.Lock())
    with lock:
        if key not in _orbits:
            known = _of_probes(settings, dict(parameters), ask)
            with _guard:
                _orbits[key] = known
                while len(_orbits) > KEPT:
                    _locks.pop(_orbits.popitem(last=False)[0], None)
        return _orbits.get(key, KnownOrbits())


def _of_probes(settings: Any, parameters: dict[str, str], ask: Callable[[], None]) -> KnownOrbits:
    known = KnownOrbits()
    for probe in settings.probes:
        try:
            case = settings.point_case({**parameters, **probe})
            scene = sampled_for_statistics(case.scene(), settings.every)
            begin = settings.discard.time(scene.t_end)
            label = run_label(scene, settings.of, begin, ask, known)
            if isfinite(label.time):  # it ends on an orbit that is known
                continue
            orbit = orbit_of_label(scene, label.state, label.period)
            if orbit is not None:
                known.add(orbit)
        except (CaseError, EngineError, OrbitError, TooFineError):
            continue
    return known


def run_label(
    scene: Scene, of: Quantities, begin: float, ask: Callable[[], None], known: KnownOrbits
) -> Label:
    """Label of a run: early where that is sure, else at its end. Raises EngineError where the run fails."""

    def go_on() -> bool:
        ask()
        return True

    computation = AttractorComputation(Task(scene, of, begin, 0, known))
    early = EarlyLabel(scene, begin, known) if known else None
    run = MeasuredRun(scene, of, begin, go_on, early=early)
    for block in run.blocks():
        computation.update(block)
    label = early.label if early else None
    return label or computation.label((begin, run.t_reached), run)


def orbit_of_label(scene: Scene, state: np.ndarray, period: float, case: Case | None = None) -> Orbit | None:
    """The orbit whose label has this state and period; None for what is no orbit. Raises OrbitError."""
    if not period > 0:
        return None
    return_map = ReturnMap(scene, int(period))
    return least(Orbit(return_map, solve(return_map, state), case))
