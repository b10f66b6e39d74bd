"""The load curve: the mean torque that the vibration takes against the mean speed, and what the motor gives.

Over a periodic orbit the rotor comes back to its speed, so the mean torque of the motor is the mean torque
that the vibration takes; and as the motor's torque falls linearly with its speed, Eq. (2.10), that is
M0 (1 - <phi'> / Omega0) with the mean speed <phi'> = 2 pi n / T. Where the line of a no-load speed meets the
curve, the motor can run: at the solid parts it stays, from the dashed ones it leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from vibsim.plots.branch_curves import Value, draw_branch, keys_to_marks
from vibsim.plots.branch_values import mean_speed_of, parameter_of, scaled
from vibsim.plots.natural_frequencies import motor_of
from vibsim.plots.quantities import scale_for
from vibsim.plots.sheet import legend_above, legend_below, sheet
from vibsim.plots.style import BLACK, GREY, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

HEIGHT_CM = 8.0
LINES = 6  # of the motor, about
MARKED = ("fold", "doubling", "neimark-sacker", "branch point", "corner")


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Branches over the no-load speed as load curves; lines of the motor; operating points."""
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    branches = [subject.result for subject in subjects]
    torques = [torque_of(branch) for branch in branches]
    values = [[torque(p.orbit) for p in b.points] for b, torque in zip(branches, torques, strict=True)]
    scale = scale_for("N m", *values)
    for i, (subject, branch, torque) in enumerate(zip(subjects, branches, torques, strict=True)):
        label = subject.name if len(subjects) > 1 else ""
        draw_branch(
            axes, branch, mean_speed_of(branch), scaled(torque, scale), overlay(i)["color"], label, MARKED
        )
    _limit(axes, branches, values, scale, view)
    no_load = _no_load_speeds(branches)
    _motor_lines(axes, subjects[0], no_load, scale)
    for branch, torque in zip(branches, torques, strict=True):
        _operating_points(axes, branch, scaled(torque, scale), no_load)
    axes.set_xlabel(r"Mean motor speed $\langle\dot\varphi\rangle/2\pi$ (Hz)")
    axes.set_ylabel(scale.label("Mean torque"))
    if len(subjects) > 1:
        legend_above(axes)
    keys = [*keys_to_marks(branches, MARKED), *_keys()]
    legend_below(figure, keys, [str(key.get_label()) for key in keys])
    return figure


def torque_of(branch: Any) -> Value:
    """Mean torque [N m] of an orbit of a branch over the no-load speed."""
    stall, speed, no_load = motor_of(branch.map.scene).M0, mean_speed_of(branch), parameter_of(branch)
    return lambda orbit: float(stall * (1 - speed(orbit) / no_load(orbit)))


def _limit(axes: Axes, branches: Any, values: Any, scale: Any, view: View) -> None:
    """All of the branches, from no torque up."""
    speeds = [mean_speed_of(branch)(point.orbit) for branch in branches for point in branch.points]
    low, high = min(speeds), max(speeds)
    axes.set_xlim(*(view.window or (low - 0.03 * (high - low), high + 0.05 * (high - low))))
    most = max(max(scale(row)) for row in values)
    axes.set_ylim(min(0.0, min(min(scale(row)) for row in values)), 1.08 * most)


def _no_load_speeds(branches: Sequence[Any]) -> list[float]:
    """Round no-load speeds [Hz] that branches have."""
    spans = [[parameter_of(branch)(point.orbit) for point in branch.points] for branch in branches]
    low, high = min(map(min, spans)), max(map(max, spans))
    ticks = MaxNLocator(LINES, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    return [float(tick) for tick in ticks if low <= tick <= high]


def _motor_lines(axes: Axes, subject: Subject, no_load: Sequence[float], scale: Any) -> None:
    """The motor's torque against its speed for each no-load speed, which is written beside its lower end."""
    stall = motor_of(subject.scene).M0
    x, (low, top) = np.array(axes.get_xlim()), axes.get_ylim()
    for speed in no_load:
        y = scale(stall * (1 - x / speed))
        axes.plot(x, y, color=GREY, linewidth=0.5, scalex=False, scaley=False, zorder=1, gid="motor line")
        end = min(speed * (1 - low / float(scale(stall))), x[1])
        height = float(scale(stall * (1 - end / speed)))
        if x[0] < end and height < top:
            axes.annotate(
                f"{speed:g}", (end, height), (-3, 5) if end == x[1] else (2, 2), fontsize=6, color=GREY,
                textcoords="offset points", ha="right" if end == x[1] else "left", gid="no-load speed",
            )  # fmt: skip


def _operating_points(axes: Axes, branch: Any, torque: Value, no_load: Sequence[float]) -> None:
    """Where the lines of the motor meet a branch: filled where it is stable, open where not."""
    parameter, speed = parameter_of(branch), mean_speed_of(branch)
    for one, other in zip(branch.points, branch.points[1:], strict=False):
        low, high = parameter(one.orbit), parameter(other.orbit)
        for value in no_load:
            if (low - value) * (high - value) <= 0 and low != high:
                share = (value - low) / (high - low)
                x, y = ((1 - share) * of(one.orbit) + share * of(other.orbit) for of in (speed, torque))
                stable = one.orbit.stable if share < 0.5 else other.orbit.stable
                face = BLACK if stable else "white"
                axes.plot(
                    x, y, "o", markersize=3.0, markerfacecolor=face, markeredgecolor=BLACK,
                    markeredgewidth=0.6, zorder=6, gid="operating point",
                )  # fmt: skip


def _keys() -> list[Line2D]:
    keys = [Line2D([], [], color=GREY, linewidth=0.5, label=r"motor, $\Omega_0/2\pi$ in Hz")]
    for label, face in (("runs there", BLACK), ("leaves", "white")):
        key = Line2D([], [], color=BLACK, marker="o", markersize=3, linestyle="none", label=label)
        key.set_markerfacecolor(face)
        key.set_markeredgewidth(0.6)
        keys.append(key)
    return keys
