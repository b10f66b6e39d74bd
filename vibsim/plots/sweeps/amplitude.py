"""Amplitudes of a sweep against the frequency of the source, or whatever else was swept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.physics.parts import GROUND
from vibsim.plots.motion.frequency_marks import mark_frequencies
from vibsim.plots.motion.relative_motion import difference
from vibsim.plots.page.quantities import Scale, scale_for
from vibsim.plots.page.sheet import letter_panels, note, sheet
from vibsim.plots.page.user_text import as_text
from vibsim.plots.style import points
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import along, axis_label, is_speed
from vibsim.plots.sweeps.curves import (
    Curve,
    curves,
    draw_bands,
    ensemble_note,
    frequencies,
    limit,
    name_curves,
)
from vibsim.plots.sweeps.panels import PAGE_CM
from vibsim.plots.view import View

PANEL_CM = 3.1
BANDS_UP_TO = 2
MOST = int((PAGE_CM - 2.4) / PANEL_CM)  # panels that a page has room for


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Half the peak-to-peak per excitation period [m]: its mean as a line, up to its greatest as a band."""
    drawn = curves(subjects)
    every = motions_of(subjects)
    labels = dict(list(every.items())[:MOST])
    names = list(labels)
    figure = sheet(view, 2.4 + PANEL_CM * len(names))
    panels = figure.subplots(len(names), 1, squeeze=False, sharex=True)[:, 0]
    scale = _common_scale(drawn, names)
    for axes, name in zip(panels, names, strict=True):
        _panel(axes, [curve for curve in drawn if f"amplitude_{name}" in curve.subject.result], name, scale)
        axes.set_ylabel(scale.label(labels[name]))
    limit(panels[0], drawn, view)
    banded = len(drawn) <= BANDS_UP_TO and any(map(_is_banded, drawn))
    omitted = f"{len(labels)} of {len(every)} motions" if len(labels) < len(every) else ""
    words = ensemble_note(drawn) or ("band: up to the greatest" if banded else "")
    note(panels[0], "; ".join(filter(None, [omitted, words])))
    if all(is_speed(subject.result.axes[along(subject.result)].key) for subject in subjects):
        mark_frequencies(list(panels), frequencies(subjects), (view.width_cm - 1.6) * 28)
    figure.supylabel("Amplitude", fontsize=points(8))
    panels[-1].set_xlabel(axis_label(subjects))
    name_curves(figure, list(panels), drawn)
    letter_panels(list(panels))
    return figure


def motions_of(subjects: Sequence[Subject]) -> dict[str, str]:
    """Labels of the motions of all sweeps by name: those of two ends against each other, called after the
    stop or link between them, then those of bodies.
    """
    by_word: dict[str, str] = {}
    for subject in subjects:
        motions = subject.result.plan.recipe.of.motions
        for motion in sorted(motions, key=lambda motion: motion.Q == GROUND):
            named = motion.Q != GROUND and subject.result.plan.recipe.of.of_parts
            label = as_text(motion.part) if named else difference(subject.scene, motion, "x")
            by_word.setdefault(motion.name, label)
    return by_word


def _common_scale(drawn: Sequence[Curve], names: Sequence[str]) -> Scale:
    """One unit for all panels."""
    ends = "_max" if len(drawn) <= BANDS_UP_TO else ""
    return scale_for("m", *(
        curve.every(f"amplitude_{name}{ends}")
        for curve in drawn for name in names if f"amplitude_{name}" in curve.subject.result
    ))  # fmt: skip


def _panel(axes: Axes, drawn: Sequence[Curve], name: str, scale: Scale) -> None:
    means = [curve.values(f"amplitude_{name}") for curve in drawn]
    for curve, mean in zip(drawn, means, strict=True):
        draw_bands(axes, curve, f"amplitude_{name}", scale)
        if len(drawn) <= BANDS_UP_TO and _is_banded(curve):
            most = curve.values(f"amplitude_{name}_max")
            axes.fill_between(
                curve.x, scale(mean), scale(most), color=curve.colour, alpha=0.2, linewidth=0, gid="band"
            )
        axes.plot(curve.x, scale(mean), label=curve.label, gid=name, zorder=3, **curve.look)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.06)
    if all(np.isnan(mean).all() for mean in means):
        axes.set_ylim(0, 1)


def _is_banded(curve: Curve) -> bool:
    """Whether a band up to the greatest amplitude belongs to it: not to members of an ensemble."""
    return curve.members is None and curve.joined
