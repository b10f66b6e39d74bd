"""Amplitude spectra of the displacements, with the frequencies at which the scene likes to vibrate."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from vibsim.plots.motion.frequency_marks import mark_frequencies
from vibsim.plots.motion.natural_frequencies import natural_frequencies
from vibsim.plots.motion.samples import shown
from vibsim.plots.motion.spans import last_half
from vibsim.plots.motion.spectra import FLOOR, spectrum
from vibsim.plots.motion.time_marks import trust_remark
from vibsim.plots.page.quantities import scale_for, seconds, symbol
from vibsim.plots.page.sheet import CM, legend_above, legend_below, note, sheet
from vibsim.plots.style import overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import View


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Amplitude against frequency of each body, over the last half of the run unless the view has a window.

    Of several runs that of the first body.
    """
    figure = sheet(view, 7.4)
    axes = figure.subplots()
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    curves = [
        (symbol(column) if len(subjects) == 1 else subject.name, *spectrum(subject, span, column))
        for subject, span in zip(subjects, spans, strict=True)
        for column in subject.columns_in("m")[: None if len(subjects) == 1 else 1]
    ]
    scale = scale_for("m", *(amplitudes for _, _, amplitudes in curves))
    largest = max(float(scale(amplitudes).max()) for _, _, amplitudes in curves)
    for i, (name, hz, amplitudes) in enumerate(curves):
        axes.plot(hz, scale(amplitudes), label=name, gid="spectrum", **overlay(i))
    axes.set_yscale("log")
    axes.set_ylim(largest * FLOOR if largest else 1e-12, 2 * largest or 1.0)
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
