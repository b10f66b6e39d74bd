"""Branches of periodic orbits over their parameter: mean speed of the motor, or amplitude."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from vibsim.plots.branches.curves import keys_to_marks
from vibsim.plots.branches.numbered import draw_branches, write_numbers
from vibsim.plots.branches.values import (
    amplitude_of,
    amplitude_words,
    mean_speed_of,
    parameter_label,
    parameter_of,
    scaled,
)
from vibsim.plots.page.quantities import Scale, scale_for
from vibsim.plots.page.sheet import legend_above, legend_below, sheet
from vibsim.plots.style import GREY
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import is_motor_speed
from vibsim.plots.view import View

HEIGHT_CM = 7.0
SPEED = r"Mean motor speed $\langle\dot\varphi\rangle/2\pi$ (Hz)"


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Solid where orbits are stable, dashed where not, marks at bifurcations; several are numbered.

    Under a motor its mean speed against the parameter, with the line of the no-load speed; else the amplitude
    of the first displacement.
    """
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    branches = [subject.result for subject in subjects]
    motor = all(subject.scene.has_motor for subject in subjects)
    values = [mean_speed_of(branch) if motor else amplitude_of(branch) for branch in branches]
    every = [[value(p.orbit) for p in b.points] for b, value in zip(branches, values, strict=True)]
    unit = Scale(1.0, "Hz") if motor else scale_for("m", *every)
    drawn = draw_branches(
        axes,
        subjects,
        [(parameter_of(branch), scaled(value, unit)) for branch, value in zip(branches, values, strict=True)],
    )
    axes.margins(x=0.02)
    if view.window is not None:
        axes.set_xlim(*view.window)
    if motor and is_motor_speed(branches[0].key):
        span = axes.get_xlim()
        axes.plot(span, span, color=GREY, linewidth=0.5, scalex=False, scaley=False, zorder=1, gid="no-load")
    axes.set_xlabel(parameter_label(subjects))
    axes.set_ylabel(SPEED if motor else unit.label(amplitude_words(branches[0])))
    if len(subjects) > 1:
        legend_above(axes)
    keys = keys_to_marks(branches)
    legend_below(figure, keys, [str(key.get_label()) for key in keys])
    write_numbers(axes, drawn)
    return figure
