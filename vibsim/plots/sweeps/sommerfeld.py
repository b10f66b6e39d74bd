"""The Sommerfeld diagram: steady speed of the motor against its no-load speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.branches.over_sweep import lay_branches, name_branches
from vibsim.plots.page.margin_labels import Level, draw_levels
from vibsim.plots.page.sheet import letter_panels, note, sheet
from vibsim.plots.style import GREY, ORANGE
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import axis_label
from vibsim.plots.sweeps.curves import (
    Curve,
    alone,
    curves,
    draw_bands,
    ensemble_note,
    families,
    frequencies,
    limit,
    name_curves,
)
from vibsim.plots.sweeps.panels import PAGE_CM, finish, in_columns, spread_over
from vibsim.plots.view import View

HEIGHT_CM = 7.0
PANEL_CM = 4.8
DASHED = (0, (4, 2))
SPEED = r"Steady motor speed $\langle\dot\varphi\rangle/2\pi$ (Hz)"
SHORT = r"Steady speed $\langle\dot\varphi\rangle/2\pi$ (Hz)"  # beside a low panel


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Mean speed [Hz] against Omega0 [Hz]; natural frequencies and fractions of them as levels.

    Points on the thin line turn at the no-load speed; a plateau below it is a capture: the power of the motor
    goes into vibration. One curve has its least to greatest speed as a band; up and down have the hysteresis
    between them shaded, and a panel for each value of what else was swept. Branches of periodic orbits lie
    over the curves of the same values, solid where stable, dashed where not.
    """
    branches = [subject for subject in subjects if subject.reads == "branch"]
    subjects = [subject for subject in subjects if subject.reads == "sweep"]
    drawn = curves(subjects)
    groups = [drawn]
    omitted = ""
    if len(subjects) == 1 and subjects[0].result.plan.carry:
        every = [[alone(curve) for curve in group] for group in families(drawn)]
        groups = spread_over(every, in_columns(len(every), view) * int((PAGE_CM - 1.6) / PANEL_CM))
        omitted = f"{len(groups)} of {len(every)} values" if len(groups) < len(every) else ""
    columns = in_columns(len(groups), view)
    rows = -(-len(groups) // columns)
    height_cm = HEIGHT_CM if len(groups) == 1 else PANEL_CM * rows + 1.6
    figure = sheet(view, height_cm)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    limit(grid[0, 0], drawn, view)
    grid[0, 0].set_ylim(*_limits(drawn, np.array(grid[0, 0].get_xlim()), any(map(_is_banded, groups))))
    levels = [
        Level(f.hz, f"{f.label}  {f.hz:.2f}", {"linestyle": DASHED})
        for f in frequencies(subjects, parts=True)
    ]
    for i, (axes, group) in enumerate(zip(grid.flat, groups, strict=False)):
        _panel(axes, group, len(groups) > 1)
        lay_branches(axes, group, branches)
        last = (i + 1) % columns == 0 or i + 1 == len(groups)
        draw_levels(axes, levels, (height_cm - 1.6) / rows * 28, named=last)
    finish(grid, len(groups), axis_label(subjects), SPEED if len(groups) == 1 else SHORT)
    panels = list(grid.ravel()[: len(groups)])
    remarks = [panels[0].get_title(loc="right") if len(panels) == 1 else "", omitted, ensemble_note(drawn)]
    note(panels[columns - 1], "; ".join(filter(None, remarks)))
    name_curves(
        figure, panels, [curve for group in groups for curve in group] if len(groups) == 1 else groups[0]
    )
    name_branches(figure, branches)
    letter_panels(panels)
    return figure


def _panel(axes: Axes, drawn: Sequence[Curve], titled: bool) -> None:
    """The curves of one panel."""
    span = np.array(axes.get_xlim())
    axes.plot(span, span, color=GREY, linewidth=0.5, scalex=False, scaley=False, zorder=1, gid="no-load")
    if _is_banded(drawn):
        (curve,) = drawn
        axes.fill_between(
            curve.x, curve.values("min_speed"), curve.values("max_speed"),
            color=curve.colour, alpha=0.2, linewidth=0, gid="band",
        )  # fmt: skip
        note(axes, "band: least to greatest")
    for curve in drawn:
        draw_bands(axes, curve, "mean_speed", np.asarray)
        axes.plot(curve.x, curve.values("mean_speed"), label=curve.label, gid="mean", zorder=3, **curve.look)
    if len(drawn) == 2 and drawn[0].family == drawn[1].family:
        up, down = (curve.values("mean_speed") for curve in drawn)
        axes.fill_between(
            drawn[0].x, up, down, color=ORANGE, alpha=0.3, linewidth=0, gid="hysteresis", label="hysteresis"
        )
    if titled:
        axes.set_title(drawn[0].title, loc="left", pad=3)


def _is_banded(drawn: Sequence[Curve]) -> bool:
    return len(drawn) == 1 and drawn[0].members is None


def _limits(drawn: Sequence[Curve], span: np.ndarray, banded: bool) -> tuple[float, float]:
    """Room for speeds, bands where they are drawn, and the line of the no-load speed."""
    names = ("min_speed", "max_speed") if banded else ("mean_speed",)
    shown = [
        curve.values(name)[(curve.x >= span[0]) & (curve.x <= span[1])] for curve in drawn for name in names
    ]
    values = np.concatenate([*shown, span])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.03 * (high - low)
    return low - margin, high + margin
