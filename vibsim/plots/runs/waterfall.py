"""Spectra one behind the other: of pieces of a run, or of several runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from vibsim.plots.motion.samples import shown, window_of
from vibsim.plots.motion.spans import last_half
from vibsim.plots.motion.spectra import NOTHING, first_motion, pieces, spectra
from vibsim.plots.page.quantities import scale_for
from vibsim.plots.page.sheet import note, say_inside, sheet
from vibsim.plots.style import BLUE
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

MOST = 40  # spectra
HEIGHT = 6.0  # of the largest line, in distances between spectra


@dataclass(frozen=True)
class Row:
    """One spectrum: where it stands on the y axis, frequencies [Hz] and amplitudes [m]."""

    place: float
    hz: np.ndarray
    amplitudes: np.ndarray


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Spectra of the first relative motion, each raised to its time, or of several runs to their number."""
    alone = len(subjects) == 1
    drawn = _of_pieces(subjects[0], view) if alone else _of_runs(subjects, view)
    scale = scale_for("m", *(row.amplitudes for row in drawn))
    largest = max(float(row.amplitudes.max()) for row in drawn)
    apart = (drawn[-1].place - drawn[0].place) / max(len(drawn) - 1, 1) or 1.0
    raised = HEIGHT * apart / (largest or 1.0)
    figure = sheet(view, 9.0)
    axes = figure.subplots()
    for i, row in enumerate(reversed(drawn)):  # the last, which stands highest, is behind
        y = row.place + raised * row.amplitudes
        axes.fill_between(row.hz, y, row.place, facecolor="white", edgecolor="none", zorder=2 + i / MOST)
        axes.plot(row.hz, y, color=BLUE, linewidth=0.5, gid="spectrum", zorder=2 + i / MOST)
    axes.set_xlim(0, max(row.hz[-1] for row in drawn))
    axes.set_xlabel("Frequency (Hz)")
    if alone:
        axes.set_ylabel("Time (s)")
        end = drawn[-1].place + apart  # above it there are lines, and no time
        axes.set_yticks([tick for tick in axes.get_yticks() if axes.get_ylim()[0] <= tick <= end])
    else:
        axes.set_ylabel("Run")
        axes.set_yticks([row.place for row in drawn], [subject.name for subject in subjects])
    if not largest:
        say_inside(axes, NOTHING)
        return figure
    note(axes, f"largest line {float(scale(largest)):.3g} {scale.unit}")
    return figure


def _of_pieces(subject: Subject, view: View) -> list[Row]:
    cut = pieces(subject, window_of(subject, view.window), first_motion(subject), count=MOST)
    return [Row(float(time), cut.hz, sizes) for time, sizes in zip(cut.times, cut.amplitudes, strict=True)]


def _of_runs(subjects: Sequence[Subject], view: View) -> list[Row]:
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    drawn = [
        spectra(subject, span, [first_motion(subject)]) for subject, span in zip(subjects, spans, strict=True)
    ]
    return [Row(float(i), hz, sizes) for i, (hz, (sizes,)) in enumerate(drawn)]
