"""Displacements of the bodies against time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from vibsim.plots.runs.time_history import Quantity, draw_history
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

DISPLACEMENT = Quantity("Displacement", "m")


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """x of each body against time [s], impacts marked, with a detail."""
    return draw_history(subjects, view, DISPLACEMENT)
