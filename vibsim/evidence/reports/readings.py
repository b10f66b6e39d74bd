"""Readings of the printed numbers under which the paper's account of II-B and II-C holds, ranked.

Table 1 has the amplitudes m3 e omega, so m3 e = 0.0033 kg m is fixed by it, and a reading that changes m3 or
e contradicts it. The others leave J, c, M0 and mu; `vibsim fit` found that M0 and mu do not help.
"""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from math import isclose, pi
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim import __version__
from vibsim.analysis import count_impacts, judge_capture, judge_regime, largest_exponent, measure_drift
from vibsim.cases import load_case
from vibsim.engine.blocks_ahead import available_cores
from vibsim.engine.errors import EngineError
from vibsim.evidence.reports.measurements import EVERY as measurements_EVERY
from vibsim.evidence.reports.measurements import (
    PRINTED,
    PRINTED_MOTOR,
    SHIPPED_READINGS,
    Advance,
    MeasurementInterrupted,
    Numbers,
    Tell,
    drifts,
    from_starts,
    outcome_of,
    overall_rate,
    plain,
    run_all,
)
from vibsim.fitting.fit_result import facts, run_fit
from vibsim.fitting.plan import Search, make_plan
from vibsim.orbits.branches.branch import Branch, BranchStore, read_branch
from vibsim.orbits.branches.continuing import orbit_from
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.branches.tracing import MOST_POINTS
from vibsim.physics.parts import EVENT_KINDS
from vibsim.plots.branch_curves import amplitude_of
from vibsim.plots.load_curves import dead_ends, torque_of
from vibsim.results import Result, ResultFileError, simulate

if TYPE_CHECKING:
    from vibsim.cases import Case


# The same cases with the stop out of reach, or with wider gaps: what of their motion impacts cause.


NO_STOP = {"stop.G": "1000 m"}  # a gap that no motion closes
AS_LONG = {**NO_STOP, "run.every": "50 ms"}
SETTLED = {**AS_LONG, "run.t_end": "10000 s"}  # free vibration dies out as exp(-t/540 s), c = 0.001 N s/m


GAPS_MM = tuple(float(f"{400 ** (k / 26):.3g}") for k in range(27))  # 1 to 400 mm, in equal factors


def measure_without_stop(cases: Sequence[Case], advance: Advance) -> Numbers:
    """For each case by name: drift over the same time, and the regime that it settles in; of the printed
    cases with an ideal source also the median overall rate of perturbed starts [m/s], and how many drift.
    """
    runs = run_all([partial(_measured, case) for case in cases], advance)
    return {case.name: numbers for case, numbers in zip(cases, runs, strict=True)}


def _measured(case: Case) -> Numbers:
    run, settled = (simulate(case.with_values(changes), trust=False) for changes in (AS_LONG, SETTLED))
    capture = plain(judge_capture(run)) if case.two_blocks().has_motor else None
    return {
        "drift": plain(measure_drift(run, orbit_rates=judge_regime(run).drift_rates)),
        "overall": overall_rate(run),
        "impacts": int(run.attrs["impacts"]) + int(settled.attrs["impacts"]),
        "regime": _regime_without_stop(settled),
        "capture": capture,
        **(_of_starts(case) if case.name in PRINTED else {}),
    }


def _of_starts(case: Case) -> Numbers:
    runs = [simulate(each, trust=False) for each in from_starts(case.with_values(AS_LONG))]
    return {
        "starts_overall": median(abs(overall_rate(run)) for run in runs),
        "starts_drifting": sum(drifts(plain(measure_drift(run))) for run in runs),
    }


def measure_gaps(case: Case, advance: Advance) -> list[Numbers]:
    """For each of GAPS_MM: what a motor does from rest, and its impacts in the second half of the run."""
    return run_all([partial(_with_gap, case, gap) for gap in GAPS_MM], advance)


def _with_gap(case: Case, gap_mm: float) -> Numbers:
    result = simulate(
        case.with_values({"stop.G": f"{gap_mm:g} mm", "run.every": measurements_EVERY}), trust=False
    )
    late = count_impacts(result)
    return {"gap_mm": gap_mm, **outcome_of(result), "impacts_per_turn": late.impacts}


def _regime_without_stop(result: Result) -> Numbers:
    regime: Numbers = plain(judge_regime(result))
    return regime


@dataclass(frozen=True)
class ReadingWords:
    """A statement on the motors, as `vibsim fit` takes it, and as the head of a column."""

    text: str
    head: str


# "captured" as `vibsim analyse` has it; about 100 s: a factor 1.5 to either side; 6.2 Hz and 170 s rounded
STATEMENTS = (
    ReadingWords("II-B: captured until the end", "II-B captured for good"),
    ReadingWords("II-C: held for at least 30 s", "II-C held 30 s or longer"),
    ReadingWords("II-C: passes 4.5 Hz between 67 and 150 s", "away 67 to 150 s after the start"),
    ReadingWords("II-C: settles between 6.1 and 6.3 Hz", "ends at 6.1 to 6.3 Hz"),
    ReadingWords("II-C: x2 peaks between 150 and 190 s", "x2 greatest at 150 to 190 s"),
    ReadingWords("II-C: x2 falls at least 10 %", "then falls by 10 %"),
    ReadingWords("II-B: held at 4 to 4.2 Hz", "II-B held at 4.1 Hz"),
)
WITHOUT_STOP = f"G={NO_STOP['stop.G']}"
SHIPPED = "J=0.0085 kg m^2, c=0.0035 N s/m"  # II-B-captured, II-C-escape
READINGS = (
    SHIPPED,
    "J=0.006 kg m^2, c=0.005 N s/m",
    "J=0.008 kg m^2, c=0.004 N s/m",
    "J=0.010 kg m^2, c=0.003 N s/m",
    "J=0.0085 kg m^2, c=0.0014 N s/m",
    "J=0.008 kg m^2",
    "J=0.010 kg m^2",
    "c=0.024 N s/m",
    "c=0.03 N s/m",
    "c=0.049 N s/m",
    "mu=0.014",
    "M0=0.004 N m",
    "m3=54 g",
    "m3=62 g, c=0.00175 N s/m",
    "G=252 mm",
    WITHOUT_STOP,
)
FREE = {"J": "0.5:20 g m^2", "c": "0.001:0.05 N s/m"}
SPREAD = {"x1": "1 mm", "phi": "0:360 deg"}  # no more than the gap; where the rotor stands nobody says
EVERY = "20 ms"  # a tenth of a turn
PARAMETER_SEARCH_STARTS, FEW = 24, 2  # besides rest: of the readings, of each point of the plane
POINTS = 128
SEED = 1
CONTRADICTING = ("excitation.m3", "excitation.e")


def search_readings(cases: Sequence[Case], advance: Advance) -> Numbers:
    """The readings, judged from rest and from drawn starts, as `vibsim fit --json` has them."""
    return _fitted(cases, advance, {}, READINGS, PARAMETER_SEARCH_STARTS, Search(seed=SEED))


def search_plane(cases: Sequence[Case], advance: Advance) -> Numbers:
    """Quasi-random points over J and c, all judged from a few starts."""
    search = Search(candidates=POINTS, seed=SEED, screen=1 + FEW, confirm=0, fresh=0)
    return _fitted(cases, advance, FREE, (), FEW, search)


def _fitted(
    cases: Sequence[Case],
    advance: Advance,
    free: dict[str, str],
    readings: Sequence[str],
    starts: int,
    search: Search,
) -> Numbers:
    sampled = [case.with_values({"run.every": EVERY}) for case in cases]
    statements = [statement.text for statement in STATEMENTS]
    plan = make_plan(sampled, free, statements, readings, {}, starts, SPREAD, search)
    fit, complete = run_fit(plan, watch=lambda step, done, total: advance(done, total))
    if not complete:
        raise MeasurementInterrupted
    return {"ranking": facts(fit)["ranking"]}


def keeps_table_1(changes: dict[str, Any]) -> bool:
    """Whether changes leave m3 e as Table 1 has it."""
    return not any(key in changes for key in CONTRADICTING)


def made_of() -> list[Any]:
    """Dependencies of the search besides the cases."""
    statements = [statement.text for statement in STATEMENTS]
    return [statements, READINGS, FREE, SPREAD, EVERY, PARAMETER_SEARCH_STARTS, FEW, POINTS, SEED]


# Which regimes the ideal source causes beside the three frequencies of Table 1.
#
# The frequency is varied finely, the damping in a few steps, with the amplitude of Table 1's rule (m3 e
# omega) and with that of Eq. (2.11) (m3 e omega^2). At the frequencies of Table 1 the shipped cases are run,
# with their own amplitudes: several motions coexist there, and a change of the seventh digit selects another.
# For that reason each point is run from rest and from starts to either side, and has the regime of most of
# them. The first of the quasi-periodic and chaotic ones of each row are followed ten times as long: what 300
# s show can be a transient.


FREQUENCIES = tuple(round(3 + 0.1 * i, 1) for i in range(41))  # [Hz] 3 to 7
DAMPINGS = (0.0, 0.001)  # [N s/m]
FOLLOWED = 2  # of each of the regimes below, of each law and damping
IRREGULAR = ("quasi-periodic", "chaotic")
REGIMES_NEARBY_STARTS = (
    0.0,
    6e-4,
    -6e-4,
    1.2e-3,
    -1.2e-3,
)  # [m] x1(0): rest, and half and all of the ensemble's reach
LONGER = {"run.t_end": "3000 s"}
LAWS = {"Table 1": 1, "Eq. (2.11)": 2}  # law of the amplitude -> power of omega behind m3 e


def measure_nearby(
    shipped: Mapping[str, Sequence[Case]], unbalance: float, advance: Advance
) -> list[Numbers]:
    """A row for each point: law, frequency [Hz], damping [N s/m], regime and period of most starts, regime
    and period of each start; `later` where followed.

    shipped : for each law the cases with an ideal source by that law; unbalance : m3 e [kg m]
    """
    points = [(law, hz, c) for law in LAWS for c in DAMPINGS for hz in FREQUENCIES]
    cases = [
        [_from(at_point(shipped[point[0]], unbalance, *point), start) for start in REGIMES_NEARBY_STARTS]
        for point in points
    ]
    verdicts = run_all([partial(_regime_nearby, each) for group in cases for each in group], advance)
    rows = [
        {"law": law, "hz": hz, "c": c, **most_common(group)}
        for (law, hz, c), group in zip(points, _groups(verdicts, len(REGIMES_NEARBY_STARTS)), strict=True)
    ]
    places = followed(rows)
    chosen = [cases[place][_first_of(rows[place])].with_values(LONGER) for place in places]
    later = run_all([partial(_regime_nearby, each) for each in chosen], advance)
    for place, regime in zip(places, later, strict=True):
        rows[place]["later"] = regime
    return rows


def most_common(regimes: Sequence[Numbers]) -> Numbers:
    """Regime and period of most of the starts, of the earlier start where two are as common; in `starts`
    those of each of them, rest first.
    """
    regime, _ = Counter(each["regime"] for each in regimes).most_common(1)[0]
    periods = [each["period"] for each in regimes if each["regime"] == regime]
    return {"regime": regime, "period": Counter(periods).most_common(1)[0][0], "starts": list(regimes)}


def _groups(values: Sequence[Numbers], size: int) -> list[Sequence[Numbers]]:
    return [values[i : i + size] for i in range(0, len(values), size)]


def _first_of(row: Numbers) -> int:
    """Number of the first start that has the regime of its row."""
    return next(i for i, each in enumerate(row["starts"]) if each["regime"] == row["regime"])


def followed(rows: Sequence[Numbers]) -> list[int]:
    """Places of the rows to follow for longer."""
    groups: dict[tuple[str, float, str], list[int]] = {}
    for place, row in enumerate(rows):
        if row["regime"] in IRREGULAR:
            groups.setdefault((row["law"], row["c"], row["regime"]), []).append(place)
    return [place for places in groups.values() for place in places[:FOLLOWED]]


def at_point(shipped: Sequence[Case], unbalance: float, law: str, hz: float, c: float) -> Case:
    """The case at a frequency and damping: a shipped one where there is one at this frequency, else the first
    of them with the frequency changed and the amplitude by the law, to all digits.
    """
    damping = {"coupling.c": f"{c:g} N s/m"}
    for case in shipped:
        if isclose(case.two_blocks().omega, 2 * pi * hz):
            return case if case.number("coupling.c") == c else case.with_values(damping)
    amplitude = unbalance * (2 * pi * hz) ** LAWS[law]
    changes = {"excitation.omega": f"{hz:g} Hz", "excitation.A": f"{amplitude!r} N"}
    return shipped[0].with_values({**changes, **damping})


def _from(case: Case, start: float) -> Case:
    """The case with block 1 displaced at the start [m]."""
    return case.with_values({"initial.x1": f"{start!r} m"}) if start else case


def _regime_nearby(case: Case) -> Numbers:
    try:
        result = simulate(case.with_values({"run.every": "50 ms"}), trust=False)
    except EngineError as error:
        return {"regime": "failed", "period": None, "why": str(error)}
    judged = judge_regime(result, exponent=largest_exponent(result))
    return {"regime": judged.verdict, "period": judged.period}


def counts_by_regime(rows: Sequence[Numbers], law: str, c: float) -> dict[str, int]:
    """Number of frequencies with each regime, the commonest first."""
    return dict(Counter(row["regime"] for row in rows if (row["law"], row["c"]) == (law, c)).most_common())


def rows_of(rows: Sequence[Numbers], regime: str, law: str, c: float) -> list[Numbers]:
    """The rows of a regime."""
    return [row for row in rows if (row["regime"], row["law"], row["c"]) == (regime, law, c)]


# Could the paper's account have come from its solver? II-B and II-C once more, by what most people use.
#
# It is not known which solver the paper used. Here: the equations with sgn(v2), no events, the printed
# parameters, and a general-purpose method at its default tolerance or with a fixed step. What such a run
# loses or gains in energy by its own errors acts like damping, or like a motor.


# name -> method of scipy's solve_ivp with its relative tolerance, or RK4 with its step [s]
SOLVERS: dict[str, tuple[str, float]] = {
    "RK45, rtol 1e-3 (default)": ("RK45", 1e-3),
    "RK23, rtol 1e-3 (default)": ("RK23", 1e-3),
    "RK4, step 4 ms": ("RK4", 4e-3),
    "RK4, step 2 ms": ("RK4", 2e-3),
}
ATOL = 1e-6  # default of solve_ivp
SAMPLED = 0.1  # [s]
PATIENCE = 120.0  # [s] of one run, after which it is given up
HEARING = 0.2  # [s] between two looks at whether to go on

_stop: Any = None  # of a worker: set when its work is given up


def measure_solvers(cases: Sequence[Case], advance: Advance) -> list[Numbers]:
    """A row for each solver: the outcome of every case by name. Raises Interrupted when told to stop."""
    jobs = [(solver, case) for solver in SOLVERS for case in cases]
    context = get_context("spawn")
    stop = context.Event()
    with ProcessPoolExecutor(available_cores(), context, _prepare, (stop,)) as pool:
        waiting = [pool.submit(solved, *job) for job in jobs]
        unfinished = set(waiting)
        while unfinished:
            _, unfinished = wait(unfinished, HEARING)
            if not advance(len(jobs) - len(unfinished), len(jobs)):
                stop.set()
                pool.shutdown(cancel_futures=True)
                raise MeasurementInterrupted
    outcomes = iter([future.result() for future in waiting])
    return [{"solver": solver, **{case.name: next(outcomes) for case in cases}} for solver in SOLVERS]


def solved(solver: str, case: Case) -> Numbers:
    """The outcome of a case by one of SOLVERS; {"failed": why} where it breaks down."""
    from vibsim.evidence.peers.solvers import TimeLimit

    scene = case.scene()
    times = np.arange(round(scene.t_end / SAMPLED) + 1) * SAMPLED
    try:
        attempt = _made(solver, scene).run(times, TimeLimit(PATIENCE, lambda: not _told_to_stop()))
    except ArithmeticError as error:
        return {"failed": str(error)}
    if attempt.stopped:
        return {"failed": f"given up at {attempt.t_reached:.0f} s of {scene.t_end:g} s"}
    outcome = outcome_of(_as_result(case, times, attempt))
    return {**outcome, "steps": attempt.steps, "drifted": float(attempt.states[-1, 2])}


def _told_to_stop() -> bool:
    """Whether the process that waits for this one has given it up."""
    return _stop is not None and _stop.is_set()


def _prepare(stop: Any) -> None:
    """In a process of its own: listen to `stop`, and leave Ctrl-C to the parent."""
    global _stop
    _stop = stop
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _made(solver: str, scene: Any) -> Any:
    from vibsim.evidence.peers.solvers import EventlessSolver, RungeKutta4

    method, setting = SOLVERS[solver]
    if method == "RK4":
        return RungeKutta4(scene, setting)
    return EventlessSolver(scene, method, rtol=setting, atol=ATOL)


def _as_result(case: Case, times: np.ndarray, attempt: Any) -> Result:
    """The attempt in the shape that the analysis reads."""
    names = ("x1", "v1", "x2", "v2", "phi", "phidot")
    samples = {"time": times, **dict(zip(names, attempt.states.T, strict=True))}
    struck = np.array([t for t, kind in attempt.events if kind == EVENT_KINDS["contact_begin"]])
    events = {"t": struck, "kind": np.full(len(struck), EVENT_KINDS["contact_begin"])}
    return Result({"complete": 1, "t_reached_s": float(times[-1])}, samples, events, case=case)


# Load curves of the motors: up to which no-load speed orbits are held, as printed and in the readings.
#
# The branch of orbits of one turn is followed from below the resonance, over all no-load speeds. Where the
# motor's line meets it the motor can run; beyond its fold no line does, and no such orbit holds the motor.


NO_LOAD, SPAN = "excitation.Omega0", "3:9 Hz"
BEGIN = {NO_LOAD: "3.8 Hz"}  # below the resonance, where a run from rest comes to an orbit of the branch
CHANGED = {  # name: what is changed of the motor as printed, to the value of the reading
    "as printed": (),
    "c alone": ("coupling.c",),
    "J alone": ("excitation.J",),
    "the reading": ("coupling.c", "excitation.J"),
}


def followed_cases() -> dict[str, Case]:
    """The motors whose branches are followed, by what is changed."""
    printed, reading = load_case(PRINTED_MOTOR), load_case(SHIPPED_READINGS[0])
    return {
        name: printed.with_values({**{key: str(reading.quantity(key)) for key in keys}, **BEGIN})
        for name, keys in CHANGED.items()
    }


def obtain_branches(folder: Path, tell: Tell, fresh: bool = False) -> dict[str, Branch]:
    """The branches by name, from FOLDER or followed now. Raises Interrupted when `tell` returns False."""
    branches, cases = {}, followed_cases()
    for done, (name, case) in enumerate(cases.items()):

        def watch(*_: object, done: int = done) -> bool:
            return tell("following orbits", done, len(cases))

        branches[name] = _followed(case, folder / f"{name.replace(' ', '-')}.h5", watch, fresh)
        if not tell("following orbits", done + 1, len(cases)):
            raise MeasurementInterrupted
    return branches


def _followed(case: Case, path: Path, watch: Callable[..., bool], fresh: bool) -> Branch:
    stored = None if fresh else _branch_on_file(case, path)
    if stored is not None:
        return stored
    plan = plan_from(orbit_from(case), *read_span(case, NO_LOAD, SPAN))
    branch, finished = complete(BranchStore(plan, path, force=True), MOST_POINTS, watch=watch)
    if not finished:
        raise MeasurementInterrupted
    return branch


def _branch_on_file(case: Case, path: Path) -> Branch | None:
    """The branch on file, if it is whole and of this very case and version."""
    try:
        branch = read_branch(path) if path.is_file() else None
    except ResultFileError:
        return None
    if branch is None or not branch.attrs.get("complete"):
        return None
    same = (branch.case.sha256, branch.attrs.get("vibsim_version")) == (case.sha256, __version__)
    return branch if same else None


def measure_ends(branches: Mapping[str, Branch]) -> Numbers:
    """Of each branch: up to which no-load speed orbits are held, mean speed [Hz], torque [N m], power [W] and
    amplitude [m] there and, as `half`, at the last orbit before that takes at most half the power,
    None where the branch has none.
    """
    return {name: _end(branch) for name, branch in branches.items()}


def _end(branch: Branch) -> Numbers:
    last = max(dead_ends(branch), key=lambda orbit: orbit.parameter)
    (special,) = (one for one in branch.specials if one.orbit is last)
    end = _held_point(branch, last)
    before = [point.orbit for point in branch.points[: special.between[0] + 1]]
    powers = [_held_point(branch, orbit)["power"] for orbit in before]
    lower = [orbit for orbit, power in zip(before, powers, strict=True) if power <= end["power"] / 2]
    amplitude = amplitude_of(branch)
    return {
        **end,
        "kind": special.kind,
        "amplitude": amplitude(last),
        "half": {**_held_point(branch, lower[-1]), "amplitude": amplitude(lower[-1])} if lower else None,
    }


def _held_point(branch: Branch, orbit: Any) -> Numbers:
    """No-load speed, mean speed [Hz], mean torque [N m] and their power [W] of an orbit."""
    speed, torque = branch.plan.n / orbit.period, torque_of(branch)(orbit)
    return {
        "no_load_hz": orbit.parameter,
        "speed_hz": speed,
        "torque": torque,
        "power": 2 * pi * speed * torque,
    }
