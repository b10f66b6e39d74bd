"""The stops in the plane of a relative motion, and what motions of two ends against each other are called."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from vibsim.physics.parts import BASE, GROUND, RigidStop, Scene, Stop
from vibsim.physics.two_blocks import is_papers
from vibsim.plots.page.quantities import Scale, symbol
from vibsim.plots.page.user_text import as_text
from vibsim.plots.style import GREY, points

DISPLACEMENT = "$x_1 - x_2$"
VELOCITY = "$v_1 - v_2$"
STOP = "stop"  # what the short form of a case calls its stop
PAPERS = (STOP, "coupling")  # and all that is between its blocks


def difference(scene: Scene, part: Any, letter: str) -> str:
    """x_P - x_Q, or with v, in symbols; a term at rest left out, the base in capitals."""
    if part.name in PAPERS and is_papers(scene):
        return {"x": DISPLACEMENT, "v": VELOCITY}[letter]  # a fixed block 2 too
    first, second = (
        "" if end == GROUND else letter.upper() if end == BASE else _symbol(scene, end, letter)
        for end in (part.P, part.Q)
    )
    return f"${first} - {second}$" if first and second else f"${first}$" if first else f"$-{second}$"


def _symbol(scene: Scene, end: int, letter: str) -> str:
    return symbol(f"{letter}_{scene.end_name(end)}").strip("$")


def stop_position(stop: Stop | RigidStop, part: Any) -> float:
    """Where x_P - x_Q of a part between the same ends meets the stop [m]."""
    position = -stop.sense * stop.gap
    return float(position if stop.P == part.P else -position)


def stops_between(scene: Scene, part: Any) -> list[Stop | RigidStop]:
    """The stops between the ends of a part."""
    return [stop for stop in scene.stops if {stop.P, stop.Q} == {part.P, part.Q}]


def stop_label(stop: Stop | RigidStop) -> str:
    """What a stop is called beside its line: its name; the paper's is told by its equation."""
    if stop.name != STOP:
        return as_text(stop.name)
    return "$x_2 - x_1 = G$" if stop.sense > 0 else "$x_1 - x_2 = G$"


def draw_stop_line(axes: Axes, position: float, scale: Scale, text: str) -> None:
    """A stop at a relative displacement [m] as a dashed line across the axes, a text above it."""
    at = float(scale(position))
    axes.axvline(at, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=0, gid="stop")
    if text:
        axes.annotate(
            text, (at, 1), (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points",
            ha="center", va="bottom", fontsize=points(7), color=GREY,
        )  # fmt: skip
