"""Could the paper's account have come from its solver? II-B and II-C once more, by what most people use.

It is not known which solver the paper used. Here: the equations with sgn(v2), no events, the printed
parameters, and a general-purpose method at its default tolerance or with a fixed step. What such a run loses
or gains in energy by its own errors acts like damping, or like a motor.
"""

from __future__ import annotations

import signal
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.evidence.reports.measured.measurements import Numbers
from vibsim.evidence.reports.measured.outcomes import Advance, outcome_of
from vibsim.evidence.reports.measured.paper_runs import Interrupted
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results import Result
from vibsim.results.cores import available_cores

if TYPE_CHECKING:
    from vibsim.cases import Case

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
                raise Interrupted
    outcomes = iter([future.result() for future in waiting])
    return [{"solver": solver, **{case.name: next(outcomes) for case in cases}} for solver in SOLVERS]


def solved(solver: str, case: Case) -> Numbers:
    """The outcome of a case by one of SOLVERS; {"failed": why} where it breaks down."""
    from vibsim.evidence.peers.time_limit import TimeLimit

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
    from vibsim.evidence.peers.solvers.runge_kutta4 import RungeKutta4
    from vibsim.evidence.peers.solvers.solve_ivp_eventless import EventlessSolver

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
