"""Basins of attraction of a motion without a source: which starts end at rest, which in vibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.problems import counted
from vibsim.plots.branch_curves import LabelledPoint, label_points
from vibsim.plots.branches_over_sweeps import (
    OVER_SPEEDS,
    check_branches,
    lay_branches,
    name_branches,
    speeds,
)
from vibsim.plots.capture_pictures import (
    Pictures,
    Shade,
    lay_classes,
    legend_of,
    map_sheet,
    percent_of,
    say,
    share_map,
    starts_sheet,
)
from vibsim.plots.samples import mark_frequencies
from vibsim.plots.sheet import (
    Level,
    Scale,
    beside_levels,
    draw_levels,
    legend_below,
    letter_panels,
    note,
    scale_for,
    sheet,
)
from vibsim.plots.slow_passages import run_power_picture
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, PINK, SKY, VERMILLION, YELLOW
from vibsim.plots.subject import Subject, View, as_text
from vibsim.plots.sweep_axes import (
    along,
    ascending,
    axis_label,
    draws_by_ratio,
    is_motor_speed,
    is_speed,
    label_of,
    numbers,
    plane_of,
    show_span,
    speed_column,
    speed_rotor,
)
from vibsim.plots.sweep_curves import (
    PAGE_CM,
    Curve,
    alone,
    curve_panels,
    curves,
    draw_bands,
    draw_curve,
    ensemble_note,
    families,
    fill,
    finish,
    frequencies,
    in_columns,
    label_outer,
    leaps,
    limit,
    name_curves,
    no_load_speeds,
    spread_over,
)
from vibsim.sweeps.contact_computations import VERDICTS
from vibsim.sweeps.points import Share

END_STATE_HEIGHT_CM = 6.8
UNDRAWN = 0.005  # greatest share of a curve that would lie on the axis
EDGE = 0.02  # of the range, beside the first and last mark
COLOURS = {"undecided": VERMILLION, "rest": BLUE, "vibration": ORANGE}
SHADES = [Shade(name, COLOURS[name]) for name in VERDICTS]
MARKS = {"undecided": "^", "rest": "o", "vibration": "s"}


def end_state_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """A map, shares or starts, as suits the sweep.

    Two ranges: the verdict on every point, as colours; with an ensemble at every point, the share of its
    members that come to rest. One range and an ensemble: the share of each verdict against the range. An
    ensemble alone over two start values: its starts, coloured by the verdict.
    """
    (subject,) = subjects
    return PICTURES.draw(subject, view)


def _draw_map(subject: Subject, view: View) -> Figure:
    plane, verdicts = plane_of(subject), subject.result["end_state"]
    figure, panels = map_sheet(plane, 1, view)
    for d, axes in enumerate(panels):
        lay_classes(axes, plane, plane.grid(verdicts, d), SHADES, "end_state")
    legend_of(figure, SHADES, verdicts[..., : len(panels)])
    return figure


def _draw_shares(subject: Subject, view: View) -> Figure:
    """Shares with Wilson's interval of 95 %, which is a bar where it is wider than a mark."""
    result = subject.result
    axis = result.axes[along(result)]
    figure = sheet(view, END_STATE_HEIGHT_CM)
    axes = figure.subplots()
    for shade in SHADES:
        share = result.probability(result["end_state"] == VERDICTS[shade.name])
        if np.nanmax(share.estimate) > UNDRAWN:
            _draw_share(axes, axis, share, shade)
    axes.set_ylim(-0.03, 1.03)
    x = numbers(axis)[ascending(axis)]
    show_span(axes, (x[0], x[-1]), EDGE, draws_by_ratio(axis), view)
    axes.set_xlabel(label_of(axis))
    axes.set_ylabel("Share of the starts")
    figure.legend(loc="outside lower center", ncols=2)
    doubts = int(np.count_nonzero(result["end_state"] == VERDICTS["undecided"]))
    doubts_text = f"; {doubts} undecided" if doubts else ""
    say(axes, f"{counted(len(result.members), 'start')} each; bars: 95 %{doubts_text}", subject)
    return figure


def _draw_share(axes: Axes, axis: Any, share: Share, shade: Shade) -> None:
    order = ascending(axis)
    x = numbers(axis)[order]
    estimate, low, high = (v[..., 0].ravel()[order] for v in (share.estimate, share.low, share.high))
    bars = np.array([estimate - low, high - estimate])
    drawn = axes.errorbar(
        x, estimate, np.maximum(bars, 0), label=shade.name, color=shade.colour, marker=MARKS[shade.name],
        markersize=2.5, capsize=1.5, elinewidth=0.7,
    )  # fmt: skip
    drawn.lines[0].set_gid(shade.name)


def _draw_starts(subject: Subject, view: View) -> Figure:
    """Two start values of the members; of one alone, against the displacement at the end."""
    result = subject.result
    verdicts = result["end_state"][..., 0].ravel()

    def displacement() -> tuple[np.ndarray, str]:
        name = next(name for name in result.plan.columns if name.startswith("end_x"))
        return result[name], f"{name.removeprefix('end_')} at the end ({result.plan.columns[name].units})"

    figure, axes = starts_sheet(subject, view, END_STATE_HEIGHT_CM, verdicts, SHADES, displacement)
    say(axes, f"rest: {percent_of(result, result['end_state'] == VERDICTS['rest'])}", subject)
    legend_of(figure, SHADES, verdicts)
    return figure


PICTURES = Pictures(
    _draw_map, _draw_starts, _draw_shares, share_map("end_state", VERDICTS["rest"], "at rest")
)  # after the functions that it names


# The Lyapunov diagram: exponents against what was swept.


LYAPUNOV_HEIGHT_CM = 6.0
LYAPUNOV_PANEL_CM, LYAPUNOV_PANEL_WIDTH_CM = 4.2, 5.4
TOGETHER = 2  # curves in one panel: up and down
FURTHER = ((ORANGE, "s"), (GREEN, "^"), (PINK, "v"), (BLACK, "D"), (SKY, "x"), (YELLOW, "+"))
LARGEST, SPECTRUM = "lyapunov", "lyapunov_spectrum"


def lyapunov_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Lyapunov exponents [1/s], the largest with its interval of 95 %, all of them where they are stored.

    Up and down share a panel; more curves, or several exponents of each, have a panel each.
    """
    every = curves(subjects)
    spectrum = any(SPECTRUM in curve.subject.result.plan.columns for curve in every)
    if len(every) > TOGETHER or (spectrum and len(every) > 1):
        sheets = curve_panels(every, view, (LYAPUNOV_PANEL_CM,), LYAPUNOV_PANEL_WIDTH_CM)
        figure, panels = sheets.figure, sheets.panels
        groups, remark = [[alone(curve)] for curve in sheets.drawn], sheets.omitted
        top_right = sheets.top_right
    else:
        figure = sheet(view, LYAPUNOV_HEIGHT_CM)
        top_right = figure.subplots()
        panels, groups, remark = np.array([[top_right]]), [every], ""
    for axes, group in zip(panels[:, 0], groups, strict=True):
        exponent_panel(axes, group)
    limit(panels[0, 0], every, view)
    label_outer(panels, axis_label(subjects), [exponent_label(every)])
    note(top_right, "; ".join(filter(None, [remark, exponent_note(every)])))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    named = [(handle, label) for handle, label in zip(handles, labels, strict=True) if label]
    if len(named) > 1:
        legend_below(figure, *zip(*named, strict=True))
    return figure


def has_exponents(subjects: Sequence[Subject]) -> bool:
    """Whether every sweep has Lyapunov exponents."""
    return all({LARGEST, SPECTRUM} & set(subject.result.plan.columns) for subject in subjects)


def exponent_panel(axes: Axes, drawn: Sequence[Curve]) -> None:
    """The exponents of the curves in given axes; where all of a curve are known, each in its colour."""
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1, gid="zero")
    for curve in drawn:
        spectrum = SPECTRUM in curve.subject.result.plan.columns
        name, values, half = _largest(curve)
        if half is not None:
            axes.vlines(
                curve.x, values - half, values + half, color=curve.colour, alpha=0.5, linewidth=1.0,
                gid="interval",
            )  # fmt: skip
        draw_bands(axes, curve, name, np.asarray)
        look = {**curve.look, "markersize": 1.6}
        label = r"$\lambda_1$" if spectrum and len(drawn) == 1 else curve.label
        axes.plot(curve.x, values, label=label, gid="exponent", zorder=3, **look)
        if spectrum:
            _further(axes, curve, named=curve is drawn[0])
    axes.margins(y=0.06)


def _further(axes: Axes, curve: Curve, named: bool) -> None:
    """The exponents after the largest, each with a colour and a mark of its own."""
    for i, others in enumerate(curve.values(SPECTRUM).T[1:]):
        colour, marker = FURTHER[i % len(FURTHER)]
        axes.plot(
            curve.x, others, color=colour, linewidth=0.5, marker=marker, markersize=1.8, markeredgewidth=0.3,
            label=rf"$\lambda_{{{i + 2}}}$" if named else "", gid="further exponent",
        )  # fmt: skip


def exponent_label(drawn: Sequence[Curve]) -> str:
    """Label of the axis of the exponents."""
    spectrum = any(SPECTRUM in curve.subject.result.plan.columns for curve in drawn)
    return r"Exponents $\lambda_i$ (1/s)" if spectrum else r"Exponent $\lambda_1$ (1/s)"


def exponent_note(drawn: Sequence[Curve]) -> str:
    """Words for the bars or bands about the largest exponent."""
    return ensemble_note(drawn) or "bars: 95 %"


def _largest(curve: Curve) -> tuple[str, np.ndarray, np.ndarray | None]:
    """Column of the largest exponent, its values and the half width of its interval (n).

    Of an ensemble the median, and no interval: the bands tell more.
    """
    if LARGEST in curve.subject.result.plan.columns:
        half = None if curve.members else curve.values(f"{LARGEST}_half_width")
        return LARGEST, curve.values(LARGEST), half
    half = None if curve.members else curve.values(f"{SPECTRUM}_half_width")[:, 0]
    return SPECTRUM, curve.values(SPECTRUM)[:, 0], half


# Power flow: what the source gives on the average, and where it goes, against what was swept.


POWER_PANEL_CM = 4.4
POWER_PANEL_WIDTH_CM = 5.4
MARGINS_CM = 4.4  # names of frequencies above, label and legend below
GIVERS = ("power_source", "power_base", "power_belts")
TAKERS = {
    "power_damper": ("damper", PALE, ""),
    "power_stops": ("stops", GREEN, ""),
    "power_friction": ("friction", ORANGE, ""),
    "power_stored": ("stored (beyond the line: released)", PINK, "////"),
}  # words, colour and hatches


def power_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Mean power of all sources [W] as a line; what dampers, stops and friction take and what is stored as
    areas.

    The areas add up to the line (first law); of an ensemble all are means, and bands hold the members. One
    panel for each curve of the sweep, or for some of them, evenly spread, where a page has no room for all.
    Of runs, powers over time.
    """
    if any(subject.reads == "trajectory" for subject in subjects):
        return run_power_picture(subjects, view)
    every = curves(subjects)
    sheet = curve_panels(every, view, (POWER_PANEL_CM,), POWER_PANEL_WIDTH_CM, MARGINS_CM)
    panels = sheet.panels[:, 0]
    limit(panels[0], sheet.drawn, view)
    scale = scale_for(
        "W",
        *(
            values
            for curve in sheet.drawn
            for values in (source_power(curve), *absorbed_powers(curve).values())
        ),
    )
    for axes, curve in zip(panels, sheet.drawn, strict=True):
        _power_panel(axes, curve, scale)
    label_outer(sheet.panels, axis_label(subjects), [scale.label("Mean power")])
    members = [
        f"mean of {counted(c.members, 'member')}, source with bands" for c in sheet.drawn if c.members
    ][:1]
    note(sheet.top_right, "; ".join(filter(None, [sheet.omitted, *members])))
    if all(is_speed(subject.result.axes[along(subject.result)].key) for subject in subjects):
        columns = len({axes.get_subplotspec().colspan.start for axes in panels})
        for i in range(columns):
            width_pt = (view.width_cm / columns - 1.6) * 28
            mark_frequencies(list(panels[i::columns]), frequencies(subjects), width_pt)
    handles, labels = panels[0].get_legend_handles_labels()
    legend_below(sheet.figure, handles, labels)
    return sheet.figure


def source_power(curve: Curve) -> np.ndarray:
    """Mean power that sources, base and belts give together along a curve [W] (n)."""
    names = [name for name in GIVERS if name in curve.subject.result.plan.columns]
    total: np.ndarray = sum((curve.mean(name) for name in names[1:]), curve.mean(names[0]))
    return total


def absorbed_powers(curve: Curve) -> dict[str, np.ndarray]:
    """Mean powers that are taken and stored along a curve [W] (n), by column; those that are 0 left out."""
    names = [name for name in TAKERS if name in curve.subject.result.plan.columns]
    powers = {name: curve.mean(name) for name in names}
    return {name: values for name, values in powers.items() if name != "power_stops" or np.any(values)}


def _power_panel(axes: Axes, curve: Curve, scale: Scale) -> None:
    below, apart = np.zeros(len(curve.x)), leaps(source_power(curve))
    for name, values in absorbed_powers(curve).items():
        words, colour, hatch = TAKERS[name]
        above = below + scale(values)
        look: dict[str, Any] = {"facecolor": colour, "edgecolor": "0.25", "hatch": hatch, "linewidth": 0}
        fill(axes, curve.x, below, above, apart, label=words, gid=name, **look)
        below = above
    source = replace(curve, colour=BLACK)
    single = [
        name for name in GIVERS if name in curve.subject.result.plan.columns and np.any(curve.mean(name))
    ]
    if len(single) == 1:
        draw_bands(axes, source, single[0], scale)
    draw_curve(axes, replace(source, label="source"), scale(source_power(curve)), "power_source")
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1)


# The Sommerfeld diagram: steady speed of the motor against its no-load speed.


SOMMERFELD_HEIGHT_CM = 7.0
SOMMERFELD_PANEL_CM = 4.8
DASHED = (0, (4, 2))
STEADY_SPEED = r"Steady motor speed $\langle\dot\varphi\rangle/2\pi$ (Hz)"
VISIBLE = 0.005  # of the height of the axes: speeds up and down that are further apart are told apart
SHORT = r"Steady speed $\langle\dot\varphi\rangle/2\pi$ (Hz)"  # beside a low panel


def sommerfeld_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Mean speed [Hz] against Omega0 [Hz], or what sets it; natural frequencies and fractions as levels.

    Points on the thin line turn at the no-load speed; a plateau below it is a capture: the power of the motor
    goes into vibration. One curve has its least to greatest speed as a band; up and down have the hysteresis
    between them shaded, and a panel for each value of what else was swept. Branches of periodic orbits lie
    over the curves of the same values, solid where stable, dashed where not.
    """
    branches = [subject for subject in subjects if subject.reads == "branch"]
    subjects = [subject for subject in subjects if subject.reads == "sweep"]
    check_branches(subjects, branches)
    drawn = curves(subjects)
    groups = [drawn]
    omitted = ""
    if len(subjects) == 1 and subjects[0].result.plan.carry:
        every = [[alone(curve) for curve in group] for group in families(drawn)]
        groups = spread_over(every, in_columns(len(every), view) * int((PAGE_CM - 1.6) / SOMMERFELD_PANEL_CM))
        omitted = f"{len(groups)} of {len(every)} values" if len(groups) < len(every) else ""
    columns = in_columns(len(groups), view)
    rows = -(-len(groups) // columns)
    height_cm = SOMMERFELD_HEIGHT_CM if len(groups) == 1 else SOMMERFELD_PANEL_CM * rows + 1.6
    figure = sheet(view, height_cm)
    beside = beside_levels(view)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True, gridspec_kw=beside)
    limit(grid[0, 0], drawn, view)
    free = [no_load_line(group[0], grid[0, 0].get_xlim()) for group in groups]
    grid[0, 0].set_ylim(*_limits(drawn, grid[0, 0].get_xlim(), free, any(map(_is_banded, groups))))
    levels = [Level(f.hz, f.text, {"linestyle": DASHED}) for f in frequencies(subjects, parts=True)]
    marks: list[tuple[Axes, list[LabelledPoint]]] = []
    for i, (axes, group) in enumerate(zip(grid.flat, groups, strict=False)):
        look = {"color": GREY, "linewidth": 0.5, "zorder": 1, "gid": "no-load", "label": "no-load speed"}
        if np.isfinite(free[i][1]).any():
            axes.plot(*free[i], scalex=False, scaley=False, **look)
        _sommerfeld_panel(axes, group, len(groups) > 1)
        of_branches = speeds(speed_rotor(group[0].subject))
        marks += [(axes, lay_branches(axes, group, branches, of_branches, OVER_SPEEDS))]
        last = (i + 1) % columns == 0 or i + 1 == len(groups)
        draw_levels(axes, levels, (height_cm - 1.6) / rows * 28, named=last)
    finish(grid, len(groups), axis_label(subjects), _speed_label(subjects, len(groups) == 1))
    panels = list(grid.ravel()[: len(groups)])
    remarks = [panels[0].get_title(loc="right") if len(panels) == 1 else "", omitted, ensemble_note(drawn)]
    note(panels[columns - 1], "; ".join(filter(None, remarks)))
    name_curves(
        figure, panels, [curve for group in groups for curve in group] if len(groups) == 1 else groups[0]
    )
    name_branches(figure, panels[columns - 1], subjects, branches, drawn, OVER_SPEEDS)
    letter_panels(panels)
    for axes, labels in marks:
        label_points(axes, labels)
    return figure


def _speed_label(subjects: Sequence[Subject], alone: bool) -> str:
    """Label of the speeds; in a scene of rotors it names the one that is drawn."""
    rotors = dict.fromkeys(filter(None, map(speed_rotor, subjects)))
    if rotors:
        return f"Steady speed of {as_text(', '.join(rotors))} (Hz)"
    return STEADY_SPEED if alone else SHORT


def _sommerfeld_panel(axes: Axes, drawn: Sequence[Curve], titled: bool) -> None:
    """The curves of one panel."""
    if _is_banded(drawn):
        (curve,) = drawn
        least, greatest = (curve.values(name) for name in ("min_speed", "max_speed"))
        look = {"color": curve.colour, "alpha": 0.2, "linewidth": 0, "gid": "band"}
        fill(axes, curve.x, least, greatest, leaps(curve.values("mean_speed")), **look)
        note(axes, "band: least to greatest")
    for curve in drawn:
        draw_bands(axes, curve, speed_column(curve.subject), np.asarray)
        draw_curve(axes, curve, curve.values(speed_column(curve.subject)), "mean")
    if len(drawn) == 2 and drawn[0].family == drawn[1].family:
        up, down = (curve.values(speed_column(curve.subject)) for curve in drawn)
        apart = np.union1d(leaps(up), leaps(down))
        look = {"color": ORANGE, "alpha": 0.3, "linewidth": 0, "gid": "hysteresis", "label": "hysteresis"}
        if np.abs(up - down).max(initial=0, where=np.isfinite(up - down)) > VISIBLE * np.ptp(axes.get_ylim()):
            fill(axes, drawn[0].x, up, down, apart, **look)
    if titled:
        axes.set_title(drawn[0].title, loc="left", pad=3)


def _is_banded(drawn: Sequence[Curve]) -> bool:
    return len(drawn) == 1 and drawn[0].members is None and "min_speed" in drawn[0].subject.result


def no_load_line(curve: Curve, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Line of the no-load speed: values along the axis within a span, and speeds [Hz].

    Over Omega0 the diagonal of the whole span, else through the points of the curve.
    """
    if is_motor_speed(curve.subject.result.axes[along(curve.subject.result)].key):
        return np.array(span), np.array(span)
    inside = (curve.x >= span[0]) & (curve.x <= span[1])
    return curve.x[inside], no_load_speeds(curve)[inside]


def _limits(
    drawn: Sequence[Curve],
    span: tuple[float, float],
    free: Sequence[tuple[np.ndarray, np.ndarray]],
    banded: bool,
) -> tuple[float, float]:
    """Room for speeds, bands where they are drawn, and the lines of the no-load speed."""
    shown = [
        curve.values(name)[(curve.x >= span[0]) & (curve.x <= span[1])]
        for curve in drawn
        for name in (("min_speed", "max_speed") if banded else (speed_column(curve.subject),))
    ]
    values = np.concatenate([*shown, *(speeds for _, speeds in free)])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.03 * (high - low)
    return low - margin, high + margin
