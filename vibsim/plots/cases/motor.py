"""Characteristic of the limited-power motor: torque against speed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.physics.parts import Motor
from vibsim.plots.motion.natural_frequencies import motor_of
from vibsim.plots.page.quantities import scale_for
from vibsim.plots.page.sheet import legend_above, sheet
from vibsim.plots.runs.motor_speed import SPEED
from vibsim.plots.style import BLUE, nested
from vibsim.plots.subject import Subject
from vibsim.plots.view import View


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Motor torque M0 (1 - w / Omega0), Eq. (2.8), against the speed w, from standstill to no load."""
    figure = sheet(view, 5.4)
    motor_panel(figure.subplots(), subjects)
    return figure


def motor_panel(axes: Axes, subjects: Sequence[Subject]) -> None:
    """The characteristic in given axes."""
    motors = [motor_of(subject.scene) for subject in subjects]
    fastest = 1.1 * max(abs(motor.Omega0) for motor in motors)
    curves = [characteristic(motor, fastest) for motor in motors]
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
    legend_above(axes)


def characteristic(motor: Motor, fastest: float) -> tuple[np.ndarray, np.ndarray]:
    """Two points of the line: speeds 0 and `fastest` with the sign of Omega0 [rad/s], torques [N m]."""
    speed = np.array([0.0, math.copysign(fastest, motor.Omega0)])
    return speed, motor.M0 * (1 - speed / motor.Omega0)
