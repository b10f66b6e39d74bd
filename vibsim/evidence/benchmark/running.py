"""Run a bench: the truth, then row after row, each kept on file as it comes and judged by the truth.

Of an attempt are judged its error at every instant, until when it is faithful, and its events.
"""

import json
import platform
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from importlib.metadata import PackageNotFoundError, version
from math import ceil, inf, nan, pi
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.engine.blocks_ahead import available_cores
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.error_growth import error_growth
from vibsim.evidence.benchmark.bench_result import (
    DONE,
    FAILED,
    SLOWER,
    BenchResult,
    BenchRow,
    BenchTruth,
    EventCount,
    displacements_of,
    faithful_error,
    open_bench,
    write_bench,
)
from vibsim.evidence.benchmark.plan import NOT_TRUTH, BenchError, BenchPlan, SolverFamily
from vibsim.evidence.peers.solvers import Attempt, TimeLimit
from vibsim.evidence.verification.checks import Event, match_events, reach
from vibsim.physics.parts import EVENT_KINDS, EVENT_NAMES, Scene
from vibsim.physics.rates import natural_rates, source_rates
from vibsim.results.file_contents import provenance
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.many_digits import DigitsPlan, TruthMemory, TruthRecording
from vibsim.results.output_files import check_result_output

Watch = Callable[[str, float], bool]  # given what is done and how far it is [0 to 1]; False stops the bench


def run_bench(
    plan: BenchPlan,
    path: str | Path | None = None,
    truth: BenchTruth | None = None,
    force: bool = False,
    watch: Watch = lambda what, share: True,
) -> BenchResult | None:
    """Run a bench, into a file where `path` is given; None where `watch` stopped it before its truth.

    Parameters
    ----------
    truth : what an earlier bench of the same fingerprint knows; computed when None
    force : replace an existing file

    When `watch` says False the row under way is given up and the bench ends with those before it, its
    attribute `complete` 0. Raises EngineError when the truth cannot be computed, MultiprecisionMissing
    where the engine was not built on words, ResultFileError when the file cannot be written.
    """
    target = None if path is None else check_result_output(path, force)
    if truth is None:
        truth = compute_truth(plan, lambda t: watch("truth", t / plan.times[-1]))
    if truth is None:
        return None
    attrs: dict[str, Any] = {**origin(plan), "complete": 0}
    rows: list[BenchRow] = []

    def keep() -> None:
        if target is not None:
            write_bench(target, attrs, plan.case.scene(), truth, rows)

    keep()
    scene, entries = plan.case.scene(), list(plan.rows())
    for i, (family, setting) in enumerate(entries):
        at = f"{family.name}, {setting}", i / len(entries)
        if not watch(*at):
            break
        row = measure(family, setting, scene, truth, plan.limit, lambda at=at: watch(*at))  # type: ignore[misc]
        if not watch(*at):
            break
        rows.append(row)
        keep()
    else:
        attrs["complete"] = 1
        keep()
    return BenchResult({**attrs, **truth.attrs}, truth, rows)


# Run a method at a setting, several times where it is fast, and note what it takes.


ENOUGH = 0.5  # s of runs of which the least is taken
MOST_RUNS = 25


def measure(
    family: SolverFamily,
    setting: str,
    scene: Scene,
    truth: BenchTruth,
    limit: float,
    going_on: Callable[[], bool],
) -> BenchRow:
    """The row of `family` at `setting`: timed, counted and judged by the truth.

    A run is stopped after `limit` seconds, or when going_on() says False. Whatever a method fails with
    becomes the row's problem.
    """
    times = truth.samples["time"]
    clocks: list[tuple[float, float]] = []
    try:
        setup, peer = _timed(family.opener(scene, setting))
        while True:
            clock, attempt = _timed(lambda: peer.run(times, TimeLimit(limit, going_on)))
            clocks.append(clock)
            if attempt.stopped or sum(wall for wall, _ in clocks) > ENOUGH or len(clocks) == MOST_RUNS:
                break
    except (ArithmeticError, ValueError, EngineError) as error:
        return BenchRow(family.name, setting, FAILED, _sentence(error), error=np.full(len(times), np.nan))
    judged = score(attempt, truth, scene)
    return BenchRow(
        family.name,
        setting,
        SLOWER if attempt.stopped else DONE,
        wall_time=min(wall for wall, _ in clocks),
        cpu_time=min(cpu for _, cpu in clocks),
        setup_time=setup[0],
        runs=len(clocks),
        steps=attempt.steps,
        evaluations=-1 if attempt.evaluations is None else attempt.evaluations,
        t_reached=float(attempt.t_reached),
        faithful_time=judged.faithful_time,
        error=judged.error,
        events=judged.events,
    )


def _timed(call: Callable[[], Any]) -> tuple[tuple[float, float], Any]:
    """(wall time, CPU time) [s] of call(), and what it returns."""
    wall, cpu = time.perf_counter(), time.process_time()
    answer = call()
    return (time.perf_counter() - wall, time.process_time() - cpu), answer


def _sentence(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__


# An attempt judged by the truth: its error at every instant, until when it is faithful, its events.


# The truth that a bench judges by: the case run once with digits to spare, kept as the nearest doubles.


RIGHT = 20  # digits at the end: the error of a double has 16, and two of it are to be told
FEWEST = 30
GUESS = 16.0  # digits lost over a run that fails in doubles


def compute_truth(plan: BenchPlan, watch: Callable[[float], bool] | None = None) -> BenchTruth | None:
    """The truth of a plan; None where `watch`, given the time reached [s], says False.

    Raises EngineError when the run fails, MultiprecisionMissing where the engine was not built on words.
    """
    began = time.perf_counter()
    digits = max(FEWEST, ceil(_lost(plan)) + RIGHT + 2)
    while True:
        recording = TruthRecording(plan.case, digits)
        sink = TruthMemory(recording)
        recording.into(sink, watch)
        if not recording.complete:
            return None
        verdict = DigitsPlan(plan.case, digits).verdict(recording.end_state, recording.events())
        right = verdict.get("digits_right", 0)
        if right >= RIGHT:
            break
        digits += RIGHT - right + 2
    samples, events = sink.tables()
    attrs = {
        "truth_digits": digits,
        "truth_digits_right": right,
        "truth_library": recording.start["number_library"],
        "truth_wall_time_s": time.perf_counter() - began,
    }
    columns = {name: column for name, column in samples.items() if column.dtype == "f8"}
    return BenchTruth(plan.fingerprint, columns, {name: events[name] for name in ("t", "kind")}, attrs)


def _lost(plan: BenchPlan) -> float:
    """Digits lost over the span, about."""
    try:
        return error_growth(plan.case.scene())
    except EngineError:
        return GUESS


# Events found, missed and made up, kind by kind.
#
# A found event is a true one where it is of the same kind and near: not farther than half the way to the next
# true event of that kind, so that the windows of two true events never overlap, and not farther than a
# quarter of the shortest period of the motion, beyond which the blocks are doing something else.


def _reach(events: Sequence[Event]) -> list[float]:
    """Half the time [s] from each event to the nearest of its kind at another instant: those of one kind at
    one instant are of several parts.
    """
    instants = list(dict.fromkeys(events))
    halves = dict(zip(instants, reach(instants), strict=True))
    return [halves[event] for event in events]


def count_events(
    true: Mapping[str, np.ndarray], events: Sequence[tuple[float, int]], until: float, widest: float
) -> dict[str, EventCount]:
    """Counts of the events up to `until` [s] by name of kind, for every kind that has a code.

    true : columns t [s], kind; events : (time [s], kind), ascending; widest : half width of the widest
    window [s]. The first event in a window is the true one, others in it are spurious.
    """
    truth = [
        (EVENT_NAMES[kind], Decimal(t))
        for t, kind in zip(true["t"].tolist(), true["kind"].tolist(), strict=True)
    ]
    named = [(EVENT_NAMES[kind], Decimal(t)) for t, kind in events]
    within = [min(half, widest) for half in _reach(truth)]
    matching = match_events(truth, within, named)
    hits = Counter(truth[i][0] for i, _ in matching.pairs if truth[i][1] <= until)
    missed = Counter(truth[i][0] for i in matching.missed if truth[i][1] <= until)
    spurious = Counter(named[j][0] for j in matching.spurious if named[j][1] <= until)
    return {name: EventCount(hits[name], missed[name], spurious[name]) for name in EVENT_KINDS}


@dataclass(frozen=True)
class Score:
    """error : largest error of the displacements at each instant [m], NaN beyond the end of the attempt;
    faithful_time : until when it stays within `faithful_error` [s]; events : counts until then by kind, of
    the kinds that the method reports
    """

    error: np.ndarray
    faithful_time: float
    events: dict[str, EventCount] = field(default_factory=dict)


def score(attempt: Attempt, truth: BenchTruth, scene: Scene) -> Score:
    """Judge an attempt at the instants of the truth."""
    time = truth.samples["time"]
    error = np.full(len(time), nan)
    reached = min(len(attempt.states), len(time))
    error[:reached] = displacement_error(attempt.states[:reached], truth, displacements_of(scene))
    faithful = faithful_time(time, error, faithful_error(truth, scene))
    counts = count_events(truth.events, attempt.events, faithful, shortest_period(scene) / 4)
    return Score(error, faithful, {name: counts[name] for name in attempt.kinds})


def displacement_error(states: np.ndarray, truth: BenchTruth, names: Sequence[str]) -> np.ndarray:
    """Largest error [m] of the displacements `names` in the states (rows, at the truth's first instants)."""
    apart = [np.abs(states[:, 2 * i] - truth.samples[name][: len(states)]) for i, name in enumerate(names)]
    return np.asarray(np.maximum.reduce(apart))


def faithful_time(time: np.ndarray, error: np.ndarray, allowed: float) -> float:
    """The last instant [s] before the error passes the `allowed` one [m], or is not known."""
    lost = np.flatnonzero(~(error <= allowed))
    return float(time[max(lost[0] - 1, 0)] if len(lost) else time[-1])


def shortest_period(scene: Scene) -> float:
    """Shortest period in the motion [s]: of vibration with all stops in contact, or of a source."""
    fastest = max([*source_rates(scene), *natural_rates(scene, scene.stops)], default=0.0)
    return 2 * pi / fastest if fastest else inf


# The root attributes of a bench file: what was measured, by what, on what machine.


PACKAGES = ("scipy", "heyoka")


def origin(plan: BenchPlan) -> dict[str, Any]:
    """Attributes that are known before the first row."""
    scene = plan.case.scene()
    return {
        **provenance("bench", plan.case),
        "t_end_s": float(scene.t_end),
        "check_times_s": plan.check_times,
        "limit_s": plan.limit,
        "methods": json.dumps([family.name for family in plan.families]),
        "not_installed": json.dumps([family.name for family in plan.absent()]),
        "cores": available_cores(),
        "processor": processor(),
        **{f"{package}_version": version_of(package) for package in PACKAGES},
    }


def version_of(package: str) -> str:
    """Version of an installed package, or the word none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"


def processor() -> str:
    """Name of the processor, as far as the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            names = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.processor() or platform.machine()


def truth_from(plan: BenchPlan, path: str | Path) -> BenchTruth:
    """The truth in the bench file `path`. Raises ResultFileError where it is no such file, BenchError where
    the truth in it is not that of `plan`, with what differs.
    """
    bench = open_bench(path)
    if bench.truth.fingerprint != plan.fingerprint:
        raise BenchError(
            f"{path}: its truth is of another case; it differs in {', '.join(_differences(plan, bench))}"
        )
    return bench.truth


def truth_at_hand(plan: BenchPlan, path: str | Path) -> BenchTruth | None:
    """The same; None where there is none."""
    try:
        return truth_from(plan, path)
    except (ResultFileError, BenchError):
        return None


def _differences(plan: BenchPlan, bench: BenchResult) -> list[str]:
    ours, theirs = ({k: str(v) for k, v in case.values.items()} for case in (plan.case, bench.case))
    keys = [key for key in {**ours, **theirs} if key not in NOT_TRUTH and ours.get(key) != theirs.get(key)]
    return [f"{key} ({theirs.get(key, 'none')} there, {ours.get(key, 'none')} here)" for key in keys]
