"""Amplitude spectra of the displacements, with the frequencies at which the scene likes to vibrate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from vibsim.plots.motion.frequency_marks import mark_frequencies
from vibsim.plots.motion.natural_frequencies import natural_frequencies
from vibsim.plots.motion.samples import shown
from vibsim.plots.motion.spans import last_half
from vibsim.plots.motion.spectra import FLOOR, NOTHING, spectra
from vibsim.plots.motion.time_marks import trust_remark
from vibsim.plots.page.quantities import scale_for, seconds, symbol
from vibsim.plots.page.sheet import CM, legend_above, legend_below, note, say_inside, sheet
from vibsim.plots.style import dashed
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Amplitude against frequency of each body, over the last half of the run unless the view has a window.

    Of several runs that of the first body.
    """
    figure = sheet(view, 7.4)
    axes = figure.subplots()
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    curves = [
        curve
        for subject, span in zip(subjects, spans, strict=True)
        for curve in _curves(subject, span, len(subjects) == 1)
    ]
    scale = scale_for("m", *(amplitudes for _, _, amplitudes in curves))
    largest = max(float(scale(amplitudes).max()) for _, _, amplitudes in curves)
    for i, (name, hz, amplitudes) in enumerate(curves):
        axes.plot(hz, scale(amplitudes), label=name, gid="spectrum", **dashed(i))
    if largest:
        axes.set_yscale("log")
        axes.set_ylim(largest * FLOOR, 2 * largest)
    else:
        axes.set_ylim(0, 1)
        axes.set_yticks([])
        say_inside(axes, NOTHING)
    axes.set_xlim(0, max(hz[-1] for _, hz, _ in curves))
    axes.set_xlabel("Frequency (Hz)")
    axes.set_ylabel(scale.label("Amplitude"))
    remarks = [*dict.fromkeys(map(seconds, spans)), trust_remark(subjects, spans)]
    note(axes, "; ".join(filter(None, remarks)))
    if len(subjects) > 1:
        legend_above(axes)
    else:
        mark_frequencies([axes], natural_frequencies(subjects[0].scene), (view.width_cm - 1.6) * CM * 72)
        legend_below(figure, *axes.get_legend_handles_labels())
    return figure


def _curves(subject: Subject, span: Span, alone: bool) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Name, frequencies [Hz] and amplitudes [m] of each body, or of the first one where runs are several."""
    columns = subject.columns_in("m")[: None if alone else 1]
    hz, amplitudes = spectra(subject, span, columns)
    names = [symbol(column) if alone else subject.name for column in columns]
    return [(name, hz, sizes) for name, sizes in zip(names, amplitudes, strict=True)]
