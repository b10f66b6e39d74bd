"""Slow changes in a run, as means of turns: amplitude and motor speed while the no-load speed of the
motor goes up and down, and powers over time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.ramps import drive_frequency, no_load_speed
from vibsim.engine.ledger_integrals import Entry, entries_of
from vibsim.engine.resume import Row, rows_to_resume
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS, Scene
from vibsim.physics.rates import motor_columns
from vibsim.plots.poincare_sections import TURNS, TurnExtremes, extremes_by_turn, turn_times
from vibsim.plots.samples import events_within, natural_frequencies, window_of
from vibsim.plots.sheet import (
    LEGEND_LINE_CM,
    Level,
    beside_levels,
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
from vibsim.plots.style import BLACK, BLUE, GREY, PINK, VERMILLION, dashed, overlay
from vibsim.plots.subject import PlotError, Span, Subject, View, as_text
from vibsim.plots.sweep_axes import along, is_speed, sets_no_load_speed
from vibsim.plots.sweep_curves import DIRECTION_NAMES, DOWN, UP, Curve, broken, curves, leaps, no_load_speeds
from vibsim.plots.traces import (
    VECTOR_UP_TO,
    PlottedPair,
    annotate_runs,
    common_pairs,
    shown_part,
    trust_remark,
)

HEIGHT_CM = 9.6
NO_LOAD = r"No-load speed $\Omega_0/2\pi$ (Hz)"
DRIVE = r"Frequency of the drive $\omega/2\pi$ (Hz)"
SPEED = r"Motor speed $\dot\varphi/2\pi$ (Hz)"
COLOURS = {UP: BLUE, DOWN: VERMILLION}
PALE, PALER = "0.25", "0.6"  # greys of a sweep under the runs: upwards, downwards
LEVEL_PT = 110  # about the height of the lower panel


@dataclass(frozen=True)
class SlowPassage:
    """The turns of one run in which the no-load speed goes in one direction, or all where it does not change.

    direction : UP or DOWN; 0 over time
    x : no-load speed of the motor, or frequency of the drive, at the middle of each turn (n) [Hz]; or the
        time [s]
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
    against the no-load speed of that instant; passages up and down in two colours, single turns pale. Of a
    force or base whose frequency has a ramp the amplitude alone, in a period of the drive, against its
    frequency.

    Where the no-load speed does not change, over time. A sweep over Omega0 lies under the runs in grey: what
    they would come to if they were given time.
    """
    sweeps = [subject for subject in subjects if subject.reads == "sweep"]
    runs = [subject for subject in subjects if subject.reads != "sweep"]
    spans = [window_of(subject, view.window) for subject in runs]
    pairs = common_pairs(runs)
    passages = passages_of(runs, pairs, spans)
    over_time = any(passage.direction == 0 for passage in passages)
    driven = all(motor_columns(run.scene) is None for run in runs)
    under = _curves_under(sweeps, over_time, driven)
    of_legend = LEGEND_LINE_CM * max(len(passages) + len(under) - 2, 0)
    figure = sheet(view, (0.6 * HEIGHT_CM if driven else HEIGHT_CM) + of_legend)
    beside = {} if driven else beside_levels(view)
    panels = list(
        figure.subplots(1 if driven else 2, 1, sharex=True, squeeze=False, gridspec_kw=beside)[:, 0]
    )
    upper, lower = panels[0], panels[-1]
    if not any(len(passage.x) for passage in passages):
        say_inside(
            upper, "the drive makes no whole period here" if driven else "the motor makes no whole turn here"
        )
    _amplitudes(upper, passages, under, pairs[0])
    if not driven:
        if not over_time:
            ends = np.array(
                [min(passage.x.min() for passage in passages), max(passage.x.max() for passage in passages)]
            )
            lower.plot(ends, ends, color=GREY, linewidth=0.5, zorder=1, gid="no-load")
            note(lower, "thin line: no-load speed")
        _speeds(lower, passages, under)
    if over_time:
        time_axis(lower, (min(first for first, _ in spans), max(last for _, last in spans)))
    else:
        lower.set_xlabel(DRIVE if driven else NO_LOAD)
        lower.margins(x=0.02)
    of = "period" if driven else "turn"
    meant = (
        f"line: mean of {TURNS} {of}s; pale: each {of}"
        if any(len(passage.x) > TURNS for passage in passages)
        else ""
    )
    remarks = [*dict.fromkeys(map(seconds, spans)), meant, trust_remark(runs, spans)]
    note(upper, "; ".join(filter(None, remarks)))
    if len(passages) + len(under) > 1:
        legend_above(upper)
    if not driven:
        letter_panels(panels)
    figure.align_ylabels()
    return figure


# Passages: the turns of a run, by the direction of its no-load speed.


def passages_of(
    runs: Sequence[Subject], pairs: Sequence[PlottedPair], spans: Sequence[Span]
) -> list[SlowPassage]:
    """The passages of all runs; over time where the speed of the source of one of them does not change."""
    turned = [_turns(*one) for one in zip(runs, pairs, spans, strict=True)]
    loads = [_speed_of_source(run, turns.t) for run, turns in zip(runs, turned, strict=True)]
    if any(load is None or len(load) < 2 or np.ptp(load) == 0 for load in loads):
        return [SlowPassage(run, 0, turns.t, turns) for run, turns in zip(runs, turned, strict=True)]
    passages: list[SlowPassage] = []
    for run, turns, load in zip(runs, turned, loads, strict=True):
        assert load is not None
        passages += _passages(run, turns, load)
    return passages


def _speed_of_source(run: Subject, times: np.ndarray) -> np.ndarray | None:
    """No-load speed of the motor, or frequency of a drive with a ramp, at times [s], in Hz; None without."""
    frequency = drive_frequency(run.case, times)
    return no_load_speed(run.case, times) if frequency is None else frequency


def _turns(run: Subject, pair: PlottedPair, span: Span) -> TurnExtremes:
    return extremes_by_turn(run.result, pair.names, lambda block: pair.plane(block)[0], span)


def _passages(run: Subject, turns: TurnExtremes, load: np.ndarray) -> Iterator[SlowPassage]:
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
        yield SlowPassage(run, int(directions[part][0]), load[part], kept)


def _look(passages: Sequence[SlowPassage], i: int) -> dict[str, Any]:
    """Colour and label of a passage: by direction where there is one of each, else by run and direction."""
    passage = passages[i]
    names = [DIRECTION_NAMES.get(one.direction, "") for one in passages]
    several = len({one.subject.path for one in passages}) > 1
    if len(set(names)) == len(names) and passage.direction:
        return {"color": COLOURS[passage.direction], "label": f"run {names[i]}"}
    label = ", ".join(filter(None, [passage.subject.name if several else "", names[i]]))
    return {**overlay(i), "label": label or "run"}


def _amplitudes(
    axes: Axes, passages: Sequence[SlowPassage], under: Sequence[Curve], pair: PlottedPair
) -> None:
    known = [(curve, name) for curve in under if (name := _column_of(curve, passages[0].subject))]
    scale = scale_for(
        pair.units[0],
        *(w.amplitude for w in passages),
        *(c.values(name) for c, name in known),
    )
    for curve in under:
        axes.plot([], [], label=_name(curve), gid="legend", **_look_under(curve))
    for curve, name in known:
        _under(axes, curve, scale(curve.values(name)), "sweep-amplitude")
    for i, passage in enumerate(passages):
        _line(
            axes,
            passage,
            scale(passage.amplitude),
            scale(passage.mean_amplitude),
            "amplitude",
            _look(passages, i),
        )
    axes.set_ylim(bottom=0)
    axes.set_ylabel(f"Amplitude\nof {scale.label(pair.displacement)}")


def _speeds(axes: Axes, passages: Sequence[SlowPassage], under: Sequence[Curve]) -> None:
    for curve in under:
        _under(axes, curve, curve.values("mean_speed"), "sweep-speed")
    for i, passage in enumerate(passages):
        _line(axes, passage, passage.turns.hertz, passage.mean_speed, "speed", _look(passages, i))
    low, high = axes.get_ylim()
    levels = [
        Level(f.hz, f.text, {"linestyle": (0, (4, 2))})
        for f in natural_frequencies(passages[0].subject.scene)
        if low <= f.hz <= high
    ]
    draw_levels(axes, levels, LEVEL_PT)
    axes.set_ylabel(SPEED)


def _line(
    axes: Axes, passage: SlowPassage, values: np.ndarray, mean: np.ndarray, gid: str, look: dict[str, Any]
) -> None:
    """Single turns in pale colour, and the mean of TURNS turns as a line."""
    rasterized = len(values) > VECTOR_UP_TO
    pale = {"color": look["color"], "alpha": 0.3, "linewidth": 0.4}
    axes.plot(passage.x, values, gid=f"{gid}-of-turn", zorder=2.0, rasterized=rasterized, **pale)
    first = (len(values) - len(mean)) // 2
    x = passage.x[first : first + len(mean)]
    axes.plot(x, mean, linewidth=0.9, gid=gid, zorder=2.8, rasterized=rasterized, **look)


# The sweep under the runs.


def _curves_under(sweeps: Sequence[Subject], over_time: bool, driven: bool) -> list[Curve]:
    """The curves of sweeps over Omega0, or what sets it, against Omega0; or over the frequency of a drive in
    Hz. Raises PlotError for other sweeps, and under runs over time.
    """
    for subject in sweeps:
        if over_time:
            words = "a sweep lies under runs whose no-load speed changes"
            raise PlotError(f"{subject.path}: {words}, such as a ramp of Omega0 makes")
        axis = subject.result.axes[along(subject.result)]
        if driven and not (is_speed(axis.key) and axis.unit == "Hz"):
            raise PlotError(
                f"{subject.path}: the sweep under a run-up is one over the frequency of the drive in Hz"
            )
        if not driven and not sets_no_load_speed(subject):
            raise PlotError(f"{subject.path}: the sweep under a run-up is one over Omega0, or what sets it")
    under = curves(sweeps) if sweeps else []
    return under if driven else [replace(curve, x=no_load_speeds(curve)) for curve in under]


def _under(axes: Axes, curve: Curve, values: np.ndarray, gid: str) -> None:
    """Points of a sweep, and lines between them but across leaps."""
    look = _look_under(curve)
    axes.plot(curve.x, values, gid=gid, **{**look, "linestyle": "none"})
    x, y = broken(curve.x, values, leaps(values))
    axes.plot(x, y, gid="joined", **{**look, "marker": "none"})


def _look_under(curve: Curve) -> dict[str, Any]:
    colour = PALER if curve.down else PALE
    face = "white" if curve.down else colour
    return {**curve.look, "color": colour, "markerfacecolor": face, "linewidth": 0.4, "zorder": 1.5}


def _name(curve: Curve) -> str:
    return f"sweep, {curve.label}" if curve.label else "sweep"


def _column_of(curve: Curve, run: Subject) -> str | None:
    """The column of a sweep with the amplitudes of the motion that is drawn of a run."""
    part = shown_part(run)
    for motion in curve.subject.result.plan.point_settings.of.motions:
        name = f"amplitude_{motion.name}"
        if {motion.P, motion.Q} == {part.P, part.Q} and name in curve.subject.result:
            return name
    return None


# Power over time: what sources give, what dampers, stops and frictions take.


MOST = 240  # spans that a mean is taken over: more cannot be seen in a column
POWER_HEIGHT_CM = 6.6
STORED = "stored"
STORED_PT = 2.2  # width of its line: seen on both sides of one that lies upon it
SECTIONS = {
    ("work", "motor"): "motor",
    ("work", "base"): "base",
    ("work", "rotors"): "rotor",
    ("work", "forces"): "force",
    ("work", "friction"): "belt",
    ("loss", "links"): "damper",
    ("loss", "stops"): "stop",
    ("loss", "friction"): "friction",
}  # what entries of the ledger are called, before the name of their part


@dataclass(frozen=True)
class PowerHistory:
    """Mean powers of one run over spans that follow one another.

    edges : ends of the spans (n + 1) [s]
    given, taken : by entry of the ledger, work and loss of each span over its length (n) [W]
    stored : increase of kinetic and elastic energy of each span over its length (n) [W]: given = taken +
        stored
    """

    edges: np.ndarray
    given: dict[Entry, np.ndarray]
    taken: dict[Entry, np.ndarray]
    stored: np.ndarray

    @property
    def middles(self) -> np.ndarray:
        return np.asarray((self.edges[1:] + self.edges[:-1]) / 2)


def power_history(subject: Subject, span: Span) -> PowerHistory:
    """The powers of a run within a span [s]: from its energy ledger, which is kept once more from the events
    of the file on.

    A span of a mean is a whole number of turns of the source, as few as give MOST of them; an equal share of
    the time where nothing turns.
    """
    edges, scene = _edges(subject, span), subject.scene
    events = events_within(subject.result, None, (float(edges[0]), float(edges[-1])), before=1)
    started = {name: column[events["kind"] != EVENT_KINDS["end"]] for name, column in events.items()}
    energies = [_energies(scene, started, a, b) for a, b in pairwise(edges.tolist())]
    lengths = np.diff(edges)
    powers = {name: np.array([one[name] for one in energies]) / lengths for name in energies[0]}
    entries = entries_of(scene)
    named = {entry: powers[".".join(filter(None, entry))] for entry in entries}
    return PowerHistory(
        edges,
        {entry: values for entry, values in named.items() if entry[0] == "work"},
        {entry: values for entry, values in named.items() if entry[0] == "loss"},
        powers[STORED],
    )


def _edges(subject: Subject, span: Span) -> np.ndarray:
    """Ends of the spans that means are taken over [s]."""
    last = min(span[1], subject.result.t_reached)
    turns = turn_times(subject.result, (span[0], last))
    if len(turns) > 2:
        return np.asarray(turns[:: math.ceil((len(turns) - 1) / MOST)])
    return np.linspace(span[0], last, MOST + 1)


def _energies(scene: Scene, events: dict[str, np.ndarray], first: float, last: float) -> dict[str, float]:
    """Entries of the ledger and increase of the stored energy from one time to another [J].

    The ledger begins at an event before: what comes before `first` is taken off.
    """
    at = int(np.searchsorted(events["t"], first, side="right")) - 1
    rows = rows_to_resume(scene, events, at)
    ends = _ledger(scene, rows, last)
    if (0.0 if rows is None else rows[-1]["t"]) == first:
        return ends
    before = _ledger(scene, rows, first)
    return {name: value - before[name] for name, value in ends.items()}


def _ledger(scene: Scene, rows: list[Row] | None, end: float) -> dict[str, float]:
    """The ledger from an instant of events, or the start, to a later time [s], as the run itself had it."""
    trajectory = open_trajectory(replace(scene, t_end=end).without_samples(), resume=rows, ledger=True)
    for _ in trajectory.blocks():
        pass
    totals = trajectory.totals
    kept = {name: value for name, value in totals.items() if name.startswith(("work.", "loss."))}
    return {**kept, STORED: totals["energy_end"] - totals["energy_start"]}


# The picture of powers.


def run_power_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Work of sources over time as solid lines, losses of dampers, stops and frictions as dashed ones, and
    what goes into motion and springs as a pale one; each the mean of whole turns. A panel for each run.

    Raises PlotError for sweeps beside runs.
    """
    strangers = [subject.path for subject in subjects if subject.reads != "trajectory"]
    if strangers:
        raise PlotError(
            f"kind power: runs are drawn over time, and {strangers[0]} is a sweep; draw it by itself"
        )
    spans = [window_of(subject, view.window) for subject in subjects]
    figure = sheet(view, POWER_HEIGHT_CM * len(subjects))
    panels = list(figure.subplots(len(subjects), 1, squeeze=False)[:, 0])
    power_panels(panels, subjects, spans)
    legend_above(panels[0])
    letter_panels(panels)
    return figure


def power_panels(panels: Sequence[Axes], subjects: Sequence[Subject], spans: Sequence[Span]) -> None:
    """Powers of runs over time [s] in given axes, all in one unit."""
    every = [power_history(subject, span) for subject, span in zip(subjects, spans, strict=True)]
    values = [v for one in every for v in (*one.given.values(), *one.taken.values(), one.stored)]
    scale = scale_for("W", *values)
    for axes, subject, one, span in zip(panels, subjects, every, spans, strict=True):
        for curve in power_curves(one, subject.scene):
            axes.plot(one.middles, scale(curve.values), label=curve.label, gid=curve.gid, **curve.look)
        axes.axhline(0, color=GREY, linewidth=0.4, zorder=1)
        axes.set_ylabel(scale.label("Mean power"))
        time_axis(axes, span)
        annotate_runs(axes, [subject], span, impacts=False)
        if len(subjects) > 1:
            axes.set_title(subject.name, loc="left", pad=3)


@dataclass(frozen=True)
class PowerCurve:
    """A line of the picture: mean powers (n) [W], what it is called, and how it looks."""

    label: str
    gid: str
    values: np.ndarray
    look: dict[str, Any]


def power_curves(history: PowerHistory, scene: Scene) -> list[PowerCurve]:
    """The lines of a run; entries that are 0 throughout are left out."""
    stored = {"color": PINK, "linewidth": STORED_PT, "alpha": 0.6, "zorder": 1.8}
    curves = [PowerCurve(STORED, STORED, history.stored, stored)]
    for i, (entry, values) in enumerate(_moving(history.given)):
        colour = {"color": BLACK} if i == 0 else {"color": dashed(i + 3)["color"]}
        look = {**colour, "linewidth": 0.9}
        curves.append(PowerCurve(_words(entry, scene), "-".join(filter(None, entry)), values, look))
    for i, (entry, values) in enumerate(_moving(history.taken)):
        look = {"color": dashed(i)["color"], "linewidth": 0.9, "linestyle": (0, (4, 1.2))}
        curves.append(PowerCurve(_words(entry, scene), "-".join(filter(None, entry)), values, look))
    return curves


def _moving(powers: dict[Entry, np.ndarray]) -> list[tuple[Entry, np.ndarray]]:
    return [(entry, values) for entry, values in powers.items() if np.any(values)]


def _words(entry: Entry, scene: Scene) -> str:
    """Name of an entry: friction: guide, damper: spring, or link: spring of one with a formula, which may
    store what it takes; the motor and a part of that name by itself.
    """
    quantity, section, name = entry
    words = SECTIONS[quantity, section]
    if section == "rotors" and name == "motor":
        return "motor"
    if section == "links" and any(link.name == name and link.force is not None for link in scene.links):
        words = "link"
    if section == "forces" and scene.torsional:
        words = "torque"
    return as_text(words if name in ("", words) else f"{words}: {name}")
