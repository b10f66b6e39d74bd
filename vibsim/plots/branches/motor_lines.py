"""Lines of the motor over load curves: torque against speed for given no-load speeds, and what they meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from scipy.optimize import brentq

from vibsim.analysis.holds import BAND
from vibsim.branches.course import Stretch, stretches
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.returns.start import placed
from vibsim.plots.branches.values import Value, mean_speed_of, parameter_of
from vibsim.plots.motion.natural_frequencies import motor_of
from vibsim.plots.page.quantities import Scale
from vibsim.plots.style import GREY, points

RUN = 3000  # periods of an orbit that a motor has to stay or leave
ASIDE = 1e-3  # by which share the velocities are off the orbit at the start of that run
MULTIPLIER = 1e-6  # rounding of a multiplier
FONT_SIZE = 6.5
PLACES = 120  # on a line that are tried for its name
CLEAR_PT, LEAST_PT = 14.0, 5.0  # between a name and a curve or the frame: enough, and the least
HEIGHT = 0.62  # of the axes where names stand if they can


def torque_of(branch: Any) -> Value:
    """Mean torque [N m] of an orbit of a branch over the no-load speed."""
    stall, speed, no_load = motor_of(branch.map.scene).M0, mean_speed_of(branch), parameter_of(branch)
    return lambda orbit: float(stall * (1 - speed(orbit) / no_load(orbit)))


@dataclass(frozen=True)
class LoadCurve:
    """A branch over the no-load speed; torques are drawn in the unit of `scale`."""

    branch: Any
    scale: Scale

    def speed(self, orbit: Any) -> float:
        """Mean speed of an orbit [Hz]."""
        return mean_speed_of(self.branch)(orbit)

    def torque(self, orbit: Any) -> float:
        """Mean torque of an orbit, as drawn."""
        return float(self.scale(torque_of(self.branch)(orbit)))

    @cached_property
    def stretches(self) -> list[Stretch]:
        """The curve from one computed orbit to the next."""
        return stretches(self.branch)

    def places(self) -> list[tuple[float, float]]:
        """Mean speed and torque of every orbit."""
        return [(self.speed(point.orbit), self.torque(point.orbit)) for point in self.branch.points]


@dataclass(frozen=True)
class Crossing:
    """Where a line of the motor meets a load curve: mean speed [Hz], torque as drawn, the orbit there."""

    curve: LoadCurve
    stretch: Stretch
    orbit: Any

    @property
    def speed(self) -> float:
        return self.curve.speed(self.orbit)

    @property
    def torque(self) -> float:
        return self.curve.torque(self.orbit)

    @property
    def stable(self) -> bool:
        """Whether the orbit is."""
        return self.stretch.stable

    @cached_property
    def stays(self) -> bool:
        """Whether the motor keeps its mean speed: on the orbit where that is stable; on a motion near it, as
        on one of twice the period, where a run from beside the orbit ends within 3 % of its speed. Where
        disturbances grow without turning round (a real multiplier above 1: behind a fold) it leaves.
        """
        return self.stable or not (self._is_saddle() or self._departs())

    def _is_saddle(self) -> bool:
        ends = (self.stretch.one, self.stretch.other)
        multipliers = [mu for end in ends for mu in end.multipliers]
        return any(mu.imag == 0 and mu.real > 1 + MULTIPLIER for mu in multipliers)

    def _departs(self) -> bool:
        """Whether a run that starts beside the orbit ends with another mean speed."""
        family = self.curve.branch.plan.family()
        state = family.map(self.orbit.parameter).coordinates.state(np.array(self.orbit.state))
        beside = {name: x * (1 + ASIDE) if name[0] == "v" else x for name, x in state.items()}
        scene = placed(family.at(self.orbit.parameter).scene(), beside, RUN * self.orbit.period)
        trajectory = open_trajectory(scene.without_samples(), section=True)
        times = np.concatenate([block.section["time"] for block in trajectory.blocks()])
        late = times[len(times) // 2 :]
        return len(late) < 2 or abs((len(late) - 1) / (late[-1] - late[0]) / self.speed - 1) > BAND


def crossings(curve: LoadCurve, no_load: float) -> list[Crossing]:
    """Where the line of a no-load speed [Hz] meets a curve: its orbits at that speed."""
    met = []
    for stretch in curve.stretches:
        share = _share(parameter_of(curve.branch), stretch, no_load)
        if share is not None:
            met.append(Crossing(curve, stretch, stretch.at(share)))
    return met


def _share(parameter: Value, stretch: Stretch, value: float) -> float | None:
    """Share of a stretch at which its parameter has a value; None where it has not."""
    ends = {0.0: parameter(stretch.one) - value, 1.0: parameter(stretch.other) - value}
    if ends[0.0] * ends[1.0] > 0 or ends[0.0] == ends[1.0]:
        return None

    def beyond(share: float) -> float:
        return ends[share] if share in ends else parameter(stretch.at(share)) - value

    return float(brentq(beyond, 0.0, 1.0))


@dataclass(frozen=True)
class MotorLine:
    """Torque stall (1 - speed / no_load), the speeds in Hz, the torques as drawn."""

    no_load: float
    stall: float

    def at(self, speed: Any) -> Any:
        """Torque at speeds [Hz]."""
        return self.stall * (1 - speed / self.no_load)

    def draw(self, axes: Axes) -> None:
        """Through the axes, whose limits must be final."""
        x = np.array(axes.get_xlim())
        axes.plot(
            x, self.at(x), color=GREY, linewidth=0.5, scalex=False, scaley=False, zorder=1, gid="motor line"
        )

    def write(self, axes: Axes, speed: float, text: str, **look: Any) -> None:
        """A text on the line, in its direction."""
        slope = np.degrees(np.arctan2(-self.stall / self.no_load, 1.0))
        axes.text(
            speed, float(self.at(speed)), text, rotation=slope, rotation_mode="anchor",
            transform_rotates_text=True, ha="center", **look,
        )  # fmt: skip


def draw_motor_lines(axes: Axes, lines: Sequence[MotorLine], avoided: Sequence[tuple[float, float]]) -> None:
    """Draw lines, and write each one's no-load speed where it keeps clear of places in data coordinates."""
    for line in lines:
        line.draw(axes)
        speed = _free_place(axes, line, np.array(avoided))
        if speed is not None:
            line.write(
                axes, speed, f"{line.no_load:g}", va="center", fontsize=points(FONT_SIZE), color="0.3",
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8}, zorder=2, gid="no-load speed",
            )  # fmt: skip


def _free_place(axes: Axes, line: MotorLine, avoided: np.ndarray) -> float | None:
    """Speed at which a name is clear of everything, nearest to the usual height; None where none is."""
    speeds = np.linspace(*axes.get_xlim(), PLACES)
    places = axes.transData.transform(np.column_stack([speeds, line.at(speeds)]))
    figure = axes.get_figure(root=True)
    assert figure is not None
    pt, box = 72 / figure.dpi, axes.bbox
    gaps = np.linalg.norm(places[:, None] - axes.transData.transform(avoided), axis=2).min(axis=1)
    edges = [places[:, 0] - box.x0, box.x1 - places[:, 0], places[:, 1] - box.y0, box.y1 - places[:, 1]]
    clearance = pt * np.minimum(gaps, np.min(edges, axis=0))
    if clearance.max() < LEAST_PT:
        return None
    free = np.flatnonzero(clearance >= min(CLEAR_PT, clearance.max()))
    heights = (places[free, 1] - box.y0) / box.height
    return float(speeds[free[np.abs(heights - HEIGHT).argmin()]])
