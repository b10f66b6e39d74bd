"""Characteristic of the coupling: the force of the two springs against the relative displacement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.curve_labels import Named, write_names
from vibsim.plots.quantities import Scale, amount, scale_for
from vibsim.plots.relative_motion import DISPLACEMENT, draw_stop, stop_position
from vibsim.plots.sheet import legend_above, sheet
from vibsim.plots.style import BLUE, nested
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

REACH = 2.5  # the picture reaches this many gaps beyond the rest position on the side of the stop
PLACES = (0.5, 0.35, 0.65, 0.2, 0.8, 0.05)  # of a name along its part of the curve, the better first
NO_GAP = 1e-3  # a range to show where the scene gives none [m]


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Spring force F_s1 + F_s2, Eqs. (2.4), (2.5), against x1 - x2: slope k1, and k1 + k2 beyond the gap."""
    figure = sheet(view, 6.0)
    stiffness_panel(figure.subplots(), subjects)
    return figure


def stiffness_panel(axes: Axes, subjects: Sequence[Subject]) -> None:
    """The characteristic in given axes."""
    reach = REACH * (max((s.scene.G for s in subjects if s.scene.has_stop), default=0.0) or NO_GAP)
    curves = [characteristic(subject.scene, reach) for subject in subjects]
    scales = scale_for("m", *(y for y, _ in curves)), scale_for("N", *(force for _, force in curves))
    for i, (subject, (y, force)) in enumerate(zip(subjects, curves, strict=True)):
        look = nested(i, len(subjects), 1.0) if len(subjects) > 1 else {"color": BLUE, "linewidth": 1.0}
        axes.plot(scales[0](y), scales[1](force), label=subject.name, gid="stiffness", **look)
    axes.axhline(0, color="0.8", linewidth=0.4, zorder=0)
    axes.axvline(0, color="0.8", linewidth=0.4, zorder=0)
    axes.set_xlabel(scales[0].label(f"Relative displacement {DISPLACEMENT}"))
    axes.set_ylabel(scales[1].label("Spring force"))
    if len(subjects) == 1:
        _name_slopes(axes, subjects[0].scene, reach, scales)
    else:
        legend_above(axes)


def spring_force(scene: Any, y: np.ndarray) -> np.ndarray:
    """F_s1 + F_s2 [N] at relative displacement y = x1 - x2 [m], Eqs. (2.4) and (2.5)."""
    force = scene.k1 * y
    if not scene.has_stop:
        return force
    depth = np.maximum(-scene.stop_sign * y - scene.G, 0.0)
    return force - scene.stop_sign * scene.k2 * depth


def characteristic(scene: Any, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """The polyline (y [m], force [N]): its ends and its corner at the stop."""
    corners = [stop_position(scene)] if scene.has_stop else []
    y = np.unique([-reach, *corners, reach])
    return y, spring_force(scene, y)


def _name_slopes(axes: Axes, scene: Any, reach: float, scales: tuple[Scale, Scale]) -> None:
    """The slopes in words, beside the curve and inside the frame; limits are settled before."""
    away = scene.stop_sign if scene.has_stop else 1  # direction that leads away from the stop
    named = [_named(f"slope $k_1$ = {amount(scene.k1, 'N/m')}", scene, scales, 0.0, away * reach)]
    if scene.has_stop:
        draw_stop(axes, scene, scales[0])
        stiff = f"slope $k_1 + k_2$ = {amount(scene.k1 + scene.k2, 'N/m')}"
        named.append(_named(stiff, scene, scales, stop_position(scene), -away * reach))
    axes.set_xlim(axes.get_xlim())
    axes.set_ylim(axes.get_ylim())
    write_names(axes, named)


def _named(text: str, scene: Any, scales: tuple[Scale, Scale], start: float, end: float) -> Named:
    """A name for the straight part of the curve between two displacements [m], at its middle if it fits."""
    y = start + (end - start) * np.array(PLACES)
    behind = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}  # lines of the axes end there
    look = {"fontsize": 7, "gid": "slope", "bbox": behind}
    return Named(text, scales[0](y), scales[1](spring_force(scene, y)), look)
