"""The two bodies whose motion against each other is drawn, and the stops between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import BASE, GROUND, Link
from vibsim.physics.parts import Scene as PartsScene
from vibsim.plots.quantities import symbol
from vibsim.plots.relative_motion import (
    DISPLACEMENT,
    VELOCITY,
    relative,
    state_names,
    stop_equation,
    stop_position,
)
from vibsim.plots.subject import Subject
from vibsim.plots.trace import Plane
from vibsim.plots.user_text import as_text
from vibsim.results.relative_motion import RelativeMotion


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
    """Of two blocks these; of a scene of named parts the ends of the stop that is struck most often, else of
    the first link, else of the first friction, else the first body and ground.
    """
    if subject.is_of_parts:
        return _pair_of_parts(subject.scene, _shown_part(subject))
    scene = subject.scene
    stops = ((stop_position(scene), stop_equation(scene)),) if scene.has_stop else ()
    return Pair(state_names(scene), relative, DISPLACEMENT, VELOCITY, stops)


def _shown_part(subject: Subject) -> Any:
    scene: PartsScene = subject.scene
    if not scene.stops:
        return next(iter([*scene.links, *scene.frictions, Link("", 0, GROUND, 0.0, 0.0)]))
    events = subject.result.events
    part = np.asarray(events["part"])[np.asarray(events["kind"]) == EVENT_KINDS["contact_begin"]]
    return scene.stops[int(np.argmax(np.bincount(part, minlength=len(scene.stops))))]


def _pair_of_parts(scene: PartsScene, part: Any) -> Pair:
    motion = RelativeMotion(scene, part)

    def plane(block: Any) -> tuple[np.ndarray, np.ndarray]:
        _, x, v = motion(block, "time")
        return x, v

    x, v = (_difference(scene, part, letter) for letter in "xv")
    return Pair(("time", *motion.columns), plane, x, v, tuple(_stops(scene, part)))


def _difference(scene: PartsScene, part: Any, letter: str) -> str:
    """x_P - x_Q in symbols; a term at rest left out, the base in capitals."""
    first, second = (
        "" if end == GROUND else f"${letter.upper()}$" if end == BASE else _symbol(scene, end, letter)
        for end in (part.P, part.Q)
    )
    return f"{first} \N{MINUS SIGN} {second}" if first and second else first or f"\N{MINUS SIGN}{second}"


def _symbol(scene: PartsScene, end: int, letter: str) -> str:
    return symbol(f"{letter}_{scene.end_name(end)}")


def _stops(scene: PartsScene, part: Any) -> list[tuple[float, str]]:
    """Where x_P - x_Q of `part` meets each stop between the same ends [m], and its name."""
    found = []
    for stop in scene.stops:
        if {stop.P, stop.Q} == {part.P, part.Q}:
            position = -stop.sense * stop.gap
            found.append((position if stop.P == part.P else -position, as_text(stop.name)))
    return found
