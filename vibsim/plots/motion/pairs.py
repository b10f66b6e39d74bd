"""The two bodies whose motion against each other is drawn, and the stops between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.physics.body_sets import pairs_of
from vibsim.plots.errors import PlotError
from vibsim.plots.motion.relative_motion import difference, stop_label, stop_position, stops_between
from vibsim.plots.motion.trace import Plane, Trace, trace
from vibsim.plots.page.quantities import Scale
from vibsim.plots.page.sheet import label_axes
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span
from vibsim.results.motion.closing_velocity import IMPACT_CODES
from vibsim.results.motion.relative_motion import RelativeMotion


@dataclass(frozen=True)
class Pair:
    """Two bodies, or a body and ground or base.

    Attributes
    ----------
    names : columns of a run that their relative motion needs
    plane : from these to relative displacement [m] and velocity [m/s]
    displacement, velocity : what these are called
    stops : relative displacement [m] at which each stop between them is met, and its name
    """

    names: tuple[str, ...]
    plane: Plane
    displacement: str
    velocity: str
    stops: tuple[tuple[float, str], ...]


def pair_of(subject: Subject) -> Pair:
    """The ends of the stop that is struck most often, else of the first link, else of the first friction,
    else the first body and ground.
    """
    scene, part = subject.scene, _shown_part(subject)
    motion = RelativeMotion(scene, part)

    def plane(block: Any) -> tuple[np.ndarray, np.ndarray]:
        _, x, v = motion(block, "time")
        return x, v

    x, v = (difference(scene, part, letter) for letter in "xv")
    stops = [(stop_position(stop, part), stop_label(stop)) for stop in stops_between(scene, part)]
    return Pair(("time", *motion.columns), plane, x, v, tuple(stops))


def common_pairs(subjects: Sequence[Subject]) -> list[Pair]:
    """The pair of each subject; PlotError where they are not the motion of the same ends."""
    pairs = [pair_of(subject) for subject in subjects]
    if len({pair.displacement for pair in pairs}) > 1:
        several = ", ".join(pair.displacement for pair in pairs)
        raise PlotError(f"no relative motion is common to the runs: {several}; draw them one by one")
    return pairs


def relative_traces(subjects: Sequence[Subject], pairs: Sequence[Pair], spans: Sequence[Span]) -> list[Trace]:
    """The relative motion of each subject's pair within its span [s]."""
    return [
        trace(subject.result, pair.names, pair.plane, span)
        for subject, pair, span in zip(subjects, pairs, spans, strict=True)
    ]


def label_relative(axes: Axes, pair: Pair, scales: tuple[Scale, Scale]) -> None:
    """Name the relative displacement of a pair across, its velocity upwards."""
    label_axes(
        axes,
        ("Relative displacement", scales[0].label(pair.displacement)),
        ("Relative velocity", scales[1].label(pair.velocity)),
    )


def _shown_part(subject: Subject) -> Any:
    scene = subject.scene
    if not scene.stops:
        return pairs_of(scene)[0]
    if len(scene.stops) == 1:
        return scene.stops[0]
    events = subject.result.events
    part = np.asarray(events["part"])[np.isin(np.asarray(events["kind"]), IMPACT_CODES)]
    return scene.stops[int(np.argmax(np.bincount(part, minlength=len(scene.stops))))]
