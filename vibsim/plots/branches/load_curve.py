"""The load curve: the mean torque that the vibration takes against the mean speed, and what the motor gives.

Over a periodic orbit the rotor comes back to its speed, so the mean torque of the motor is the mean torque
that the vibration takes; and as the motor's torque falls linearly with its speed, Eq. (2.8), that is
M0 (1 - <phi'> / Omega0) with the mean speed <phi'> = 2 pi n / T. Where the line of a no-load speed meets the
curve, the motor can run. On a solid part it stays. On a dashed one the orbit is unstable, and a run from
beside it tells what the motor does: behind a doubling it mostly stays near, on the orbit of twice the period;
behind a fold it leaves. Where the curve turns back, the motor has to leave along its line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from vibsim.plots.branches.curves import keys_to_marks
from vibsim.plots.branches.leaps import draw_leap, leaps_of
from vibsim.plots.branches.motor_lines import (
    Crossing,
    LoadCurve,
    MotorLine,
    crossings,
    draw_motor_lines,
    torque_of,
)
from vibsim.plots.branches.numbered import draw_branches, write_numbers
from vibsim.plots.branches.values import parameter_of
from vibsim.plots.motion.natural_frequencies import motor_of
from vibsim.plots.page.quantities import scale_for
from vibsim.plots.page.sheet import legend_above, legend_below, sheet
from vibsim.plots.style import BLACK, GREY, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

HEIGHT_CM = 8.0
LINES = 6  # of the motor, about


class OperatingMark(NamedTuple):
    """How a place at which the motor can run is drawn, by what the motor does there."""

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
MARKED = ("fold", "doubling", "neimark-sacker", "branch point", "corner")


def draw(subjects: Sequence[Subject], view: View) -> Figure:
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
    drawn = draw_branches(axes, subjects, [(curve.speed, curve.torque) for curve in curves], MARKED)
    _limit(axes, curves, view)
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
    keys = [*keys_to_marks(branches, MARKED), *_keys(bool(leaps))]
    legend_below(figure, keys, [str(key.get_label()) for key in keys])
    write_numbers(axes, drawn)


def _limit(axes: Axes, curves: Sequence[LoadCurve], view: View) -> None:
    """All of the branches, from no torque up."""
    speeds, torques = zip(*(place for curve in curves for place in curve.places()), strict=True)
    low, high = min(speeds), max(speeds)
    axes.set_xlim(*(view.window or (low - 0.03 * (high - low), high + 0.05 * (high - low))))
    axes.set_ylim(min(0.0, *torques), 1.08 * max(torques))


def _round_speeds(curves: Sequence[LoadCurve]) -> list[float]:
    """Round no-load speeds [Hz] that branches have."""
    values = [parameter_of(curve.branch)(point.orbit) for curve in curves for point in curve.branch.points]
    low, high = min(values), max(values)
    ticks = MaxNLocator(LINES, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    return [float(tick) for tick in ticks if low <= tick <= high]


def _mark(axes: Axes, place: Crossing) -> None:
    """What the motor does; a dot and a ring nearly meet where a branch turns back."""
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
