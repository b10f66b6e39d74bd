"""Budget: 500 times faster than solve_ivp at equal error, over 20 s, final state only."""

from dataclasses import replace
from statistics import median

import numpy as np

from tests.budgets.engine_clock import run_through
from tests.budgets.row import Row, stopwatch
from tests.budgets.true_states import error_of
from vibsim.cases import load_case
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.solvers import EventlessSolver, EventSolver, TimeLimit

SPAN = 20  # s
LADDER = (1e-10, 1e-12, 2.3e-14)  # rtol; the last is the tightest that solve_ivp takes
REPETITIONS = 3


def rows():
    for name in ("II-B", "I-C"):
        scene = replace(load_case(name).scene(), t_end=float(SPAN)).without_samples()
        ours = median(stopwatch(lambda scene=scene: run_through(open_trajectory(scene))) for _ in range(15))
        note = f"vibsim {ours * 1e3:.2f} ms, error {error_of(name, SPAN, final_state(scene)):.1e}"
        yield with_events(name, scene, ours, note)
        yield with_sgn(name, scene, ours, note)


def with_events(name, scene, ours, note):
    """DOP853 with events: the loosest tolerance that reaches the error of vibsim, else the best."""
    allowed = error_of(name, SPAN, final_state(scene))
    tried = []
    for rtol in LADDER:
        state = []
        seconds = stopwatch(
            lambda rtol=rtol, state=state: state.extend(end_of(EventSolver(scene, "DOP853", rtol)))
        )
        tried.append((error_of(name, SPAN, state), rtol, seconds))
        if tried[-1][0] <= allowed:
            break
    _, rtol, seconds = next((entry for entry in tried if entry[0] <= allowed), min(tried))
    again = [stopwatch(lambda: end_of(EventSolver(scene, "DOP853", rtol))) for _ in range(REPETITIONS - 1)]
    ladder = "; ".join(f"rtol {r:.1e}: {s:.2f} s, error {e:.1e}" for e, r, s in tried)
    figures = [value / ours for value in (seconds, *again)]
    return Row(
        f"{name}, {SPAN} s, DOP853 with events / vibsim", "x", 500.0, figures, [note, ladder], at_least=True
    )


def with_sgn(name, scene, ours, note):
    """RK45 at rtol 1e-6 without events, which is nowhere near the error of vibsim."""
    state = []
    seconds = stopwatch(lambda: state.extend(end_of(EventlessSolver(scene, "RK45", 1e-6, 1e-9))))
    told = f"RK45 {seconds:.2f} s, error {error_of(name, SPAN, state):.1e}"
    return Row(
        f"{name}, {SPAN} s, RK45 rtol 1e-6 with sgn / vibsim",
        "x",
        500.0,
        [seconds / ours],
        [note, told],
        at_least=True,
    )


def end_of(peer):
    """State at the end of a peer's run, the only one asked for."""
    return peer.run(np.array([0.0, float(SPAN)]), TimeLimit()).states[-1]


def final_state(scene):
    """[x1, v1, x2, v2 (, phi, phidot)] at the end of the run."""
    *_, last = open_trajectory(scene).blocks()
    names = ("x1", "v1", "x2", "v2", "phi", "phidot")
    return [last.events[name][-1] for name in names if name in last.events]
