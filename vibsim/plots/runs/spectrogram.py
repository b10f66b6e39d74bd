"""How the spectrum of a motion changes in time, the speed of the motor and its multiples drawn in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from vibsim.plots.motion.samples import window_of
from vibsim.plots.motion.spectra import NOTHING, first_motion, pieces
from vibsim.plots.page.quantities import scale_for
from vibsim.plots.page.sheet import note, pixel_columns, sheet, time_axis
from vibsim.plots.runs.motor_speed import mean_speed
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View

DECADES = 4  # of amplitude that are told apart


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Amplitude of the first relative motion over time and frequency."""
    subject = subjects[0]
    span, motion = window_of(subject, view.window), first_motion(subject)
    cut = pieces(subject, span, motion, count=600)
    figure = sheet(view, 7.0)
    axes = figure.subplots()
    scale = scale_for("m", cut.amplitudes)
    values = scale(cut.amplitudes)
    largest = float(values.max()) or 1.0
    least = largest * 10.0**-DECADES
    picture = axes.pcolormesh(
        _edges(cut.times, span), _edges(cut.hz, (0.0, float(cut.hz[-1]))), np.maximum(values, least).T,
        cmap="magma", shading="flat", norm=LogNorm(least, largest), rasterized=True, gid="spectrogram",
    )  # fmt: skip
    if not values.any():
        axes.text(0.5, 0.5, NOTHING, transform=axes.transAxes, ha="center", va="center", color="white")
    figure.colorbar(picture, ax=axes, label=scale.label(f"Amplitude of {motion}"), pad=0.01)
    if subject.scene.has_motor:
        _speeds(axes, subject, span)
    axes.set_ylim(0, cut.hz[-1])
    axes.set_ylabel("Frequency (Hz)")
    time_axis(axes, span)
    note(axes, f"pieces of {cut.length:.3g} s")
    return figure


def _edges(middles: np.ndarray, span: Span) -> np.ndarray:
    """Where the cell of each value (n) ends, (n + 1): half-way to the next one, and at the ends of a span.

    The first and the last piece of a run reach that far: nobody else tells of their halves.
    """
    return np.array([span[0], *((middles[1:] + middles[:-1]) / 2), span[1]])


def _speeds(axes: Axes, subject: Subject, span: Span) -> None:
    """The motor's mean speed over the picture."""
    t, hertz = mean_speed(subject, span, pixel_columns(axes))
    axes.plot(t, hertz, color="white", linewidth=0.7, linestyle=(0, (3, 2)), gid="motor-speed")
