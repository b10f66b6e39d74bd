"""Load curves of motors, their lines and their leaps; and the characteristic of a motor by itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from scipy.optimize import brentq

from vibsim.analysis.capture import averaged_load
from vibsim.analysis.cycles import BAND, TURN
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.branches.tracing import Stretch, stretches
from vibsim.orbits.coordinates import placed
from vibsim.physics.parts import Motor
from vibsim.plots.branch_curves import (
    Value,
    draw_branches,
    keys_to_marks,
    mean_speed_of,
    parameter_of,
    write_numbers,
)
from vibsim.plots.samples import motor_of
from vibsim.plots.sheet import (
    Scale,
    legend_above,
    legend_below,
    note,
    scale_for,
    sheet,
)
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, VERMILLION, nested, points
from vibsim.plots.subject import Subject, View
from vibsim.plots.time_histories import SPEED

# The load curve: the mean torque that the vibration takes against the mean speed, and what the motor gives.
#
# Over a periodic orbit the rotor comes back to its speed, so the mean torque of the motor is the mean torque
# that the vibration takes; and as the motor's torque falls linearly with its speed, Eq. (2.8), that is
# M0 (1 - <phi'> / Omega0) with the mean speed <phi'> = 2 pi n / T. Where the line of a no-load speed meets
# the curve, the motor can run. On a solid part it stays. On a dashed one the orbit is unstable, and a run
# from beside it tells what the motor does: behind a doubling it mostly stays near, on the orbit of twice the
# period; behind a fold it leaves. Where the curve turns back, the motor has to leave along its line.


HEIGHT_CM = 8.0
LINES = 6  # of the motor, about
AVERAGED_POINTS = 1001


class OperatingMark(NamedTuple):
    """Mark of an operating point of the motor, by what the motor does there."""

    label: str
    size: float
    fill: str
    face: str

    @property
    def look(self) -> dict[str, Any]:
        """Keywords of a line of matplotlib."""
        return {
            "color": BLACK, "linestyle": "none", "marker": "o", "markersize": self.size,
            "fillstyle": self.fill, "markerfacecolor": self.face, "markerfacecoloralt": "white",
            "markeredgecolor": BLACK, "markeredgewidth": 0.6,
        }  # fmt: skip


STAYS = OperatingMark("motor stays", 2.6, "full", BLACK)
NEAR = OperatingMark("motor stays near", 4.4, "left", BLACK)
LEAVES = OperatingMark("motor leaves", 4.2, "full", "white")
LOAD_CURVE_MARKED = ("fold", "doubling", "neimark-sacker", "branch point", "corner")


def load_curve_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Branches over the no-load speed as load curves; lines of the motor; operating points; leaps."""
    figure = sheet(view, HEIGHT_CM)
    load_curve_panel(figure, figure.subplots(), subjects, view)
    return figure


def load_curve_panel(
    figure: Figure,
    axes: Axes,
    subjects: Sequence[Subject],
    view: View,
    no_load: Sequence[float] | None = None,
) -> None:
    """The load curve in given axes, its legend below the figure.

    no_load : no-load speeds [Hz] whose lines are drawn, without leaps; None: round ones, and leaps
    """
    branches = [subject.result for subject in subjects]
    torques = [[torque_of(branch)(point.orbit) for point in branch.points] for branch in branches]
    scale = scale_for("N m", *torques)
    curves = [LoadCurve(branch, scale) for branch in branches]
    drawn = draw_branches(
        axes, subjects, [(curve.speed, curve.torque) for curve in curves], LOAD_CURVE_MARKED
    )
    _limit(axes, curves, view)
    averaged = _draw_averaged(axes, subjects[0].scene, scale)
    speeds = no_load or _round_speeds(curves)
    leaps = leaps_of(curves, axes.get_xlim()) if no_load is None else []
    avoided = [place for curve in curves for place in curve.places()]
    avoided += [place for leap in leaps for place in leap.places()]
    stall = float(scale(motor_of(subjects[0].scene).M0))
    draw_motor_lines(axes, [MotorLine(speed, stall) for speed in speeds], avoided)
    for curve in curves:
        for speed in speeds:
            for place in crossings(curve, speed):
                _mark(axes, place)
    for leap in leaps:
        draw_leap(axes, leap)
    axes.set_xlabel(r"Mean motor speed $\langle\dot\varphi\rangle/2\pi$ (Hz)")
    axes.set_ylabel(scale.label("Mean torque"))
    if len(subjects) > 1:
        legend_above(axes)
    keys = [*keys_to_marks(branches, LOAD_CURVE_MARKED), *_keys(bool(leaps)), *averaged]
    legend_below(figure, keys, [str(key.get_label()) for key in keys])
    write_numbers(axes, drawn)


def _limit(axes: Axes, curves: Sequence[LoadCurve], view: View) -> None:
    """All of the branches, from no torque up."""
    speeds, torques = zip(*(place for curve in curves for place in curve.places()), strict=True)
    low, high = min(speeds), max(speeds)
    axes.set_xlim(*(view.window or (low - 0.03 * (high - low), high + 0.05 * (high - low))))
    axes.set_ylim(min(0.0, *torques), 1.08 * max(torques))


def _draw_averaged(axes: Axes, scene: Any, scale: Scale) -> list[Line2D]:
    """The load by averaging (Kononenko) where it is known, over all speeds shown; its key, or none."""
    speeds = np.linspace(*axes.get_xlim(), AVERAGED_POINTS)
    load = scale(averaged_load(scene, TURN * speeds))
    if np.isnan(load).all():
        return []
    look: dict[str, Any] = {"color": GREEN, "linewidth": 1.1, "linestyle": (0, (1, 1.6))}
    axes.plot(speeds, load, scalex=False, scaley=False, zorder=5, gid="averaged", **look)
    return [Line2D([], [], label="averaged (Kononenko)", **look)]


def _round_speeds(curves: Sequence[LoadCurve]) -> list[float]:
    """Round no-load speeds [Hz] that branches have."""
    values = [parameter_of(curve.branch)(point.orbit) for curve in curves for point in curve.branch.points]
    low, high = min(values), max(values)
    ticks = MaxNLocator(LINES, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    return [float(tick) for tick in ticks if low <= tick <= high]


def _mark(axes: Axes, place: Crossing) -> None:
    """Mark an operating point by what the motor does there; a dot and a ring nearly meet at a fold."""
    mark = STAYS if place.stable else NEAR if place.stays else LEAVES
    axes.plot(
        place.speed, place.torque, zorder=6.5 if place.stable else 6, gid="operating point", **mark.look
    )


def _keys(leaps: bool) -> list[Line2D]:
    keys = [Line2D([], [], color=GREY, linewidth=0.5, label="motor (no-load Hz)")]
    keys += [Line2D([], [], label=mark.label, **mark.look) for mark in (STAYS, NEAR, LEAVES)]
    if leaps:
        keys.append(Line2D([], [], color=VERMILLION, linewidth=1.2, label="held no longer"))
    return keys


# Lines of the motor over load curves: torque against speed for given no-load speeds, and what they meet.


RUN = 3000  # periods of an orbit that a motor has to stay or leave
ASIDE = 1e-3  # by which share the velocities are off the orbit at the start of that run
MULTIPLIER = 1e-6  # rounding of a multiplier
NAME_PT = 6.5
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
    """Intersection of a motor line and a load curve: mean speed [Hz], torque as drawn, the orbit there."""

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
    """Intersections of the line of a no-load speed [Hz] with a curve: its orbits at that speed."""
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
                axes, speed, f"{line.no_load:g}", va="center",
                fontsize=points(NAME_PT), color="0.3",
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


# Leaps of a motor: where stable orbits end as its no-load speed rises, it has to leave along its line.


TURNING_BACK = 0.01  # of the parameter's range: how far the branch may go on unstable before it turns back
FAR = 0.05  # of the speeds drawn: a leap that can be seen
ARROW = 0.6  # of the way to the last place on the line: where on it the motor comes to stay is not known
LEAP_PT = 7


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
    return bool(risen[: back[0]].max(initial=0.0) <= TURNING_BACK * np.ptp(values))


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
        axes, (leap.start + tip) / 2, f"{leap.line.no_load:.4g}", va="bottom",
        fontsize=points(LEAP_PT),
        color=VERMILLION, gid="leap",
    )  # fmt: skip


# Characteristic of the limited-power motor: torque against speed.


def motor_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Motor torque M0 (1 - w / Omega0), Eq. (2.8), against the speed w, from standstill to no load."""
    figure = sheet(view, 5.4)
    motor_panel(figure.subplots(), subjects)
    return figure


def motor_panel(axes: Axes, subjects: Sequence[Subject]) -> None:
    """The characteristic in given axes."""
    motors = [motor_of(subject.scene) for subject in subjects]
    fastest = 1.1 * max(abs(motor.Omega0) for motor in motors)
    curves = [motor_characteristic(motor, fastest) for motor in motors]
    scale = scale_for("N m", *(torque for _, torque in curves))
    for i, (subject, (speed, torque)) in enumerate(zip(subjects, curves, strict=True)):
        look = nested(i, len(subjects), 1.0) if len(subjects) > 1 else {"color": BLUE, "linewidth": 1.0}
        no_load = motors[i].Omega0 / (2 * math.pi)
        label = rf"{subject.name}: $\Omega_0$ = {no_load:.4g} Hz"
        axes.plot(speed / (2 * math.pi), scale(torque), label=label, gid="motor", **look)
        axes.plot(
            no_load, 0, "o", markersize=3, markerfacecolor="white", markeredgewidth=0.8, color=look["color"]
        )
    axes.axhline(0, color="0.8", linewidth=0.4, zorder=0)
    axes.set_xlabel(f"Motor speed {SPEED} (Hz)")
    axes.set_ylabel(scale.label("Motor torque"))
    note(axes, "ring: no load")
    legend_above(axes)


def motor_characteristic(motor: Motor, fastest: float) -> tuple[np.ndarray, np.ndarray]:
    """Two points of the line: speeds 0 and `fastest` with the sign of Omega0 [rad/s], torques [N m]."""
    speed = np.array([0.0, math.copysign(fastest, motor.Omega0)])
    return speed, motor.M0 * (1 - speed / motor.Omega0)
