"""Where the moving machine stands: slots wide enough for the motion, gaps of stops to the scale of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vibsim.plots.machine.elements import BASE, FIXED, Element
from vibsim.plots.machine.layout import LANE_CM, Layout, layout

TRAVEL_CM = 1.8  # that the widest relative motion, or gap, takes
NOSE_CM = 0.35  # from the end of a stop's left body to its bumper
SUPPORT_CM = 1.1  # from a free plate to the end that bears it
ROD_CM = 0.45  # of a hook, between its spring and its head
FLOOR_TICK_CM = 0.35

Ends = dict[str, np.ndarray]  # displacement [m] of each end over the frames


@dataclass(frozen=True)
class Stage:
    """The machine at rest, in centimetres.

    Attributes
    ----------
    values : nested values of the case in the long form
    plan : layout whose slots leave room for the motion
    scale : centimetres of the picture per metre of motion
    gaps : of each stop by its key, its gap [cm]
    """

    values: dict[str, Any]
    plan: Layout
    scale: float
    gaps: dict[str, float]

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies, from left to right."""
        return [box.name for box in self.plan.boxes]

    @property
    def placed(self) -> list[tuple[Element, float, int]]:
        """Elements with their height [cm] and number of slot; above the bodies slot -1."""
        inside = [
            (element, self.plan.height * (1 - (i + 0.5) / len(slot)), number)
            for number, slot in enumerate(self.plan.slots)
            for i, element in enumerate(slot)
        ]
        over = [
            (element, self.plan.roof + LANE_CM * (i + 0.5), -1) for i, element in enumerate(self.plan.above)
        ]
        return [*inside, *over]

    @property
    def stops(self) -> list[Element]:
        """The stops, in the order in which they are placed."""
        return [element for element, _, _ in self.placed if element.kind in ("stop", "hook")]


def stage_for(values: dict[str, Any], motion: Ends, gaps: dict[str, float]) -> Stage:
    """The stage of a motion.

    values : nested values of the long form; motion : displacements [m] of the ends over the frames
    gaps : gap [m] of each stop, by its key
    """
    plan = layout(values)
    names = [box.name for box in plan.boxes]
    between = [_relative(slot, i, names, motion) for i, slot in enumerate(plan.slots)]
    travels = [*(np.abs(each).max() for each in between), *(0.5 * np.ptp(motion[name]) for name in names)]
    widest = float(max([*travels, *map(abs, gaps.values())]))
    scale = TRAVEL_CM / widest if widest > 0 else 1.0
    drawn = {key: gap * scale for key, gap in gaps.items()}
    widen(plan, [scale * max(-float(each.min()), 0.0) for each in between], drawn)
    return Stage(values, plan, scale, drawn)


def _relative(slot: list[Element], number: int, names: list[str], motion: Ends) -> np.ndarray:
    """How much further apart than at rest the ends of a slot are over the frames [m]."""
    still = np.zeros(1)
    if number == 0:
        left = motion[BASE] if any(element.left == BASE for element in slot) else still
        return motion[names[0]] - left if slot else still
    if number == len(names):
        right = motion[BASE] if any(element.right == BASE for element in slot) else still
        return right - motion[names[-1]] if slot else still
    return motion[names[number]] - motion[names[number - 1]]


def widen(plan: Layout, closing: list[float], gaps: dict[str, float]) -> None:
    """Give each slot the room by which its ends come closer [cm], and its stops the room of their gaps."""
    x = 0.0
    for number, slot in enumerate(plan.slots):
        width = plan.edges[number][1] - plan.edges[number][0] + closing[number]
        stops = [each for each in slot if each.kind in ("stop", "hook")]
        needed = [NOSE_CM + SUPPORT_CM + ROD_CM + abs(gaps[each.key]) + closing[number] for each in stops]
        width = max([width, *needed])
        plan.edges[number] = (x, x + width)
        x += width
        if number < len(plan.boxes):
            box = plan.boxes[number]
            plan.boxes[number] = type(box)(box.name, x, box.width)
            x += box.width


def attached(stage: Stage, element: Element, slot: int, side: int) -> float:
    """Where an element's left (side -1) or right (1) end is at rest [cm]."""
    if slot >= 0:
        return stage.plan.edges[slot][0 if side < 0 else 1]
    name = element.left if side < 0 else element.right
    if name in FIXED:
        return attached(stage, element, slot, -side) + side * element.width
    box = stage.plan.box(name)
    return box.centre - side * 0.3 * box.width
