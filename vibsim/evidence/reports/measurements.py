"""Measurements of runs and cases: plain numbers that JSON can hold, and the claims are judged by."""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, wait
from dataclasses import asdict, is_dataclass, replace
from functools import partial
from hashlib import sha256
from math import pi
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim import __version__
from vibsim.analysis import (
    Capture,
    count_impacts,
    find_frequencies,
    judge_capture,
    judge_regime,
    largest_exponent,
    measure_drift,
)
from vibsim.analysis.capture import CAPTURE
from vibsim.analysis.cycles import BAND, run_up_time
from vibsim.analysis.drift import STILL
from vibsim.cases import load_case
from vibsim.cases.validation import derived_facts
from vibsim.engine.blocks_ahead import available_cores
from vibsim.engine.errors import EngineError
from vibsim.physics import elementary
from vibsim.physics.elementary import mean
from vibsim.results import Result, ResultFileError, open_trajectory_file, simulate, simulate_to_file
from vibsim.results.output_files import output_file
from vibsim.results.recording import Watch
from vibsim.results.result import Window, rows_within

if TYPE_CHECKING:
    from vibsim.cases import Case


Numbers = dict[str, Any]
Tell = Callable[[str, int, int], bool]  # given what is done, how much of it, and of how much; False to stop

SMOOTHED = 5.0  # [s] many periods of every source: what a displacement is averaged over to find its peak
STATES = ("x1", "x2", "v1", "v2")


def measure_run(result: Result) -> Numbers:
    """All that the report needs to know of one run; lengths in m, times in s, frequencies in Hz."""
    scene, attrs = result.case.two_blocks(), result.attrs
    facts: Numbers = {
        "case_sha256": attrs["case_sha256"],
        "title": result.case.title,
        "t_end": result.t_reached,
        "trust_horizon": result.trust_horizon,
        "impacts": attrs["impacts"],
        "sticks": attrs["sticks"],
        "energy_residual_relative": attrs.get("energy_residual_relative"),
        "how": attrs.get("comment", ""),
        "rest_distance_needed": attrs.get("rest_distance_needed"),
        "greatest": {name: greatest(result[name]) for name in STATES},
        "steady": steady_amplitudes(result),
        "drift": plain(measure_drift(result)),
        "overall": overall_rate(result),
        "cycles": plain(count_impacts(result)),
        "frequencies": plain(find_frequencies(result)),
        "peak": displacement_peak(result.time, result["x2"]),
    }
    if scene.has_motor:
        capture = capture_of(result)
        facts["capture"] = plain(capture)
        if capture.since is not None:
            held = (capture.since, capture.until or result.t_reached)
            facts["held"] = {**plain(find_frequencies(result, held)), "reach": reach_at_end(result, held)}
    return facts


def capture_of(result: Result) -> Capture:
    """The verdict on capture, with the longest hold where none counts because the end is undecided.

    A motor that was let go was so whether or not its speed has settled by the end.
    """
    capture = judge_capture(result)
    if capture.verdict == "undecided" and capture.since is None and capture.holds:
        hold = max(capture.holds, key=lambda one: one.delay)
        return replace(capture, since=hold.begin, until=hold.end, speed_hz=hold.speed_hz)
    return capture


def greatest(values: np.ndarray) -> float:
    """Largest magnitude."""
    return float(np.abs(values).max())


def steady_amplitudes(result: Result) -> Numbers:
    """Greatest |v1|, |v2| and |x1 - x2| less its mean, over the second half of a run: drift left out."""
    rows = rows_within(result.time, (result.t_reached / 2, result.t_reached))
    y = result["x1"][rows] - result["x2"][rows]
    return {
        "relative": greatest(y - mean(y)),
        "v1": greatest(result["v1"][rows]),
        "v2": greatest(result["v2"][rows]),
    }


def overall_rate(result: Result) -> float:
    """Displacement of block 2 at the end over the whole time [m/s], start included."""
    return float(result["x2"][-1] - result["x2"][0]) / result.t_reached


def drifts(drift: Numbers) -> bool:
    """Whether a measured drift can be told from nothing."""
    return drift["rate"] is not None and bool(abs(drift["rate"]) > max(drift["half_width"], STILL))


def reach_at_end(result: Result, hold: Window) -> Numbers:
    """Greatest x1 - x2 [m] in the last 5 s of a hold, and in the 5 s that end 50 s before its end."""
    begin, end = hold
    last, before = (end - SMOOTHED, end), (end - 50.0 - SMOOTHED, end - 50.0)
    reach: Numbers = {"last": None, "before": None}
    for key, window in (("last", last), ("before", before)):
        rows = rows_within(result.time, window)
        if window[0] >= begin and rows.stop > rows.start:
            reach[key] = float((result["x1"][rows] - result["x2"][rows]).max())
    return reach


def displacement_peak(time: np.ndarray, x: np.ndarray) -> Numbers:
    """Time [s] of the greatest x [m], averaged over SMOOTHED; its height then, and at the end."""
    width = max(1, round(SMOOTHED / float(time[1] - time[0])))
    sums = np.cumsum(np.concatenate([[0.0], x]))  # one after the other, whatever the processor
    smooth = (sums[width:] - sums[:-width]) / width
    at = int(np.argmax(smooth))
    middle = float(mean(time[at : at + width]))
    return {"time": middle, "height": float(smooth[at]), "end": float(smooth[-1])}


def plain(value: Any) -> Any:
    """A verdict as JSON has it: dataclasses and mappings as objects, tuples as lists, numbers as such."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


# Ensembles of perturbed starts: what of a chaotic run would be so with any start that looks the same.
#
# Beyond the trust horizon a single run proves nothing. What nearly all runs from neighbouring starts have in
# common is a property of the system all the same; what they do not is chance.


EVERY = "100 ms"  # half a turn of the motor: its mean speed over 12 turns is known to 1 %
STEP = 5e-5  # [m] between neighbouring starts of block 1: a twentieth of the gap
EACH_WAY = 24


def starts() -> list[float]:
    """Displacements x1(0) [m]: 24 to either side of rest, rest itself left out."""
    return [k * STEP for k in range(-EACH_WAY, EACH_WAY + 1) if k]


def measure_ensemble(case: Case, advance: Advance) -> Numbers:
    """Numbers of a case from each start; raises Interrupted when `advance` returns False."""
    members = from_starts(case)
    return {
        "starts": starts(),
        "outcomes": run_all([partial(member_outcome, each) for each in members], advance),
    }


def from_starts(case: Case) -> list[Case]:
    """The case from each of the perturbed starts."""
    return [case.with_values({"initial.x1": f"{start:.4g} m"}) for start in starts()]


def member_outcome(case: Case) -> Numbers:
    """The motion of a member and, with a motor, what becomes of it; {"failed": why} where it breaks down."""
    try:
        result = simulate(case.with_values({"run.every": EVERY}), trust=False)
    except EngineError as error:
        return {"failed": str(error)}
    motor = outcome_of(result) if case.two_blocks().has_motor else {}
    return {**motor, **motion_of(result)}


def motion_of(result: Result) -> Numbers:
    """Drift rates [m/s], impacts over the whole run, impacts in each cycle, vibration and regime."""
    cycles, regime = count_impacts(result), judge_regime(result)
    return {
        "drift": measure_drift(result).rate,
        "overall": overall_rate(result),
        "impacts": int(result.attrs["impacts"]),
        "cycles": cycles.verdict,
        "one_per_cycle": set(cycles.impact_counts or ()) == {1},
        "steady": steady_amplitudes(result),
        "regime": regime.verdict,
        "period": regime.period,
    }


# Many short looks at motor runs: what each comes to, without files and without a trust horizon.
#
# For ensembles of starts and for searches over parameters, where hundreds of runs are needed and of each only
# the verdict.


PATIENCE = 0.1  # [s] until an interruption is noticed
Advance = Callable[[int, int], bool]  # given how many are done, and of how many; False to stop


def run_all(jobs: Sequence[Callable[[], Numbers]], advance: Advance) -> list[Numbers]:
    """Results of the jobs, all cores at work: the C engine lets go of the interpreter while it computes.

    Raises Interrupted when `advance` returns False. Nobody waits then for the jobs under way, which may take
    seconds, but the process at its end: a daemon thread, which Python ends wherever it is, may hold the lock
    of h5py, for which the end of the process would wait for ever.
    """
    results: list[Future[Numbers]] = [Future() for _ in jobs]
    waiting = deque(zip(jobs, results, strict=True))
    for _ in range(available_cores()):
        Thread(target=_work_off, args=(waiting,)).start()
    try:
        while pending := wait(results, PATIENCE).not_done:
            if not advance(len(jobs) - len(pending), len(jobs)):
                raise MeasurementInterrupted
    finally:
        waiting.clear()
    advance(len(jobs), len(jobs))
    return [result.result() for result in results]


def _work_off(waiting: deque[tuple[Callable[[], Numbers], Future[Numbers]]]) -> None:
    """In a thread: take job after job, until none waits."""
    while waiting:
        try:
            job, result = waiting.popleft()
        except IndexError:  # another thread was faster
            return
        try:
            result.set_result(job())
        except BaseException as error:
            result.set_exception(error)


def outcome_of(result: Result) -> Numbers:
    """Capture verdict with its hold and the final speed [Hz], drift rate [m/s], and peak of x2."""
    capture, drift = capture_of(result), measure_drift(result)
    return {
        "verdict": capture.verdict,
        "since": capture.since,
        "until": capture.until,
        "speed_hz": capture.speed_hz,
        "final_hz": capture.final_speed_hz,
        "drift": drift.rate,
        "peak": displacement_peak(result.time, result["x2"]),
    }


# The table of measured numbers on file, section by section, so that nothing is measured twice.
#
# A section carries the fingerprint of what it was measured from: cases, settings and version. One whose
# fingerprint is right is taken as it stands, whoever wrote it; the others are measured again.


MEASURES = 4  # goes up when what is measured of the same runs changes


class NumbersFile:
    """Sections by name in a JSON file, written whenever one is added.

    path : the file; one that is there and readable is taken up, unless `fresh`
    """

    def __init__(self, path: Path, fresh: bool = False):
        self.path = path
        self._stored = {} if fresh else _read(path)
        self.sections: dict[str, Any] = {}

    def section(self, name: str, made_of: object, measure: Callable[[], Any]) -> Any:
        """The section `name`: as stored where it was made of the same, else measured and stored."""
        print_of = fingerprint(made_of)
        stored = self._stored.get(name)
        if isinstance(stored, Mapping) and stored.get("fingerprint") == print_of and "numbers" in stored:
            self.sections[name] = stored["numbers"]
        else:
            self.sections[name] = measure()
            self._stored[name] = {"fingerprint": print_of, "numbers": self.sections[name]}
            self._write()
        return self.sections[name]

    def _write(self) -> None:
        with output_file(self.path, force=True, encoding="utf-8") as file:
            file.write(json.dumps(self._stored, indent=1, allow_nan=False, ensure_ascii=False) + "\n")


def fingerprint(made_of: object) -> str:
    """Of anything that JSON can hold, and of this version of vibsim and of what it measures."""
    text = json.dumps([__version__, MEASURES, made_of], sort_keys=True, default=str)
    return sha256(text.encode()).hexdigest()


def _read(path: Path) -> dict[str, Any]:
    """The sections on file; none where the file is missing or not one of these."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stored if isinstance(stored, dict) else {}


# The runs behind a report: simulated once, and read again as long as they are of the same case.
#
# A trajectory is taken over when its file holds a whole run of this case by this version of vibsim, with its
# trust horizon. Anything else at its place is replaced.


PRINTED = ("I-A", "I-B", "I-C")
EQUAL_FORCE = ("I-A-eq211", "I-B-eq211", "I-C-eq211")
MOTORS = ("II-A", "II-B", "II-C")
HERTZ = ("3.5", "5.5", "6.5")  # of A, B and C
PRINTED_MOTOR = "II-B"  # which the readings are readings of
SHIPPED_READINGS = ("II-B-captured", "II-C-escape")
PAPER_RUNS = (*PRINTED, *EQUAL_FORCE, *MOTORS, *SHIPPED_READINGS)


class MeasurementInterrupted(Exception):
    """The user has asked to stop; what was finished is on file."""


def obtain_run(
    case: Case, folder: Path, watch: Watch | None = None, fresh: bool = False
) -> tuple[Result, bool]:
    """The run of a case in FOLDER/NAME.h5, and whether it was simulated: where it had to be, or if `fresh`.

    Raises EngineError when the run fails, ResultFileError when the file cannot be written, and Interrupted
    when `watch` returns False before the end.
    """
    path = folder / f"{case.name}.h5"
    stored = None if fresh else stored_run(case, path)
    if stored is not None:
        return stored, False
    result = simulate_to_file(case, path, force=True, watch=watch)
    if not result.complete:
        raise MeasurementInterrupted
    return result, True


def stored_run(case: Case, path: Path) -> Result | None:
    """The run on file, if it is whole and of this very case and version."""
    if not path.is_file():
        return None
    try:
        result = open_trajectory_file(path)
        attrs = result.attrs
    except ResultFileError:
        return None
    same = (attrs.get("case_sha256"), attrs.get("vibsim_version")) == (case.sha256, __version__)
    return result if same and attrs.get("complete") and "trust_horizon_s" in attrs else None


# Runs of the paper's cases, and what follows from the numbers of the cases alone.


LONG = {"run.t_end": "3000 s", "run.every": "10 ms"}  # ten times the paper's span: where motions settle
INERTIAS = (0.001, 0.0085)  # [kg m^2] as printed, and of the readings
HELD_HZ = 3.69


def measure_runs(results: Mapping[str, Result], advance: Advance) -> Numbers:
    """Numbers of every run, its regime among them; of a reading also what it changes."""
    measured = run_all([partial(_measured, result) for result in results.values()], advance)
    return dict(zip(results, measured, strict=True))


def _measured(result: Result) -> Numbers:
    case = result.case
    changes = changes_of(case) if case.name in SHIPPED_READINGS else {}
    return {**measure_run(result), "regime": regime_of(result), "changes": changes}


def changes_of(case: Case) -> dict[str, list[str]]:
    """Changes of a reading against the case that it is a reading of: key -> [now, as printed]."""
    printed = load_case(case.name[:4])
    changed = [key for key in case.numeric_keys() if case.quantity(key) != printed.quantity(key)]
    return {key.split(".")[-1]: [str(each.quantity(key)) for each in (case, printed)] for key in changed}


def measure_long_runs(cases: Mapping[str, Case], advance: Advance) -> Numbers:
    """The regime that each motion settles in."""
    runs = run_all([partial(_long_run, case) for case in cases.values()], advance)
    return dict(zip(cases, runs, strict=True))


def _long_run(case: Case) -> Numbers:
    result = simulate(case.with_values(LONG), trust=False)
    return {"regime": regime_of(result)}


def regime_of(result: Result) -> Numbers:
    """The verdict on the regime, the largest Lyapunov exponent among its evidence."""
    regime: Numbers = plain(judge_regime(result, exponent=largest_exponent(result)))
    return regime


def measure_facts(cases: Mapping[str, Case]) -> Numbers:
    """Consequences of the numbers of the cases alone: natural frequencies [Hz] and amplitudes [N]."""
    facts = {kind: {fact.name: fact.value for fact in derived_facts(cases[name].scene())}
             for kind, name in (("I", "I-A"), ("II", "II-A"))}  # fmt: skip
    return {
        "held_hz": facts["I"]["block 1 on its spring"],
        **{f"free_hz_{kind}": facts[kind]["free"] for kind in facts},
        **{f"bilinear_hz_{kind}": facts[kind]["bilinear"] for kind in facts},
        "least_hold_s": {f"{J:g}": least_hold(cases[MOTORS[2]], J) for J in INERTIAS},
        "characteristics": [_characteristic(cases[name]) for name in MOTORS],
        "amplitudes": [
            _amplitudes(*names, cases) for names in zip(PRINTED, EQUAL_FORCE, MOTORS, strict=True)
        ],
    }


def _characteristic(case: Case) -> Numbers:
    """No-load speed [Hz], torque at standstill [N m] and slope [N m s] of a motor's line."""
    scene = case.two_blocks()
    return {"no_load_hz": scene.Omega0 / (2 * pi), "M0": scene.M0, "slope": scene.M0 / scene.Omega0}


def at_voltage(case: Case, motor: Case) -> dict[str, str]:
    """Changes that make of a case the motor of another, at the voltage of the no-load speed of the case.

    On a DC motor with a constant field M0 = kt V / R and Omega0 = V / ke are both proportional to V.
    """
    one, other = (_characteristic(each) for each in (case, motor))
    return {"excitation.M0": f"{other['slope'] * one['M0'] / one['slope']!r} N m"}


def least_hold(case: Case, inertia: float) -> float:
    """Shortest hold near half the bilinear frequency that counts as capture [s], at an inertia [kg m^2]."""
    scene = case.with_values({"excitation.J": inertia}).scene()
    motor = scene.motor
    assert motor is not None
    no_load = motor.Omega0 / (2 * pi)
    slow, fast = (HELD_HZ * (1 + sign * BAND) for sign in (-1, 1))
    return CAPTURE * run_up_time(motor) * elementary.log((no_load - slow) / (no_load - fast))


def unbalance(cases: Mapping[str, Case]) -> float:
    """m3 e of the motor as printed [kg m]."""
    scene = cases[MOTORS[0]].two_blocks()
    return float(scene.m3 * scene.e)


def _amplitudes(printed: str, equal: str, motor: str, cases: Mapping[str, Case]) -> Numbers:
    ideal, by_rule, scene = (cases[name].two_blocks() for name in (printed, equal, motor))
    return {
        "omega_hz": ideal.omega / (2 * pi),
        "printed": ideal.A,
        "eq211": by_rule.A,
        "m3_e_omega": scene.m3 * scene.e * ideal.omega,
    }
