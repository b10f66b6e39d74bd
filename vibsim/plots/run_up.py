"""Slow passages: amplitude and motor speed while the no-load speed of the motor goes up and down."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.ramps import no_load_speed
from vibsim.plots.pairs import PlottedPair, common_pairs, shown_part, trust_remark
from vibsim.plots.samples import natural_frequencies, window_of
from vibsim.plots.sheet import (
    Level,
    draw_levels,
    legend_above,
    letter_panels,
    note,
    say_inside,
    scale_for,
    seconds,
    sheet,
    time_axis,
)
from vibsim.plots.spectra import TURNS, TurnExtremes, extremes_by_turn
from vibsim.plots.style import BLUE, GREY, VERMILLION, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import along, is_motor_speed
from vibsim.plots.sweep_curves import DIRECTION_NAMES, DOWN, UP, Curve, curves
from vibsim.plots.traces import VECTOR_UP_TO
from vibsim.plots.view import PlotError, Span, View

HEIGHT_CM = 9.6
NO_LOAD = r"No-load speed $\Omega_0/2\pi$ (Hz)"
SPEED = r"Motor speed $\dot\varphi/2\pi$ (Hz)"
COLOURS = {UP: BLUE, DOWN: VERMILLION}
PALE, PALER = "0.25", "0.6"  # greys of a sweep under the runs: upwards, downwards
LEVEL_PT = 110  # about the height of the lower panel


@dataclass(frozen=True)
class Way:
    """The turns of one run in which the no-load speed goes in one direction, or all where it does not change.

    direction : UP or DOWN; 0 over time
    x : no-load speed [Hz] at the middle of each turn (n), or the time [s]
    turns : speeds and extremes of these turns (n)
    """

    subject: Subject
    direction: int
    x: np.ndarray
    turns: TurnExtremes

    @property
    def amplitude(self) -> np.ndarray:
        """Half of the way from the least to the greatest displacement of each turn [m]."""
        return np.asarray((self.turns.greatest - self.turns.least) / 2)

    @property
    def mean_amplitude(self) -> np.ndarray:
        """The same, of TURNS turns about each but the first and last ones [m]."""
        return running_mean(self.amplitude)

    @property
    def mean_speed(self) -> np.ndarray:
        """Turns by the time that TURNS of them take [Hz], about each but the first and last ones."""
        return 1 / running_mean(1 / self.turns.hertz)


def running_mean(values: np.ndarray) -> np.ndarray:
    """Means of TURNS values that follow one another, of all where there are fewer."""
    count = min(TURNS, len(values))
    if not count:
        return values
    return np.convolve(values, np.full(count, 1 / count), mode="valid")


def run_up_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Half the peak-to-peak of the relative motion in a turn of the motor, and below it its mean speed,
    against the no-load speed of that instant; ways up and down in two colours, single turns pale.

    Where the no-load speed does not change, over time. A sweep over Omega0 lies under the runs in grey: what
    they would come to if they were given time.
    """
    sweeps = [subject for subject in subjects if subject.reads == "sweep"]
    runs = [subject for subject in subjects if subject.reads != "sweep"]
    spans = [window_of(subject, view.window) for subject in runs]
    pairs = common_pairs(runs)
    ways = ways_of(runs, pairs, spans)
    over_time = any(way.direction == 0 for way in ways)
    under = _curves_under(sweeps, over_time)
    figure = sheet(view, HEIGHT_CM)
    upper, lower = figure.subplots(2, 1, sharex=True)
    if not any(len(way.x) for way in ways):
        say_inside(upper, "the motor makes no whole turn here")
    _amplitudes(upper, ways, under, pairs[0])
    if not over_time:
        ends = np.array([min(way.x.min() for way in ways), max(way.x.max() for way in ways)])
        lower.plot(ends, ends, color=GREY, linewidth=0.5, zorder=1, gid="no-load")
    _speeds(lower, ways, under)
    if over_time:
        time_axis(lower, (min(first for first, _ in spans), max(last for _, last in spans)))
    else:
        lower.set_xlabel(NO_LOAD)
        lower.margins(x=0.02)
    remarks = [*dict.fromkeys(map(seconds, spans)), trust_remark(runs, spans)]
    note(upper, "; ".join(filter(None, remarks)))
    if len(ways) + len(under) > 1:
        legend_above(upper)
    letter_panels([upper, lower])
    figure.align_ylabels()
    return figure


# Ways: the turns of a run, by the direction of its no-load speed.


def ways_of(runs: Sequence[Subject], pairs: Sequence[PlottedPair], spans: Sequence[Span]) -> list[Way]:
    """The ways of all runs; over time where the no-load speed of one of them does not change."""
    turned = [_turns(*one) for one in zip(runs, pairs, spans, strict=True)]
    loads = [no_load_speed(run.case, turns.t) for run, turns in zip(runs, turned, strict=True)]
    if any(load is None or len(load) < 2 or np.ptp(load) == 0 for load in loads):
        return [Way(run, 0, turns.t, turns) for run, turns in zip(runs, turned, strict=True)]
    ways: list[Way] = []
    for run, turns, load in zip(runs, turned, loads, strict=True):
        assert load is not None
        ways += _ways(run, turns, load)
    return ways


def _turns(run: Subject, pair: PlottedPair, span: Span) -> TurnExtremes:
    return extremes_by_turn(run.result, pair.names, lambda block: pair.plane(block)[0], span)


def _ways(run: Subject, turns: TurnExtremes, load: np.ndarray) -> Iterator[Way]:
    """Those of one run; turns in which the no-load speed is held belong to the way before, the first ones to
    that behind.
    """
    steps = np.sign(np.diff(load))
    moving = np.flatnonzero(steps)
    before = np.searchsorted(moving, np.arange(len(load) - 1), side="right") - 1
    directions = steps[moving[np.clip(before, 0, None)]].astype(int)
    directions = np.append(directions, directions[-1])
    edges = [0, *(np.flatnonzero(np.diff(directions)) + 1), len(load)]
    for first, last in pairwise(edges):
        part = slice(int(first), int(last))
        kept = TurnExtremes(turns.t[part], turns.hertz[part], turns.least[part], turns.greatest[part])
        yield Way(run, int(directions[part][0]), load[part], kept)


def _look(ways: Sequence[Way], i: int) -> dict[str, Any]:
    """Colour and label of a way: by direction where there is one of each, else by run and direction too."""
    way = ways[i]
    names = [DIRECTION_NAMES.get(one.direction, "") for one in ways]
    several = len({one.subject.path for one in ways}) > 1
    if len(set(names)) == len(names) and way.direction:
        return {"color": COLOURS[way.direction], "label": f"run {names[i]}"}
    label = ", ".join(filter(None, [way.subject.name if several else "", names[i]]))
    return {**overlay(i), "label": label or "run"}


def _amplitudes(axes: Axes, ways: Sequence[Way], under: Sequence[Curve], pair: PlottedPair) -> None:
    known = [(curve, name) for curve in under if (name := _column_of(curve, ways[0].subject))]
    scale = scale_for(
        ways[0].subject.unit("m"), *(w.amplitude for w in ways), *(c.values(name) for c, name in known)
    )
    for curve in under:
        axes.plot([], [], label=_name(curve), gid="legend", **_look_under(curve))
    for curve, name in known:
        axes.plot(curve.x, scale(curve.values(name)), gid="sweep-amplitude", **_look_under(curve))
    for i, way in enumerate(ways):
        _line(axes, way, scale(way.amplitude), scale(way.mean_amplitude), "amplitude", _look(ways, i))
    axes.set_ylim(bottom=0)
    axes.set_ylabel(scale.label(f"Amplitude of {pair.displacement}"))


def _speeds(axes: Axes, ways: Sequence[Way], under: Sequence[Curve]) -> None:
    for curve in under:
        axes.plot(curve.x, curve.values("mean_speed"), gid="sweep-speed", **_look_under(curve))
    for i, way in enumerate(ways):
        _line(axes, way, way.turns.hertz, way.mean_speed, "speed", _look(ways, i))
    low, high = axes.get_ylim()
    levels = [
        Level(f.hz, f"{f.label}  {f.hz:.2f}", {"linestyle": (0, (4, 2))})
        for f in natural_frequencies(ways[0].subject.scene)
        if low <= f.hz <= high
    ]
    draw_levels(axes, levels, LEVEL_PT)
    axes.set_ylabel(SPEED)


def _line(axes: Axes, way: Way, values: np.ndarray, mean: np.ndarray, gid: str, look: dict[str, Any]) -> None:
    """Single turns in pale colour, and the mean of TURNS turns as a line."""
    rasterized = len(values) > VECTOR_UP_TO
    pale = {"color": look["color"], "alpha": 0.3, "linewidth": 0.4}
    axes.plot(way.x, values, gid=f"{gid}-of-turn", zorder=2.0, rasterized=rasterized, **pale)
    first = (len(values) - len(mean)) // 2
    x = way.x[first : first + len(mean)]
    axes.plot(x, mean, linewidth=0.9, gid=gid, zorder=2.8, rasterized=rasterized, **look)


# The sweep under the runs.


def _curves_under(sweeps: Sequence[Subject], over_time: bool) -> list[Curve]:
    """The curves of sweeps over Omega0. Raises PlotError for other sweeps, and under runs over time."""
    for subject in sweeps:
        if over_time:
            words = "a sweep lies under runs whose no-load speed changes"
            raise PlotError(f"{subject.path}: {words}, such as --ramp Omega0=3:7Hz makes")
        if not is_motor_speed(subject.result.axes[along(subject.result)].key):
            raise PlotError(f"{subject.path}: the sweep under a run-up is one over Omega0")
    return curves(sweeps) if sweeps else []


def _look_under(curve: Curve) -> dict[str, Any]:
    colour = PALER if curve.down else PALE
    face = "white" if curve.down else colour
    return {**curve.look, "color": colour, "markerfacecolor": face, "linewidth": 0.4, "zorder": 1.5}


def _name(curve: Curve) -> str:
    return f"sweep, {curve.label}" if curve.label else "sweep"


def _column_of(curve: Curve, run: Subject) -> str | None:
    """The column of a sweep with the amplitudes of the motion that is drawn of a run."""
    part = shown_part(run)
    for motion in curve.subject.result.plan.recipe.of.motions:
        name = f"amplitude_{motion.name}"
        if {motion.P, motion.Q} == {part.P, part.Q} and name in curve.subject.result:
            return name
    return None
