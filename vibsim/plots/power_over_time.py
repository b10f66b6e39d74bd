"""Power over the time of one run: what sources give, what dampers, stops and frictions take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from vibsim.engine.ledger_integrals import Entry, entries_of
from vibsim.engine.resume import Row, rows_of_instant
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS, Scene
from vibsim.plots.pairs import annotate_runs
from vibsim.plots.relative_motion import events_within
from vibsim.plots.samples import window_of
from vibsim.plots.sheet import as_text, legend_above, letter_panels, scale_for, sheet, time_axis
from vibsim.plots.spectra import turn_times
from vibsim.plots.style import BLACK, GREY, PINK, dashed
from vibsim.plots.subject import Subject
from vibsim.plots.view import PlotError, Span, View

MOST = 240  # spans that a mean is taken over: more cannot be seen in a column
HEIGHT_CM = 6.6
STORED = "stored"
SECTIONS = {
    ("work", "motor"): "motor",
    ("work", "base"): "base",
    ("work", "rotors"): "torque on",
    ("work", "forces"): "force",
    ("work", "friction"): "belt of",
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

    The ledger begins at the last event before: what comes before `first` is taken off.
    """
    at = int(np.searchsorted(events["t"], first, side="right")) - 1
    rows = rows_of_instant(events, at)
    ends = _ledger(scene, rows, last)
    if float(events["t"][at]) == first:
        return ends
    before = _ledger(scene, rows, first)
    return {name: value - before[name] for name, value in ends.items()}


def _ledger(scene: Scene, rows: list[Row], end: float) -> dict[str, float]:
    """The ledger from an instant of events to a later time [s], as the run itself had it."""
    trajectory = open_trajectory(replace(scene, t_end=end).without_samples(), resume=rows, ledger=True)
    for _ in trajectory.blocks():
        pass
    totals = trajectory.totals
    kept = {name: value for name, value in totals.items() if name.startswith(("work.", "loss."))}
    return {**kept, STORED: totals["energy_end"] - totals["energy_start"]}


# The picture.


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
    every = [power_history(subject, span) for subject, span in zip(subjects, spans, strict=True)]
    figure = sheet(view, HEIGHT_CM * len(subjects))
    panels = list(figure.subplots(len(subjects), 1, squeeze=False)[:, 0])
    values = [v for one in every for v in (*one.given.values(), *one.taken.values(), one.stored)]
    scale = scale_for("W", *values)
    for axes, subject, one, span in zip(panels, subjects, every, spans, strict=True):
        for curve in power_curves(one):
            axes.plot(one.middles, scale(curve.values), label=curve.label, gid=curve.gid, **curve.look)
        axes.axhline(0, color=GREY, linewidth=0.4, zorder=1)
        axes.set_ylabel(scale.label("Mean power"))
        time_axis(axes, span)
        annotate_runs(axes, [subject], span, impacts=False)
        if len(subjects) > 1:
            axes.set_title(subject.name, loc="left", pad=3)
    legend_above(panels[0])
    letter_panels(panels)
    return figure


@dataclass(frozen=True)
class PowerCurve:
    """A line of the picture: mean powers (n) [W], what it is called, and how it looks."""

    label: str
    gid: str
    values: np.ndarray
    look: dict[str, Any]


def power_curves(history: PowerHistory) -> list[PowerCurve]:
    """The lines of a run; entries that are 0 throughout are left out."""
    stored = {"color": PINK, "linewidth": 0.5, "zorder": 1.8}
    curves = [PowerCurve(STORED, STORED, history.stored, stored)]
    for i, (entry, values) in enumerate(_moving(history.given)):
        colour = {"color": BLACK} if i == 0 else {"color": dashed(i + 3)["color"]}
        look = {**colour, "linewidth": 0.9}
        curves.append(PowerCurve(_words(entry), "-".join(filter(None, entry)), values, look))
    for i, (entry, values) in enumerate(_moving(history.taken)):
        look = {"color": dashed(i)["color"], "linewidth": 0.9, "linestyle": (0, (4, 1.2))}
        curves.append(PowerCurve(_words(entry), "-".join(filter(None, entry)), values, look))
    return curves


def _moving(powers: dict[Entry, np.ndarray]) -> list[tuple[Entry, np.ndarray]]:
    return [(entry, values) for entry, values in powers.items() if np.any(values)]


def _words(entry: Entry) -> str:
    """What an entry is called: friction guide, damper spring; the motor and a part of that name by itself."""
    quantity, section, name = entry
    words = SECTIONS[quantity, section]
    if section == "rotors" and name == "motor":
        return "motor"
    return as_text(words if name in ("", words) else f"{words} {name}")
