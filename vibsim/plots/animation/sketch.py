"""The machine at given positions, drawn with the symbols of its still drawing."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.patches import Circle

from vibsim.plots.animation.channels import COSINE, FLOOR, SINE, Channels
from vibsim.plots.animation.display_list import Moving, moving_shapes
from vibsim.plots.animation.stage import FLOOR_TICK_CM, NOSE_CM, ROD_CM, Stage, attached
from vibsim.plots.machine import symbols
from vibsim.plots.machine.elements import BASE, FIXED, Element, floors, short
from vibsim.plots.style import GREY, ORANGE, VERMILLION

MARGIN_CM = 0.5
BELOW_CM = 0.75
ROTOR_CM = 0.36
ROTOR_ABOVE_CM = 0.12


def display_list(channels: Channels) -> list[Moving]:
    """The drawing as shapes that follow the channels."""
    names = channels.names

    def draw(axes: Any, values: np.ndarray) -> None:
        sketch(axes, channels.stage, dict(zip(names, values.tolist(), strict=True)))

    return moving_shapes(draw, len(names))


def frame_of(stage: Stage, channels: np.ndarray) -> tuple[float, float, float, float]:
    """Left, lower, right and upper edge of the drawing [cm]; channels : values of the ends (n, m)."""
    reach = float(np.abs(channels).max(initial=0.0))
    above = stage.plan.roof + 1.15 * len(stage.plan.above)
    return -reach - MARGIN_CM, -BELOW_CM, stage.plan.width + reach + MARGIN_CM, above + 0.3


def sketch(axes: Any, stage: Stage, at: dict[str, float]) -> None:
    """Draw the machine; at : value of each channel."""
    plan = stage.plan
    _ground(axes, stage, at)
    for element, y, slot in stage.placed:
        x0 = attached(stage, element, slot, -1) + at[element.left]
        x1 = attached(stage, element, slot, 1) + at[element.right]
        if slot < 0:
            for name, x in ((element.left, x0), (element.right, x1)):
                if name not in FIXED:
                    symbols.line(axes, [x, x], [plan.height, y + 0.12])
        _walls(axes, element, x0, x1, y)
        _element(axes, element, x0, x1, y, at)
    for box in plan.boxes:
        mass = short(stage.values["bodies"][box.name])
        symbols.body(axes, box.x + at[box.name], box.width, plan.height, box.name, mass)
    motor = stage.values.get("motor")
    if motor is not None:
        box = plan.box(motor["on"])
        _rotor(axes, box.centre + at[box.name], plan.height, at[COSINE], at[SINE])


def _element(axes: Any, element: Element, x0: float, x1: float, y: float, at: dict[str, float]) -> None:
    if element.kind == "stop":
        plate, nose = at[element.key], x0 + NOSE_CM
        symbols.line(axes, [x0, nose], [y, y])
        symbols.line(axes, [nose, nose], [y - 0.16, y + 0.16], linewidth=2 * symbols.LINE)
        _plate(axes, element.key, plate, y, 0.2)
        symbols.support(axes, plate, x1, y, element.law, element.key)
    elif element.kind == "hook":
        head, lips = at[element.key], x1 - NOSE_CM
        symbols.support(axes, x0, head - ROD_CM, y, element.law, element.key)
        symbols.line(axes, [head - ROD_CM, head], [y, y])
        _plate(axes, element.key, head, y, 0.14)
        for side in (-1, 1):
            symbols.line(axes, [lips, lips, x1], [y + side * 0.06, y + side * 0.22, y + side * 0.22])
    else:
        draw = {
            "spring": symbols.spring,
            "damper": symbols.damper,
            "clearance": symbols.clearance,
            "friction": symbols.pads,
        }[element.kind]
        draw(axes, x0, x1, y, element.key)
    symbols.label(axes, (x0 + x1) / 2, y + 0.4, element.title.partition(":")[0], style="italic")


def _plate(axes: Any, key: str, x: float, y: float, reach: float) -> None:
    """What is struck of a stop."""
    look = {"linewidth": 2 * symbols.LINE, "color": VERMILLION}
    symbols.line(axes, [x, x], [y - reach, y + reach], key, **look)


def _walls(axes: Any, element: Element, x0: float, x1: float, y: float) -> None:
    for end, x, side in ((element.left, x0, -1), (element.right, x1, 1)):
        if end in FIXED:
            symbols.wall(axes, x, y - 0.4, y + 0.4, side, end == BASE, end)


def _ground(axes: Any, stage: Stage, at: dict[str, float]) -> None:
    """What bodies rub on, its marks moving past an eye that follows the machine; a line below the others."""
    for box in stage.plan.boxes:
        own = floors(stage.values, box.name)
        x0, x1 = box.x - 0.9, box.right + 0.9
        if not own:
            symbols.line(axes, [x0, x1], [-0.16, -0.16], color=GREY, linewidth=0.6)
            for x in (box.x + 0.3, box.right - 0.3):
                wheel = Circle((x + at[box.name], -0.08), 0.08, fill=False, edgecolor=GREY, linewidth=0.6)
                axes.add_patch(wheel)
            continue
        symbols.line(axes, [x0, x1], [-0.03, -0.03], f"friction.{own[0][0]}", color=ORANGE, linewidth=1.6)
        for k in range(int((x1 - x0) / FLOOR_TICK_CM)):
            x = x0 + k * FLOOR_TICK_CM + at[FLOOR] + FLOOR_TICK_CM
            symbols.line(axes, [x, x - 0.18], [-0.05, -0.25], color=GREY, linewidth=0.6)


def _rotor(axes: Any, x: float, y: float, cosine: float, sine: float) -> None:
    """A motor with its unbalanced mass at an angle."""
    centre = y + ROTOR_CM + ROTOR_ABOVE_CM
    symbols.line(axes, [x - 0.22, x, x + 0.22], [y, centre, y])
    axes.add_patch(
        Circle((x, centre), ROTOR_CM, facecolor="white", edgecolor=symbols.INK, linewidth=symbols.LINE)
    )
    arm = 0.7 * ROTOR_CM
    mass = (x + arm * cosine, centre + arm * sine)
    symbols.line(axes, [x, mass[0]], [centre, mass[1]], "motor", linewidth=1.0)
    axes.add_patch(Circle(mass, 0.09, facecolor=VERMILLION, edgecolor=symbols.INK, linewidth=0.5))
