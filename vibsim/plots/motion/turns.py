"""Turns of the source: the instants at which its phase passes a multiple of 2 pi."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from vibsim.physics.period import common_period
from vibsim.plots.motion import dense
from vibsim.plots.motion.hermite import hermite, root_time
from vibsim.plots.motion.samples import blocks
from vibsim.plots.view import Span

TURN = 2 * math.pi
TURNS = 12  # to average over: a multiple of the periods 1, 2, 3, 4 and 6 that the motion may have


def turn_times(result: Any, span: Span) -> np.ndarray:
    """Instants within the span at which the source begins a period [s], ascending; none without a period.

    Forces and base: multiples of their common period. Motor: phi = 2 pi k, located on the cubic Hermite
    interpolant of phi between two samples (phi and phidot are stored, so its error is of fourth order in the
    output interval).
    """
    scene = result.case.scene()
    if scene.has_motor:
        times = [_motor_turns(part) for part in _joined_blocks(result, ("time", "phi", "phidot"), span)]
        return np.concatenate([np.empty(0), *times])
    period = common_period(scene)
    if period is None:
        return np.empty(0)
    rate = period.cycles / period.turns
    first, last = math.ceil(span[0] * rate - 1e-9), math.floor(span[1] * rate + 1e-9)
    return np.asarray(np.clip(period.end(np.arange(first, last + 1)), *span))


def _joined_blocks(result: Any, names: tuple[str, ...], span: Span) -> Iterator[dict[str, np.ndarray]]:
    """Blocks of samples that begin with the last sample of the block before, so that no interval is lost."""
    last: dict[str, np.ndarray] | None = None
    for block in blocks(result, names, span):
        if last is not None:
            block = {name: np.concatenate([last[name], block[name]]) for name in names}
        last = {name: block[name][-1:] for name in names}
        yield block


def _motor_turns(part: dict[str, np.ndarray]) -> np.ndarray:
    """Passages of phi through multiples of 2 pi between samples; several to an interval where it is long."""
    t, phi, phidot = part["time"], part["phi"], part["phidot"]
    turn = np.floor(phi / TURN).astype(np.int64)
    passed = np.diff(turn)
    count = np.abs(passed)
    left = np.repeat(np.arange(len(passed)), count)
    if not len(left):
        return np.empty(0)
    within = np.arange(len(left)) - np.repeat(
        np.cumsum(count) - count, count
    )  # 0, 1, ... inside each interval
    forward = passed[left] > 0
    target = TURN * np.where(forward, turn[left] + 1 + within, turn[left] - within)
    return root_time(t[left], t[left + 1], phi[left], phi[left + 1], phidot[left], phidot[left + 1], target)


def states_at(
    result: Any, names: tuple[str, ...], times: np.ndarray, exact_up_to: int
) -> dict[str, np.ndarray]:
    """Columns `names` at the instants `times` (n), ascending [s].

    Up to `exact_up_to` of them are evaluated by the engine; more are interpolated between samples, x by the
    cubic Hermite polynomial of x and v, v by its derivative.
    """
    times = times[times <= result.t_reached]
    if len(times) <= exact_up_to:
        return dense.states_at(result, names, times)
    parts: dict[str, list[np.ndarray]] = {name: [] for name in names}
    pairs = [name for name in names if name.startswith("x")]
    done = 0
    for block in _joined_blocks(result, ("time", *names), (-math.inf, math.inf)):
        stop = int(np.searchsorted(times, block["time"][-1], side="right"))
        inside, done = times[done:stop], stop
        left = np.clip(np.searchsorted(block["time"], inside, side="right") - 1, 0, len(block["time"]) - 2)
        for x in pairs:
            v = f"v{x[1:]}"
            position, velocity = hermite(block["time"], block[x], block[v], left, inside)
            parts[x].append(position)
            parts[v].append(velocity)
    return {name: np.concatenate(parts[name]) for name in names}
