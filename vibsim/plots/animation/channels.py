"""What moves the drawing: displacements of the ends, plates of the stops, the rotor's angle, the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vibsim.engine.columns import part_columns
from vibsim.plots.animation.stage import (
    FLOOR_TICK_CM,
    NOSE_CM,
    Stage,
    attached,
    stage_for,
)
from vibsim.plots.errors import PlotError
from vibsim.plots.machine.elements import BASE, GROUND
from vibsim.plots.motion.dense import states_at
from vibsim.plots.motion.impacts import PUSHING, impact_events
from vibsim.plots.motion.spans import period_of
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span
from vibsim.results.motion.relative_motion import base_motion

FLASH = 0.15  # seconds of the film that an impact is seen
SMOOTHED = 4  # periods over which a drift is taken out
MOST_FRAMES = 60_000
FLOOR, COSINE, SINE = "floor", "cosine", "sine"


@dataclass(frozen=True)
class Channels:
    """The motion of the drawing.

    Attributes
    ----------
    stage : the machine at rest
    times : of the frames (n) [s]
    names : of the channels: ends, keys of stops, FLOOR, COSINE and SINE
    values : (n, channels) [cm]; cosine and sine of the rotor's angle
    lit : which stops are in contact or were just struck, (n, stops)
    states : columns of the run at the frames, by name
    """

    stage: Stage
    times: np.ndarray
    names: list[str]
    values: np.ndarray
    lit: np.ndarray
    states: dict[str, np.ndarray]


def channels_of(subject: Subject, span: Span, step: float, speed: float) -> Channels:
    """The channels at instants `step` [s] apart.

    speed : seconds of motion per second of the film

    Raises PlotError for more than MOST_FRAMES frames.
    """
    count = int(np.floor((span[1] - span[0]) / step)) + 1
    if count > MOST_FRAMES:
        raise PlotError(f"{count} frames are too many, {MOST_FRAMES} go: show a shorter --window")
    times = np.minimum(span[0] + step * np.arange(count), subject.result.t_reached)
    scene = subject.scene
    names = (*subject.tables.states, *part_columns(scene)[: len(scene.stops)])
    states = states_at(subject.result, names, times)
    motion = {body.name: states[f"x{'' if body.name.isdigit() else '_'}{body.name}"] for body in scene.bodies}
    motion[BASE] = base_motion(scene.base, times)[0]
    motion[GROUND] = np.zeros(count)
    if _drifts(subject):
        motion = _followed(motion, times, SMOOTHED * period_of(subject, span))
    values = subject.case.long_values()
    stage = stage_for(values, motion, {f"stops.{stop.name}": float(stop.gap) for stop in scene.stops})
    moved = {name: stage.scale * x for name, x in motion.items()}
    phi = states["phi"] if scene.has_motor else np.zeros(count)
    moved |= plates(stage, moved)
    moved |= {FLOOR: np.fmod(moved[GROUND], FLOOR_TICK_CM), COSINE: np.cos(phi), SINE: np.sin(phi)}
    lit = _lit(subject, times, states, FLASH * speed)
    order = [f"stops.{stop.name}" for stop in scene.stops]
    rows = [order.index(element.key) for element in stage.stops]
    return Channels(stage, times, list(moved), np.column_stack(list(moved.values())), lit[:, rows], states)


def _drifts(subject: Subject) -> bool:
    """Whether nothing holds the bodies at the ground or the base, so that they may wander off."""
    parts = (*subject.scene.links, *subject.scene.stops)
    return not any(end < 0 for part in parts for end in (part.P, part.Q))


def _followed(motion: dict[str, np.ndarray], times: np.ndarray, length: float) -> dict[str, np.ndarray]:
    """The motion as seen by an eye that follows it: less the mean of all bodies over `length` [s] about."""
    moving = [x for name, x in motion.items() if name not in (BASE, GROUND)]
    mean = np.mean(moving, axis=0)
    half = max(int(length / 2 / (times[1] - times[0])), 1) if len(times) > 1 else 1
    sums = np.concatenate([[0.0], np.cumsum(mean)])
    low, high = np.arange(len(mean)) - half, np.arange(len(mean)) + half + 1
    low, high = np.clip(low, 0, len(mean)), np.clip(high, 0, len(mean))
    smooth = (sums[high] - sums[low]) / (high - low)
    return {name: x - smooth for name, x in motion.items()}


def plates(stage: Stage, moved: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Positions [cm] of the plates of stops, and heads of hooks: free they go with the end that bears them,
    in contact with the other.
    """
    places = {}
    for element, _, slot in stage.placed:
        if element.kind not in ("stop", "hook"):
            continue
        left = attached(stage, element, slot, -1) + moved[element.left]
        right = attached(stage, element, slot, 1) + moved[element.right]
        at_rest = attached(stage, element, slot, 1) - attached(stage, element, slot, -1)
        if element.kind == "stop":  # nose of the left end, plate borne by the right one
            reach = at_rest - NOSE_CM - stage.gaps[element.key]
            places[element.key] = np.maximum(right - reach, left + NOSE_CM)
        else:  # lips of the right end, head borne by the left one
            reach = at_rest - NOSE_CM + stage.gaps[element.key]
            places[element.key] = np.maximum(left + reach, right - NOSE_CM)
    return places


def _lit(subject: Subject, times: np.ndarray, states: dict[str, np.ndarray], length: float) -> np.ndarray:
    """Which stops are in contact at each frame, or were struck within `length` [s] before it."""
    stops = subject.scene.stops
    columns = part_columns(subject.scene)[: len(stops)]
    lit = np.zeros((len(times), len(stops)), dtype=bool)
    for number, name in enumerate(columns):
        lit[:, number] = np.isin(states[name], PUSHING)
    if not stops:
        return lit
    struck, part = impact_events(subject.result, (float(times[0]) - length, float(times[-1])), "part")
    for number in range(len(stops)):
        own = struck[part == number]
        last = np.searchsorted(own, times, side="right") - 1
        ago = times - own[np.maximum(last, 0)] if len(own) else np.full(len(times), np.inf)
        lit[:, number] = lit[:, number] | ((last >= 0) & (ago <= length))
    return lit


def speed_text(speed: float) -> str:
    """How fast a film runs, in words."""
    if speed == 1:
        return "real time"
    return f"{1 / speed:g} times slower" if speed < 1 else f"{speed:g} times faster"


def decimals_of(times: np.ndarray) -> int:
    """Of a clock that shows another time [s] at each frame; three at least."""
    step = float(times[1] - times[0]) if len(times) > 1 else 1.0
    return max(3, -math.floor(math.log10(step)))
