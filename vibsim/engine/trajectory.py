"""Runs of scenes made of parts: one contract, two engines that agree bit for bit on doubles.

trajectory = open_trajectory(scene, engine="auto")
for block in trajectory.blocks(): ...
trajectory.totals
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from vibsim.engine.blocks import Gap, Trajectory, Wishes
from vibsim.engine.c_trajectory import CTrajectory
from vibsim.engine.choice import check_method
from vibsim.engine.modes.ties import Edge
from vibsim.engine.resume import Row, resume_point
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.physics.parts import Scene


def open_trajectory(
    scene: Scene,
    resume: Row | Sequence[Row] | None = None,
    section: bool = False,
    ledger: bool = False,
    momentum: bool = False,
    tangent: int = 0,
    tangent_from: float = 0.0,
    extremes: tuple[Sequence[Edge], float] | None = None,
    early: bool = False,
    dither: int = 0,
    record_from: tuple[float, float] = (0.0, 0.0),
) -> Trajectory:
    """A run of `scene` (a `vibsim.physics.parts.Scene`) from its start, not yet computed.

    Parameters
    ----------
    scene : Scene
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
    early : whether infinite sequences of impacts end at least one whole hop before they do without it: what
        the one run leaves out, the difference of two shows
    dither : k > 0: events are taken one unit in the last place of the time later or earlier than they are
        rounded, with signs of their own for every k up to 31
    record_from : times [s] before which samples, and the section, are left out; the state at the former is
        `at_begin` of the object returned

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
        "early": early,
        "dither": dither,
        "record_from": record_from,
    }
    point = None if resume is None else resume_point(scene, resume)
    return CTrajectory(scene, point, **wishes)


def extremes_of(scene: Scene, ends: Sequence[Edge], since: float) -> tuple[list[Edge], list[Gap], float]:
    """Columns of the pairs, the stops whose gap is that of one of them, the time."""
    pairs = [(scene.column(P), scene.column(Q)) for P, Q in ends]
    gaps: list[Gap] = []
    for i, stop in enumerate(scene.stops):
        P, Q = scene.column(stop.P), scene.column(stop.Q)
        if (P, Q) in pairs:
            gaps.append((i, pairs.index((P, Q)), stop.sense, stop.gap))
        elif (Q, P) in pairs:
            gaps.append((i, pairs.index((Q, P)), -stop.sense, stop.gap))
    return pairs, gaps, since


def state_at(scene: Scene, row: Row | Sequence[Row], times: Iterable[float]) -> dict[str, np.ndarray]:
    """States at `times` [s], restarted from the stored event `row`.

    row: as `resume` of `open_trajectory`; times: ascending, from row["t"] to before the next event. Returns
    arrays by column name.
    """
    return open_trajectory(scene, resume=row).state_at(times)


def check_tangent(scene: Scene, tangent: int) -> None:
    """Raises ValueError where the scene has not so many directions."""
    if tangent and not 0 <= tangent <= dimension(scene):
        raise ValueError(f"tangent must be 0 to {dimension(scene)} for this scene, got {tangent}")
