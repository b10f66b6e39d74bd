"""Capture of the motor: a map over two ranges, or how probable it is over an ensemble of starts."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from vibsim.plots.branches.locus_over_map import lay_loci
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.capture_map import draw_map
from vibsim.plots.sweeps.capture_starts import CAPTURED, draw_probability, draw_starts
from vibsim.plots.sweeps.ensemble_pictures import Pictures, share_map
from vibsim.plots.view import View

PICTURES = Pictures(draw_map, draw_starts, draw_probability, share_map("capture", CAPTURED, "captured"))


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """What suits the sweep.

    Two ranges: verdict and speed of capture of every point, as colours; with an ensemble at every point, the
    share of its members that are captured. One range and an ensemble: that share against the range. An
    ensemble alone: its starts, coloured by the verdict. Loci are laid over maps.
    """
    (subject,) = (each for each in subjects if each.reads == "sweep")
    figure = PICTURES.draw(subject, view)
    lay_loci(figure, subject, [each.result for each in subjects if each.reads == "locus"])
    return figure
