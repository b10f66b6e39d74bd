"""Symbols of mechanics: spring, dashpot, stop, wall, floor, belt, pads, arrows. Lengths in centimetres."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyBboxPatch, Rectangle

from vibsim.plots.machine.elements import DAMPED, RIGID
from vibsim.plots.style import BLUE, GREEN, GREY, ORANGE, VERMILLION

INK = "0.15"
LINE = 0.8  # width of lines [pt]
SMALL = 6  # size of labels [pt]
COILS = 5
PAPER = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}  # behind a label that a line may cross
PARTS: dict[str, Any] = {
    "color": INK,
    "linewidth": LINE,
    "solid_capstyle": "round",
    "solid_joinstyle": "round",
}


def line(axes: Axes, x: Any, y: Any, gid: str = "", **look: Any) -> None:
    axes.plot(x, y, gid=gid or None, **{**PARTS, **look})


def label(axes: Axes, x: float, y: float, text: str, **look: Any) -> None:
    axes.text(x, y, text, **{"fontsize": SMALL, "ha": "center", "va": "center", "color": INK, **look})


def body(axes: Axes, x: float, width: float, height: float, name: str, mass: str) -> None:
    """A box with name and mass."""
    patch = FancyBboxPatch(
        (x, 0), width, height, boxstyle="round,pad=0,rounding_size=0.08",
        facecolor="0.93", edgecolor=INK, linewidth=LINE, gid=f"bodies.{name}", zorder=3,
    )  # fmt: skip
    axes.add_patch(patch)
    label(axes, x + width / 2, height / 2 + 0.16, name, fontsize=7.5, weight="bold", zorder=4)
    label(axes, x + width / 2, height / 2 - 0.2, mass, zorder=4)


def spring(axes: Axes, x0: float, x1: float, y: float, gid: str = "") -> None:
    """A coil, with a straight end on either side."""
    end = 0.16 * (x1 - x0)
    inner = np.linspace(x0 + end, x1 - end, 2 * COILS + 2)
    swing = np.array([0, *[0.14 * (-1) ** i for i in range(2 * COILS)], 0])
    line(axes, [x0, *inner, x1], y + np.array([0, *swing, 0]), gid, color=BLUE)


def damper(axes: Axes, x0: float, x1: float, y: float, gid: str = "") -> None:
    """A dashpot: piston in an open cylinder."""
    a, b = x0 + 0.38 * (x1 - x0), x0 + 0.62 * (x1 - x0)
    middle = (a + b) / 2
    line(axes, [x0, a], [y, y], gid, color=GREEN)
    line(axes, [b, a, a, b], [y + 0.15, y + 0.15, y - 0.15, y - 0.15], color=GREEN)
    line(axes, [middle, middle], [y + 0.1, y - 0.1], color=GREEN)
    line(axes, [middle, x1], [y, y], color=GREEN)


def support(axes: Axes, x0: float, x1: float, y: float, law: str, gid: str = "") -> None:
    """What bears a stop: a spring, with a dashpot beside it where it is damped; a bar where it is rigid."""
    if law == RIGID:
        line(axes, [x0, x1], [y, y], gid, color=VERMILLION, linewidth=3 * LINE)
        return
    if law != DAMPED:
        coil(axes, x0, x1, y, gid)
        return
    line(axes, [x0, x0], [y - 0.14, y + 0.14], color=VERMILLION)
    line(axes, [x1, x1], [y - 0.14, y + 0.14], color=VERMILLION)
    coil(axes, x0, x1, y + 0.13, gid)
    a, b = x0 + 0.3 * (x1 - x0), x0 + 0.7 * (x1 - x0)
    middle, low = (a + b) / 2, y - 0.13
    line(axes, [x0, a], [low, low], color=VERMILLION)
    line(axes, [b, a, a, b], [low + 0.08, low + 0.08, low - 0.08, low - 0.08], color=VERMILLION)
    line(axes, [middle, middle], [low + 0.05, low - 0.05], color=VERMILLION)
    line(axes, [middle, x1], [low, low], color=VERMILLION)


def coil(axes: Axes, x0: float, x1: float, y: float, gid: str = "") -> None:
    x = np.linspace(x0, x1, 9)
    line(axes, x, y + np.array([0, *[0.1 * (-1) ** i for i in range(7)], 0]), gid, color=VERMILLION)


def stop(axes: Axes, x0: float, x1: float, y: float, law: str, gid: str) -> None:
    """A bumper before the right end; the left end meets it when the gap is closed."""
    plate = x0 + 0.42 * (x1 - x0)
    nose = x0 + 0.14 * (x1 - x0)
    line(axes, [x0, nose], [y, y])
    line(axes, [nose, nose], [y - 0.16, y + 0.16], linewidth=2 * LINE)
    line(axes, [plate, plate], [y - 0.2, y + 0.2], linewidth=2 * LINE, color=VERMILLION)
    support(axes, plate, x1, y, law, gid)
    dimension(axes, nose, plate, y)


def hook(axes: Axes, x0: float, x1: float, y: float, law: str, gid: str) -> None:
    """A stop that acts while the ends move apart: the head of a rod behind the lips of a bracket."""
    lips, head = x0 + 0.5 * (x1 - x0), x0 + 0.8 * (x1 - x0)
    support(axes, x0, x0 + 0.36 * (x1 - x0), y, law, gid)
    line(axes, [x0 + 0.36 * (x1 - x0), head], [y, y])
    line(axes, [head, head], [y - 0.14, y + 0.14], linewidth=2 * LINE, color=VERMILLION)
    for side in (-1, 1):
        line(axes, [lips, lips, x1], [y + side * 0.06, y + side * 0.22, y + side * 0.22])
    dimension(axes, lips, head, y + 0.11)


def dimension(axes: Axes, x0: float, x1: float, y: float) -> None:
    """A measured distance."""
    look = {
        "arrowstyle": "<->",
        "linewidth": 0.5,
        "color": GREY,
        "shrinkA": 0,
        "shrinkB": 0,
        "mutation_scale": 4,
    }
    axes.annotate("", (x1, y), (x0, y), arrowprops=look, annotation_clip=False)


def clearance(axes: Axes, x0: float, x1: float, y: float, gid: str) -> None:
    """A limit that exerts no force: a dashed line between two marks."""
    line(axes, [x0, x1], [y, y], gid, color=GREY, linestyle=(0, (4, 2)))
    for x in (x0 + 0.04, x1 - 0.04):
        line(axes, [x, x], [y - 0.12, y + 0.12], color=GREY)


def pads(axes: Axes, x0: float, x1: float, y: float, gid: str) -> None:
    """Friction between two bodies: a plate of each, pressed onto one another."""
    a, b = x0 + 0.25 * (x1 - x0), x0 + 0.75 * (x1 - x0)
    line(axes, [x0, b], [y + 0.045, y + 0.045], gid, color=ORANGE, linewidth=1.6)
    line(axes, [a, x1], [y - 0.045, y - 0.045], color=ORANGE, linewidth=1.6)
    for side in (-1, 1):
        look = {
            "arrowstyle": "-|>",
            "linewidth": 0.5,
            "color": GREY,
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 5,
        }
        axes.annotate("", ((a + b) / 2, y + side * 0.07), ((a + b) / 2, y + side * 0.26), arrowprops=look)


def wall(axes: Axes, x: float, y0: float, y1: float, side: int, moving: bool, gid: str) -> None:
    """What does not move (hatched), or moves as base (grey), left (side -1) or right (1) of x."""
    width = 0.2
    look: dict[str, Any] = {"facecolor": "0.8"} if moving else {"facecolor": "white", "hatch": "////////"}
    corner = (x - width if side < 0 else x, y0)
    axes.add_patch(Rectangle(corner, width, y1 - y0, edgecolor="0.55", linewidth=0, gid=gid, **look))
    line(axes, [x, x], [y0, y1])


def floor(axes: Axes, x0: float, x1: float, y: float, moving: bool, gid: str) -> None:
    """A surface to rub on: hatched, or grey where it moves as base."""
    look: dict[str, Any] = {"facecolor": "0.8"} if moving else {"facecolor": "white", "hatch": "////////"}
    axes.add_patch(Rectangle((x0, y - 0.2), x1 - x0, 0.2, edgecolor="0.55", linewidth=0, gid=gid, **look))
    line(axes, [x0, x1], [y, y], color=ORANGE, linewidth=1.6)


def belt(axes: Axes, x0: float, x1: float, y: float, forward: bool, gid: str) -> None:
    """A belt on two rollers, with the way it moves."""
    radius = 0.12
    for x in (x0 + radius, x1 - radius):
        axes.add_patch(Circle((x, y - radius), radius, fill=False, edgecolor=INK, linewidth=LINE))
    line(axes, [x0 + radius, x1 - radius], [y, y], gid, color=ORANGE, linewidth=1.6)
    line(axes, [x0 + radius, x1 - radius], [y - 2 * radius, y - 2 * radius])
    middle, reach = (x0 + x1) / 2, 0.25 if forward else -0.25
    arrow(axes, middle - reach, middle + reach, y - radius)


def wheels(axes: Axes, x0: float, x1: float, y: float) -> None:
    """A guide without friction: two wheels on a line."""
    for x in (x0 + 0.3, x1 - 0.3):
        axes.add_patch(Circle((x, y - 0.08), 0.08, fill=False, edgecolor=GREY, linewidth=0.6))
    line(axes, [x0, x1], [y - 0.16, y - 0.16], color=GREY, linewidth=0.6)


def arrow(axes: Axes, x0: float, x1: float, y: float, gid: str = "", both: bool = False) -> None:
    look = {"linewidth": LINE, "color": INK, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}
    style = "<|-|>" if both else "-|>"
    note = axes.annotate(
        "", (x1, y), (x0, y), arrowprops={"arrowstyle": style, **look}, annotation_clip=False
    )
    note.set_gid(gid or None)


def rotor(axes: Axes, x: float, y: float) -> None:
    """A motor with an unbalanced mass, on what it stands on at y."""
    radius = 0.36
    centre = y + radius + 0.12
    line(axes, [x - 0.22, x, x + 0.22], [y, centre, y], zorder=2)
    axes.add_patch(Circle((x, centre), radius, facecolor="white", edgecolor=INK, linewidth=LINE, gid="motor"))
    line(axes, [x, x + 0.2], [centre, centre + 0.16], linewidth=0.6)
    axes.add_patch(
        Circle((x + 0.2, centre + 0.16), 0.075, facecolor=VERMILLION, edgecolor=INK, linewidth=0.5)
    )
    axes.add_patch(Circle((x, centre), 0.035, facecolor=INK, edgecolor=INK))
