"""Time histories of the bodies: the whole window, and a detail in which single impacts are seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.ramps import no_load_speed
from vibsim.physics.connections import Pair
from vibsim.physics.parts import BASE, ROTOR, STATE, Scene, columns_of
from vibsim.plots.poincare_sections import TURNS, turn_times
from vibsim.plots.samples import (
    DETAIL_PERIODS,
    POINTS_PER_COLUMN,
    Envelope,
    Series,
    common_window,
    contact_spans,
    detail_span,
    impact_events,
    impacts_of,
    motor_of,
    natural_frequencies,
    period_of,
    series,
    stop_label,
    stop_position,
    window_of,
)
from vibsim.plots.sheet import (
    LEGEND_LINE_CM,
    Level,
    Scale,
    above_wider,
    beside_levels,
    draw_levels,
    hertz_text,
    legend_above,
    legend_lines,
    letter_panels,
    note,
    pixel_columns,
    scale_for,
    sheet,
    symbol,
    time_axis,
)
from vibsim.plots.style import BLUE, GREY, SHADE, SKY, THIN, dashed, nested, overlay, points
from vibsim.plots.subject import Span, Subject, View, as_text, check_one_unit
from vibsim.plots.traces import (
    annotate_runs,
    dense,
    mark_detail,
    samples_are_sparse,
    trust_marks,
)
from vibsim.results.columns import base_motion

DISPLACEMENT, VELOCITY = "m", "m/s"  # what is drawn against time, by the SI unit of the states of bodies
TINY = 1e-4  # of the greatest value of all panels: a panel below that has a unit of its own
WALL_POINTS = 2000  # of a wall that moves with the base
SINGLE_MARKS = 120  # impacts in a detail up to which each gets its own mark on the curves


@dataclass(frozen=True)
class HistoryCurve:
    """One column of one subject, and how it looks.

    alone : whether the picture shows this subject alone
    """

    subject: Subject
    column: str
    label: str
    look: dict[str, Any]
    alone: bool


@dataclass(frozen=True)
class Panel:
    """Axes, and what is drawn on them: curves over a span [s]."""

    axes: Axes
    curves: list[HistoryCurve]
    span: Span

    def unit(self, quantity: str) -> str:
        """The unit that stands for that of a quantity in these curves."""
        return self.curves[0].subject.unit(quantity, self.curves[0].column)

    @cached_property
    def is_short(self) -> bool:
        """Whether single periods can be seen."""
        return is_short(self.curves[0].subject, self.span)

    @cached_property
    def drawn(self) -> list[Series]:
        """Instants [s] and values (SI) of each curve: smooth over a short span, else an envelope."""
        series_of = _short_series if self.is_short else _long_series
        return [series_of(curve, self.span, pixel_columns(self.axes)) for curve in self.curves]

    @property
    def runs(self) -> tuple[list[Subject], list[Any]]:
        """The runs shown and their colours; one of which several bodies are shown counts once, in grey."""
        if self.curves[0].alone:
            return [self.curves[0].subject], [GREY]
        return [curve.subject for curve in self.curves], [curve.look["color"] for curve in self.curves]


def draw_history(subjects: Sequence[Subject], view: View, quantity: str) -> Figure:
    """Panels of the whole window above, of the detail below.

    One subject: all bodies in one panel, those that turn in another. Several: a panel per body, and a detail
    only where the view asks for it (runs that drift apart leave nothing to be seen in a common one).
    """
    groups = curve_groups(subjects, quantity)
    spans = _spans(subjects, view)
    count = len(spans) * len(groups)
    lines = legend_lines([curve.label for curve in groups[0]], view.width_cm)
    of_panels = count * (4.2 if len(groups) == 1 else 3.4)
    figure = sheet(view, 1.0 + of_panels + LEGEND_LINE_CM * (lines - 1))
    panels = list(figure.subplots(count, 1, squeeze=False)[:, 0])
    shown = [(span, group) for span in spans for group in groups]
    histories([Panel(axes, group, span) for axes, (span, group) in zip(panels, shown, strict=True)], quantity)
    for row, axes in enumerate(panels):
        if row % len(groups) < len(groups) - 1:
            axes.tick_params(labelbottom=False)
            axes.set_xlabel("")
        if row < len(groups) and len(spans) == 2:
            mark_detail(axes, spans[1])
    for axes in panels[: len(groups) if len(subjects) == 1 else 1]:
        legend_above(axes)
    letter_panels(panels)
    figure.align_ylabels()
    return figure


def _spans(subjects: Sequence[Subject], view: View) -> list[Span]:
    window = common_window(subjects, view.window)
    if view.detail is None and (len(subjects) > 1 or is_short(subjects[0], window)):
        return [window]
    return [window, detail_span(subjects, view)]


def is_short(subject: Subject, span: Span) -> bool:
    """Whether a span holds so few periods of the source that single ones can be seen."""
    return span[1] - span[0] <= 4 * DETAIL_PERIODS * period_of(subject, span)


def curve_groups(subjects: Sequence[Subject], quantity: str) -> list[list[HistoryCurve]]:
    """The curves of each panel: bodies of one subject together, those that turn in a panel of their own; or
    one body of all subjects.
    """
    if len(subjects) == 1:
        looks = {name: dashed(i) for i, name in enumerate(subjects[0].columns_in(quantity))}
        return [
            [HistoryCurve(subjects[0], name, symbol(name), looks[name], True) for name in names]
            for names in subjects[0].columns_alike(quantity)
        ]
    present = [subject.columns_in(quantity) for subject in subjects]
    count = len(subjects)
    return [
        [
            HistoryCurve(s, name, s.name, nested(i, count), False)
            for i, s in enumerate(subjects)
            if name in present[i]
        ]
        for name in dict.fromkeys(name for names in present for name in names)
    ]


def histories(panels: Sequence[Panel], quantity: str) -> None:
    """Draw panels of one quantity, all of what moves in one unit and all of what turns in another.

    A short span is smooth, with impacts and contact marked; a long one an envelope with a tick per impact.
    """
    units = [panel.unit(quantity) for panel in panels]
    greatest = [_greatest(panel) for panel in panels]
    for panel, unit, own in zip(panels, units, greatest, strict=True):
        alike = [each for each, other in zip(greatest, units, strict=True) if other == unit]
        scale = scale_for(unit, alike if own > TINY * max(alike) else [own])
        draw = _draw_short if panel.is_short else _draw_long
        draw(panel, scale)
        if quantity == DISPLACEMENT and panel.curves[0].alone:
            _draw_walls(panel, scale)
        first = panel.curves[0]
        words = first.subject.word(quantity, first.column).capitalize()
        panel.axes.set_ylabel(scale.label(words if first.alone else symbol(first.column)))
        time_axis(panel.axes, panel.span)


def _greatest(panel: Panel) -> float:
    """The greatest magnitude of what a panel shows (SI)."""
    return max((float(np.abs(values).max(initial=0.0)) for _, values in panel.drawn), default=0.0)


def _draw_long(panel: Panel, scale: Scale) -> None:
    """Envelopes, pale where the bands of several runs may lie upon each other; impacts, trust horizons.

    Dashes make no sense of a band: the legend has those of the detail.
    """
    for curve, (t, values) in zip(panel.curves, panel.drawn, strict=True):
        alpha = 1.0 if curve.alone else 0.6
        look = {**curve.look, "linewidth": THIN, "alpha": alpha, "zorder": above_wider(values)}
        panel.axes.plot(t, scale(values), gid=curve.column, **{**look, "linestyle": "-"})
        panel.axes.plot([], [], label=curve.label, gid="legend", **curve.look)
    subjects, colours = panel.runs
    annotate_runs(panel.axes, subjects, panel.span, colours)


def _draw_short(panel: Panel, scale: Scale) -> None:
    """Smooth curves, impacts marked on them; for a single run, contact shaded."""
    axes, span = panel.axes, panel.span
    marked, said = 0, list[str]()
    for curve, (t, values) in zip(panel.curves, panel.drawn, strict=True):
        axes.plot(t, scale(values), label=curve.label, gid=curve.column, **curve.look)
        marked += _mark_impacts(axes, curve, span, scale)
    said += ["rings: impacts"] if marked else []
    subject = panel.curves[0].subject
    if panel.curves[0].alone and subject.scene.has_stop:
        contacts = contact_spans(subject, span)
        for begin, end in contacts:
            axes.axvspan(begin, end, color=SHADE, linewidth=0, zorder=0, gid="contact")
        said += ["grey: contact"] if contacts else []
    subjects, colours = panel.runs
    note(axes, "; ".join(filter(None, [*said, trust_marks(axes, subjects, span, colours)])))


def _short_series(curve: HistoryCurve, span: Span, columns: int) -> Series:
    """Column against time as smooth as the motion."""
    smooth = dense(curve.subject.result, (curve.column,), window_of(curve.subject, span))
    return smooth["time"], smooth[curve.column]


def _long_series(curve: HistoryCurve, span: Span, columns: int) -> Series:
    """Column against time over a long span; from the engine where samples are sparse."""
    subject, own = curve.subject, window_of(curve.subject, span)
    if samples_are_sparse(subject.scene):
        filled = dense(subject.result, (curve.column,), own, step=period_of(subject, own) / 16)
        return filled["time"], filled[curve.column]
    return series(subject.result, (curve.column,), own, columns)[curve.column]


def _draw_walls(panel: Panel, scale: Scale) -> None:
    """Stops of the ground or the base that a body strikes within the span: the displacement at which it
    does, dashed, and named at the right; of the base it moves along.
    """
    subject, (begin, end) = panel.curves[0].subject, panel.span
    scene, drawn = subject.scene, {curve.column for curve in panel.curves}
    struck = set(impact_events(subject.result, panel.span, "part")[1].tolist())
    for number, stop in enumerate(scene.stops):
        fixed, moving = sorted((stop.P, stop.Q))
        if number not in struck or fixed >= 0 or columns_of(scene.bodies[moving].name)[0] not in drawn:
            continue
        at = stop_position(stop, Pair(stop.name, moving, fixed))
        t = np.linspace(begin, end, WALL_POINTS) if fixed == BASE else np.array([begin, end])
        x = scale(at + (base_motion(scene, t)[0] if fixed == BASE else np.zeros(2)))
        if fixed == BASE and not panel.is_short:
            panel.axes.axhspan(x.min(), x.max(), color=GREY, alpha=0.25, linewidth=0, gid="wall", zorder=1.9)
        else:
            panel.axes.plot(t, x, color=GREY, linewidth=0.7, linestyle=(0, (4, 2)), gid="wall", zorder=1.9)
        panel.axes.annotate(
            stop_label(stop), (1, float(x[-1])), (3, 0), xycoords=("axes fraction", "data"),
            textcoords="offset points", va="center", fontsize=points(6.5), color=GREY, gid="wall name",
        )  # fmt: skip


def _mark_impacts(axes: Axes, curve: HistoryCurve, span: Span, scale: Scale) -> int:
    """Mark the impacts of a body on its curve, unless they are too many; how many are marked."""
    if not curve.subject.scene.has_stop:
        return 0
    t, values = impacts_of(curve.subject, span, curve.column)
    if len(t) > SINGLE_MARKS:
        return 0
    axes.plot(
        t, scale(values), linestyle="none", marker="o", markersize=2.4, markerfacecolor="white",
        markeredgewidth=0.6, color=curve.look["color"], gid="impacts", zorder=3,
    )  # fmt: skip
    return len(t)


# Displacements and velocities of the bodies against time.


def displacement_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """x of each body against time [s], impacts marked, with a detail."""
    return draw_history(subjects, view, DISPLACEMENT)


def velocity_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """v of each body against time [s], impacts marked, with a detail."""
    return draw_history(subjects, view, VELOCITY)


# Speed of the motor against time, with the frequencies at which it may be captured.


NEAR = 0.25  # frequencies up to this part of the drawn range beyond it are drawn too
HEIGHT_CM = 5.6
SPEED = r"$\dot\varphi/2\pi$"


def motor_speed_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """phidot / 2 pi [Hz] against time [s]; no-load speed and natural frequencies as labelled levels."""
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots(gridspec_kw=beside_levels(view))
    motor_speed_panel(axes, subjects, view)
    legend_above(axes)
    return figure


def motor_speed_panel(
    axes: Axes, subjects: Sequence[Subject], view: View, height_cm: float = HEIGHT_CM
) -> None:
    """The speed in given axes, instantaneous as a pale band and averaged over turns as a line.

    height_cm : height of the figure that the axes would fill [cm]
    """
    window = common_window(subjects, view.window)
    low, high = math.inf, -math.inf
    for i, subject in enumerate(subjects):
        span = window_of(subject, window)
        t, phidot = series(subject.result, ("phidot",), span, pixel_columns(axes))["phidot"]
        hertz = phidot / (2 * math.pi)
        low, high = min(low, hertz.min()), max(high, hertz.max())
        pale, clear = _looks(subject, i, len(subjects))
        low, high = _draw_course(axes, subject, t, (low, high), len(subjects) == 1)
        axes.plot(t, hertz, gid="phidot", zorder=above_wider(hertz), **pale)
        mean = mean_speed(subject, span, pixel_columns(axes))
        if len(mean[0]) or len(subjects) > 1:
            axes.plot(*mean, gid="mean", linewidth=0.9, zorder=2.9, **clear)
    colours = [overlay(i)["color"] for i in range(len(subjects))] if len(subjects) > 1 else [GREY]
    annotate_runs(axes, subjects, window, colours, impacts=False)
    _draw_frequencies(axes, subjects, low, high, (height_cm - 1.6) * 28)
    axes.set_ylabel(f"Motor speed {SPEED} (Hz)")
    time_axis(axes, window)


def _draw_course(
    axes: Axes, subject: Subject, t: np.ndarray, limits: tuple[float, float], alone: bool
) -> tuple[float, float]:
    """The no-load speed where it changes with time, as a thin line; the limits with room for it [Hz]."""
    course = None if subject.scene.has_motor else no_load_speed(subject.case, t)
    if course is None:
        return limits
    label = r"$\Omega_0$" if alone else ""
    axes.plot(t, course, color=GREY, linewidth=0.5, zorder=2.95, label=label, gid="no-load")
    return min(limits[0], float(course.min())), max(limits[1], float(course.max()))


def _looks(subject: Subject, index: int, count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Looks of the band and the line of a subject; in a picture of one, both are named."""
    if count == 1:
        return {"color": SKY, "label": "instantaneous"}, {"color": BLUE, "label": f"mean of {TURNS} turns"}
    look = overlay(index)
    return {"color": look["color"], "alpha": 0.35}, {**look, "label": subject.name}


def mean_speed(subject: Subject, span: Span, columns: int) -> Series:
    """Mean speed over TURNS turns of the rotor [Hz] at their middle [s]; an envelope where they are many."""
    turns = turn_times(subject.result, span)
    middle, hertz = (turns[:-TURNS] + turns[TURNS:]) / 2, TURNS / (turns[TURNS:] - turns[:-TURNS])
    if len(middle) <= POINTS_PER_COLUMN * columns:
        return middle, hertz
    envelope = Envelope(*span, columns)
    envelope.add(middle, hertz)
    return envelope.points()


def _draw_frequencies(
    axes: Axes, subjects: Sequence[Subject], low: float, high: float, height_pt: float
) -> None:
    reach = NEAR * (high - low) or 0.1 * abs(high) or 1.0
    levels = [level for level in levels_of(subjects) if low - reach <= level.value <= high + reach]
    low, high = (
        min([low, *(level.value for level in levels)]),
        max([high, *(level.value for level in levels)]),
    )
    margin = 0.06 * (high - low) or 0.1
    axes.set_ylim(low - margin, high + margin)
    draw_levels(axes, levels, height_pt)


def levels_of(subjects: Sequence[Subject]) -> list[Level]:
    """Omega0 of motors and natural frequencies [Hz] of the subjects, equal ones once, with their values."""
    levels: dict[tuple[str, float], Level] = {}
    for subject in subjects:
        named: list[tuple[str, float, dict[str, Any]]] = []
        if subject.scene.has_motor:
            no_load = motor_of(subject.scene).Omega0 / (2 * math.pi)
            named.append((r"$\Omega_0$", no_load, {"linestyle": "-"}))
        named += [(f.label, f.hz, {"linestyle": (0, (4, 2))}) for f in natural_frequencies(subject.scene)]
        for label, hz, look in named:
            levels.setdefault((label, hz), Level(hz, f"{label}  {hertz_text(hz)}", look))
    return list(levels.values())


# Speeds of the rotors, and further states, against time.


def rotor_speed_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Speed of each rotor over 2 pi [Hz] against time [s], with the natural frequencies."""
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots(gridspec_kw=beside_levels(view))
    rotor_speed_panel(axes, subjects, view)
    legend_above(axes)
    return figure


def rotor_speed_panel(
    axes: Axes, subjects: Sequence[Subject], view: View, height_cm: float = HEIGHT_CM
) -> None:
    """The speeds in given axes; height_cm : height of the figure that the axes would fill [cm]."""
    window = common_window(subjects, view.window)
    alone = len(subjects) == 1
    curves = [
        HistoryCurve(subject, w, name if alone else f"{subject.name}: {name}", {}, alone)
        for subject in subjects
        for name, w in rotor_speeds(subject.scene).items()
    ]
    panel = Panel(axes, curves, window)
    low, high = math.inf, -math.inf
    for i, (curve, (t, values)) in enumerate(zip(curves, panel.drawn, strict=True)):
        hertz = values / (2 * math.pi)
        low, high = min(low, hertz.min()), max(high, hertz.max())
        axes.plot(t, hertz, label=curve.label, gid=curve.column, zorder=above_wider(hertz), **dashed(i))
    colours = [overlay(i)["color"] for i in range(len(subjects))] if len(subjects) > 1 else [GREY]
    annotate_runs(axes, subjects, window, colours, impacts=False)
    _draw_frequencies(axes, subjects, low, high, (height_cm - 1.6) * 28)
    axes.set_ylabel("Rotor speed (Hz)")
    time_axis(axes, window)


def rotor_speeds(scene: Scene) -> dict[str, str]:
    """Columns of the speeds of the rotors by their names."""
    return {body.name: body.columns[1] for body in scene.bodies if body.kind == ROTOR}


PREFIXED = ("A", "V", "W", "J", "N", "m", "m/s", "Pa", "C", "Wb")  # units that take a prefix


def states_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Each further state of the scenes against time [s], in a panel of its own."""
    names = dict.fromkeys(name for subject in subjects for name in state_names(subject.scene))
    window = common_window(subjects, view.window)
    figure = sheet(view, 1.0 + 3.4 * len(names))
    panels = list(figure.subplots(len(names), 1, squeeze=False, sharex=True)[:, 0])
    for axes, name in zip(panels, names, strict=True):
        present = [subject for subject in subjects if name in subject.tables.states]
        _state_panel(axes, present, name, window, len(subjects))
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
        axes.set_xlabel("")
    if len(subjects) > 1:
        legend_above(panels[0])
    letter_panels(panels)
    figure.align_ylabels()
    return figure


def _state_panel(axes: Axes, subjects: Sequence[Subject], name: str, window: Span, count: int) -> None:
    looks = [
        nested(i, count) if count > 1 else {"color": BLUE, "linewidth": 0.8} for i in range(len(subjects))
    ]
    curves = [
        HistoryCurve(one, name, one.name, look, count == 1) for one, look in zip(subjects, looks, strict=True)
    ]
    panel = Panel(axes, curves, window)
    units = [(one.path, dict(one.scene.state_units).get(name, "")) for one in subjects]
    check_one_unit(f"state {name}", units)
    unit = units[0][1]
    scale = scale_for(unit, *(values for _, values in panel.drawn)) if unit in PREFIXED else Scale(1.0, unit)
    for curve, (t, values) in zip(curves, panel.drawn, strict=True):
        axes.plot(t, scale(values), label=curve.label, gid=name, zorder=above_wider(values), **curve.look)
    runs, colours = panel.runs
    annotate_runs(axes, runs, window, colours, impacts=False)
    axes.set_ylabel(scale.label(as_text(name)) if unit else as_text(name))
    time_axis(axes, window)


def state_names(scene: Scene) -> list[str]:
    """Names of the further states of a scene."""
    return [body.name for body in scene.bodies if body.kind == STATE]
