"""Where everything stands in the drawing of a scene, in centimetres."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from vibsim.plots.machine.elements import (
    CHARACTER_CM,
    FIXED,
    Element,
    elements,
    floors,
    friction_label,
    motor_label,
    short,
    source_labels,
)

LANE_CM = 1.15  # height that an element takes, with its labels
LEAST_HEIGHT_CM = 1.3
LEAST_WIDTH_CM = 1.5  # of a body
NARROW_CM = 0.5  # between bodies that nothing joins
SOURCE_CM = 0.62  # height that a force takes, with its label
MOTOR_CM = 1.25
OVERHANG = 0.6  # least width of a body, of that of its labels


@dataclass(frozen=True)
class Box:
    """A body: its left edge, width and name [cm]."""

    name: str
    x: float
    width: float

    @property
    def right(self) -> float:
        return self.x + self.width

    @property
    def centre(self) -> float:
        return self.x + self.width / 2


@dataclass
class Layout:
    """The drawing: bodies stand on y = 0 and are `height` high.

    Attributes
    ----------
    boxes : bodies, from left to right
    slots : elements left of, between and right of the bodies, in lanes from the top: n + 1 of them
    edges : (left, right) of each slot [cm]
    above : elements that join bodies that are no neighbours, in lanes above them
    roof : y above which those lanes begin [cm]
    """

    height: float
    boxes: list[Box]
    slots: list[list[Element]]
    edges: list[tuple[float, float]]
    above: list[Element] = field(default_factory=list)
    roof: float = 0.0

    @property
    def width(self) -> float:
        return self.edges[-1][1]

    @property
    def top(self) -> float:
        return self.roof + LANE_CM * len(self.above)

    def box(self, name: str) -> Box:
        return next(box for box in self.boxes if box.name == name)


def layout(values: dict[str, Any]) -> Layout:
    """The layout of the nested values of a case in the long form."""
    names = list(values["bodies"])
    slots: list[list[Element]] = [[] for _ in range(len(names) + 1)]
    above = []
    for element in elements(values):
        slot = _slot(element, names)
        if slot is None:
            above.append(element)
        else:
            slots[slot].append(element)
    height = max(LEAST_HEIGHT_CM, LANE_CM * max(map(len, slots)))
    boxes, edges = _columns(values, slots)
    roof = height + max(_stack(values, name) for name in names) + 0.2
    return Layout(height, boxes, slots, edges, above, roof)


def _slot(element: Element, names: list[str]) -> int | None:
    """Number of the gap between bodies that an element fits into; None for one that passes over bodies."""
    if element.left in FIXED:
        return 0 if element.right == names[0] else None
    if element.right in FIXED:
        return len(names) if element.left == names[-1] else None
    left, right = names.index(element.left), names.index(element.right)
    return right if right == left + 1 else None


def _columns(
    values: dict[str, Any], slots: list[list[Element]]
) -> tuple[list[Box], list[tuple[float, float]]]:
    """Bodies and the gaps between them, from left to right."""
    boxes: list[Box] = []
    edges, x = [], 0.0
    names = list(values["bodies"])
    for i, slot in enumerate(slots):
        outside = i in (0, len(names))
        width = max((element.width for element in slot), default=0.0 if outside else NARROW_CM)
        edges.append((x, x + width))
        x += width
        if i < len(names):
            boxes.append(Box(names[i], x, _body_width(values, names[i])))
            x = boxes[-1].right
    return boxes, edges


def _body_width(values: dict[str, Any], name: str) -> float:
    """Room for name and mass, and for what drives the body."""
    inside = max(len(name), len(short(values["bodies"][name]))) * 0.15 + 0.4
    return max(LEAST_WIDTH_CM, inside, OVERHANG * label_width(values, name))


def label_width(values: dict[str, Any], name: str) -> float:
    """Width of the longest label on top of a body or below it [cm]."""
    labels = [label for _, label in source_labels(values, name)]
    labels += [friction_label(friction) for _, friction in floors(values, name)]
    if values.get("motor", {}).get("on") == name:
        labels.append(motor_label(values["motor"]))
    return max(map(len, labels), default=0) * CHARACTER_CM


def _stack(values: dict[str, Any], name: str) -> float:
    """Height of motor and forces on a body [cm]."""
    motor = MOTOR_CM if values.get("motor", {}).get("on") == name else 0.0
    return motor + SOURCE_CM * len(source_labels(values, name))
