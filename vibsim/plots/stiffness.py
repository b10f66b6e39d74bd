"""Characteristic of the coupling: the force of the two springs against the relative displacement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.quantities import Scale, scale_for
from vibsim.plots.relative_motion import DISPLACEMENT, draw_stop, stop_position
from vibsim.plots.sheet import legend_above, sheet
from vibsim.plots.style import BLUE, GREY, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

REACH = 2.5  # the picture reaches this many gaps beyond the rest position on the side of the stop
NAME_BELOW = 0.07  # distance of a name from the curve, of the height of the axes
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
        look = overlay(i) if len(subjects) > 1 else {"color": BLUE}
        axes.plot(scales[0](y), scales[1](force), linewidth=1.0, label=subject.name, gid="stiffness", **look)
    axes.axhline(0, color="0.8", linewidth=0.4, zorder=0)
    axes.axvline(0, color="0.8", linewidth=0.4, zorder=0)
    if len(subjects) == 1:
        _name_slopes(axes, subjects[0].scene, reach, scales)
    else:
        legend_above(axes)
    axes.set_xlabel(scales[0].label(f"Relative displacement {DISPLACEMENT}"))
    axes.set_ylabel(scales[1].label("Spring force"))


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
    inward = scene.stop_sign if scene.has_stop else 1  # direction that leads away from the stop
    _name(
        axes,
        scene,
        scales,
        inward * 0.4 * reach,
        inward * 0.4 * reach,
        f"slope $k_1$ = {scene.k1:g} N/m",
        inward,
    )
    if scene.has_stop:
        draw_stop(axes, scene, scales[0])
        on_curve = (stop_position(scene) - inward * reach) / 2
        stiff = f"slope $k_1 + k_2$ = {scene.k1 + scene.k2:g} N/m"
        _name(axes, scene, scales, on_curve, stop_position(scene) + inward * 0.55 * reach, stiff, inward)


def _name(
    axes: Axes, scene: Any, scales: tuple[Scale, Scale], on_curve: float, y: float, text: str, inward: int
) -> None:
    """Name the curve at `on_curve` [m]; the text centred at y [m], with a leader where they part."""
    force = float(spring_force(scene, np.array([on_curve]))[0])
    leader = {"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 1, "shrinkB": 1}
    leader["relpos"] = (0.0 if inward > 0 else 1.0, 0.5)
    axes.annotate(
        text, (float(scales[0](on_curve)), float(scales[1](force))),
        (float(scales[0](y)), float(scales[1](force)) - inward * NAME_BELOW * np.ptp(axes.get_ylim())),
        ha="center", va="center", fontsize=7, arrowprops=leader if y != on_curve else None,
    )  # fmt: skip
