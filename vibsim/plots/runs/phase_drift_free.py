"""Phase portraits of the blocks with their drift taken out: a steady motion closes, and its period shows."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from vibsim.plots.runs import phase
from vibsim.plots.subject import Subject
from vibsim.plots.view import View


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """v - u against x - u t, u the drift rate of the block over the span; else as `runs.phase`."""
    return phase.draw(subjects, view, less_drift=True)
