"""Leaps of a motor: where stable orbits end as its no-load speed rises, it has to leave along its line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.branches.motor_lines import LoadCurve, MotorLine, crossings
from vibsim.plots.branches.values import parameter_of
from vibsim.plots.motion.natural_frequencies import motor_of
from vibsim.plots.style import VERMILLION, points

NEAR = 0.01  # of the parameter's range: how far the branch may go on unstable before it turns back
FAR = 0.05  # of the speeds drawn: a leap that can be seen
ARROW = 0.6  # of the way to the last place on the line: where on it the motor comes to stay is not told
FONT_SIZE = 7


@dataclass(frozen=True)
class Leap:
    """A leap along the line of a no-load speed, from a speed to the greatest at which it can run [Hz]."""

    line: MotorLine
    start: float
    last: float

    def places(self) -> list[tuple[float, float]]:
        """Places along it, as drawn."""
        return [(speed, self.line.at(speed)) for speed in np.linspace(self.start, self.last, 50).tolist()]


def leaps_of(curves: Sequence[LoadCurve], span: tuple[float, float]) -> list[Leap]:
    """From each dead end, where the motor's line meets a curve of the same machine much further right."""
    leaps = []
    for curve in curves:
        ours = [other for other in curves if _machine(other) == _machine(curve)]
        for orbit in dead_ends(curve.branch):
            no_load, start = parameter_of(curve.branch)(orbit), curve.speed(orbit)
            last = max((place.speed for other in ours for place in crossings(other, no_load)), default=start)
            if last - start > FAR * (span[1] - span[0]):
                stall = curve.torque(orbit) / (1 - start / no_load)
                leaps.append(Leap(MotorLine(no_load, stall), start, last))
    return leaps


def _machine(curve: LoadCurve) -> tuple[object, ...]:
    """Everything that acts, but for the no-load speed and the start."""
    scene = curve.branch.map.scene
    motor = motor_of(scene)
    masses = tuple(body.m for body in scene.bodies)
    acting = scene.links, scene.stops, scene.frictions, scene.forces, scene.base
    return (masses, *acting, motor.on, motor.m3, motor.e, motor.J, motor.M0)


def dead_ends(branch: Any) -> list[Any]:
    """The orbits of a branch at which stability ends, as its parameter rises, a hair before or at a fold."""
    ends, between, outside = [], (-1, -1), 0
    for special in branch.specials:
        if special.between != between:
            between = special.between
            outside = branch.points[between[0]].orbit.index
        before, outside = outside, outside + special.jump
        ends_here = special.jump and 0 in (before, outside)
        if ends_here and _turns_back(branch, special, 1 if special.jump > 0 else -1):
            ends.append(special.orbit)
    return ends


def _turns_back(branch: Any, special: Any, way: int) -> bool:
    """Whether the branch rises up to a special point, and followed `way` soon comes to lower values again."""
    values = np.array([parameter_of(branch)(point.orbit) for point in branch.points])
    here = parameter_of(branch)(special.orbit)
    behind, ahead = special.between[::way]
    risen = values[ahead::way] - here
    back = np.flatnonzero(risen < 0)
    if values[behind] > here or not len(back):
        return False
    return bool(risen[: back[0]].max(initial=0.0) <= NEAR * np.ptp(values))


def draw_leap(axes: Axes, leap: Leap) -> None:
    """An arrow on the line of the motor, which is dashed on to the last place; its no-load speed."""
    ends = np.array([leap.start, leap.last])
    tip = leap.start + ARROW * (leap.last - leap.start)
    axes.plot(
        ends, leap.line.at(ends), color=VERMILLION, linewidth=0.8, linestyle=(0, (2, 1.5)), zorder=3,
        gid="line of the leap",
    )  # fmt: skip
    axes.annotate(
        "", (tip, leap.line.at(tip)), (leap.start, leap.line.at(leap.start)), zorder=5,
        arrowprops={"arrowstyle": "-|>,head_width=0.18,head_length=0.4", "color": VERMILLION,
                    "linewidth": 1.2, "shrinkA": 5, "shrinkB": 0},
    )  # fmt: skip
    leap.line.write(
        axes, (leap.start + tip) / 2, f"{leap.line.no_load:.4g}", va="bottom", fontsize=points(FONT_SIZE),
        color=VERMILLION, gid="leap",
    )  # fmt: skip
