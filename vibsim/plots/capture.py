"""Capture of the motor: a map over two ranges, or how probable it is over an ensemble of starts."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from vibsim.plots.capture_map import draw_map, draw_probability_map
from vibsim.plots.capture_starts import draw_probability, draw_starts
from vibsim.plots.locus_over_map import lay_locus
from vibsim.plots.subject import Subject
from vibsim.plots.view import View


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """What suits the sweep.

    Two ranges: verdict and speed of capture of every point, as colours; with an ensemble at every point, the
    share of its members that are captured. One range and an ensemble: that share against the range. An
    ensemble alone: its starts, coloured by the verdict. Loci are laid over maps.
    """
    (subject,) = (each for each in subjects if each.reads == "sweep")
    figure = _drawn(subject, view)
    for locus in (each.result for each in subjects if each.reads == "locus"):
        lay_locus(figure, subject, locus)
    return figure


def _drawn(subject: Subject, view: View) -> Figure:
    result = subject.result
    ranges = sum(len(axis) > 1 for axis in result.axes if axis is not result.members)
    if result.members is None:
        return draw_map(subject, view)
    if ranges == 0:
        return draw_starts(subject, view)
    return draw_probability(subject, view) if ranges == 1 else draw_probability_map(subject, view)
