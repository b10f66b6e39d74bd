"""The map of regimes: what kind of motion there is at every point of two ranges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from vibsim.plots.style import BLUE, GREEN, ORANGE, PINK, SKY, VERMILLION, YELLOW
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.map_sheet import map_sheet
from vibsim.plots.sweeps.plane import plane_of
from vibsim.plots.sweeps.verdict_colours import Shade, lay_classes, legend_of
from vibsim.plots.view import View
from vibsim.sweeps.computations.regime_label import VERDICTS

PERIODS = 4  # told apart; longer ones share a colour
SHADES = [
    Shade("period 1", BLUE), Shade("period 2", SKY), Shade("period 3", GREEN, "\\\\\\\\"),
    Shade("period 4", YELLOW), Shade("longer period", PINK, "...."), Shade("quasi-periodic", ORANGE, "////"),
    Shade("chaotic", VERMILLION, "xxxx"), Shade("transient", "0.78", "||||"), Shade("undecided", "0.95"),
]  # fmt: skip
CLASSES = {shade.name: code for code, shade in enumerate(SHADES)}


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Regime of every point as a colour, periodic motion by its period in turns of the source."""
    (subject,) = subjects
    plane, result = plane_of(subject), subject.result
    classes = classes_of(result["regime"], result["regime_period"])
    figure, panels = map_sheet(plane, 1, view)
    for d, axes in enumerate(panels):
        lay_classes(axes, plane, plane.grid(classes, d), SHADES, "regime")
    legend_of(figure, SHADES, classes[..., : len(panels)])
    return figure


def classes_of(regimes: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Index into SHADES of each point, from its verdict and the periods after which it repeats; or NaN."""
    classes = np.full(regimes.shape, np.nan)
    for name, code in VERDICTS.items():
        classes[regimes == code] = CLASSES.get(name, np.nan)
    periodic = regimes == VERDICTS["periodic"]
    classes[periodic] = np.minimum(periods[periodic], PERIODS + 1) - 1
    return classes
