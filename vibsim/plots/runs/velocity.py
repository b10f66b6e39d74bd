"""Velocities of the bodies against time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from vibsim.plots.runs.time_history import Quantity, draw_history
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

VELOCITY = Quantity("Velocity", "m/s")


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """v of each body against time [s], impacts marked, with a detail."""
    return draw_history(subjects, view, VELOCITY)
