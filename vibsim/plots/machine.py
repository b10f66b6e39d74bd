"""The drawing of a scene: bodies, springs, dampers, stops, frictions and what drives them, as a schematic."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from vibsim.plots import machine_symbols, style
from vibsim.plots.machine_symbols import (
    BASE,
    CHARACTER_CM,
    FIXED,
    Element,
    base_label,
    belt_speed,
    elements,
    floors,
    friction_label,
    rotors_on,
    short,
    source_labels,
)
from vibsim.plots.sheet import CM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibsim.cases import Case


def draw_machine_file(case: Case, out: str, force: bool = False) -> str:
    """Draw the machine of a case of either form into a picture, .png, .pdf or .svg; returns its name.

    Raises PlotError for another format and ResultFileError where the file exists (unless `force`) or cannot
    be written.
    """
    from vibsim.plots.picture import write_figure

    with style.applied():
        write_figure(machine_figure(case.long_values()), out, force)
    return out


# Draw a scene: ties between and above its bodies, what they rub on below, what drives them on top.


MARGIN_CM = 0.35
FLOOR_CM = 0.46  # from a body to the first label below it
LABEL_CM = 0.26  # a line of text
BASE_CM = 0.3  # and from there to the motion of base
STEM = 0.42  # where the stem of an element above the bodies stands, of the width, from the middle
DIRECTION_CM = 0.38  # from the last of them to the arrow that shows the positive direction


def machine_figure(values: dict[str, Any]) -> Figure:
    """The drawing of the nested values of a case in the long form, at its final size."""
    from matplotlib.figure import Figure

    width, height = machine_size(values)
    figure = Figure(figsize=(width * CM, height * CM))
    machine_panel(figure.add_axes((0, 0, 1, 1)), values)
    return figure


def machine_size(values: dict[str, Any]) -> tuple[float, float]:
    """Width and height of the drawing [cm]."""
    left, bottom, right, top = _frame(values, layout(values))
    return right - left, top - bottom


def machine_panel(axes: Axes, values: dict[str, Any]) -> None:
    """The drawing in given axes, to scale: in its final size where they have that room."""
    plan = layout(values)
    left, bottom, right, top = _frame(values, plan)
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    draw_machine(axes, values, plan)


def _frame(values: dict[str, Any], plan: Layout) -> tuple[float, float, float, float]:
    """Left, lower, right and upper edge of the drawing [cm]."""
    left, right = _outer_edges(values, plan)
    return left - MARGIN_CM, -_depth(values) - MARGIN_CM, right + MARGIN_CM, plan.top + MARGIN_CM


def draw_machine(axes: Axes, values: dict[str, Any], plan: Layout) -> None:
    """The drawing in given axes, whose units are centimetres."""
    for box in plan.boxes:
        machine_symbols.body(axes, box.x, box.width, plan.height, values, box.name)
        _below(axes, values, box)
        _on_top(axes, values, box, plan.height)
    for number, (slot, edges) in enumerate(zip(plan.slots, plan.edges, strict=True)):
        _lanes(axes, slot, edges, plan.height)
        _walls(axes, values, slot, edges, plan.height, -1 if number == 0 else 1)
    for i, element in enumerate(plan.above):
        _over(axes, element, plan, plan.roof + LANE_CM * (i + 0.5))
    _direction(axes, values, plan, -_depth(values))


def _depth(values: dict[str, Any]) -> float:
    """Height of what is below the bodies [cm]."""
    most = max(len(floors(values, name)) for name in values["bodies"])
    labels = FLOOR_CM + LABEL_CM * (2 * most - 1) if most else 0.2
    return labels + DIRECTION_CM + (BASE_CM if "base" in values else 0.0)


def _outer_edges(values: dict[str, Any], plan: Layout) -> tuple[float, float]:
    """Left and right end of the drawing [cm], walls and labels included."""
    reach = [(box.centre, label_width(values, box.name) / 2) for box in plan.boxes]
    ends = [x for centre, half in reach for x in (centre - half, centre + half)]
    ends += [_end(element, plan, side) + 0.25 * side for element in plan.above for side in (-1, 1)]
    if "base" in values:
        ends.append(plan.boxes[0].x + 0.7 + len(base_label(values)) * CHARACTER_CM + 0.6)
    return min(-0.25, *ends), max(plan.width + 0.25, *ends)


def _below(axes: Axes, values: dict[str, Any], box: Box) -> None:
    """Draw the surfaces on which a body rubs, side by side; wheels where there are none."""
    own = floors(values, box.name)
    if not own and not _rubs(values, box.name) and not machine_symbols.turns(values, box.name):
        machine_symbols.wheels(axes, box.x, box.right, -0.02)
    width = (box.width + 0.3) / max(len(own), 1)
    for i, (name, friction) in enumerate(own):
        x0 = box.x - 0.15 + i * width
        _floor(axes, friction, x0 + 0.03, x0 + width - 0.03, f"friction.{name}")
        y = -FLOOR_CM - 2 * i * LABEL_CM
        machine_symbols.label(axes, box.centre, y, name, style="italic")
        machine_symbols.label(axes, box.centre, y - LABEL_CM, friction_label(friction))


def _rubs(values: dict[str, Any], body: str) -> bool:
    """True for a body that rubs on another one, which then carries it."""
    return any(body in (f["between"].P, f["between"].Q) for f in values.get("friction", {}).values())


def _floor(axes: Axes, friction: dict[str, Any], x0: float, x1: float, gid: str) -> None:
    ends = friction["between"]
    speed = belt_speed(friction) * (1 if ends.Q in FIXED else -1)
    if speed:
        machine_symbols.belt(axes, x0, x1, -0.03, speed > 0, gid)
    else:
        machine_symbols.floor(axes, x0, x1, -0.03, BASE in (ends.P, ends.Q), gid)


def _on_top(axes: Axes, values: dict[str, Any], box: Box, y: float) -> None:
    """Motor, rotors and forces of a body."""
    for key, text in rotors_on(values, box.name):
        machine_symbols.rotor(axes, box.centre, y, key)
        machine_symbols.label(axes, box.centre, y + MOTOR_CM - 0.2, text)
        y += MOTOR_CM
    for i, (key, text) in enumerate(source_labels(values, box.name)):
        level = y + SOURCE_CM * i + 0.17
        ways = machine_symbols.ways_of(values["forces"][key.partition(".")[2]])
        torque = machine_symbols.turns(values, box.name)
        machine_symbols.force_arrow(axes, box.centre, level, ways, key, torque)
        machine_symbols.label(axes, box.centre, level + 0.22, text, bbox=machine_symbols.PAPER)


def _lanes(axes: Axes, slot: list[Element], edges: tuple[float, float], height: float) -> None:
    """The elements of a gap between bodies, from the top."""
    for i, element in enumerate(slot):
        y = height * (1 - (i + 0.5) / len(slot))
        _element(axes, element, *edges, y)


def _element(axes: Axes, element: Element, x0: float, x1: float, y: float) -> None:
    if element.kind in ("stop", "hook"):
        draw = machine_symbols.stop if element.kind == "stop" else machine_symbols.hook
        draw(axes, x0, x1, y, element.law, element.key)
    elif element.kind == "law":
        machine_symbols.law(axes, x0, x1, y, element.law, element.key)
    elif element.kind == "friction":
        machine_symbols.pads(axes, x0, x1, y, element.key)
    else:
        {
            "spring": machine_symbols.spring,
            "damper": machine_symbols.damper,
            "clearance": machine_symbols.clearance,
        }[element.kind](axes, x0, x1, y, element.key)
    middle = (x0 + x1) / 2
    machine_symbols.label(axes, middle, y + 0.38, element.title, style="italic")
    machine_symbols.label(axes, middle, y - 0.38, element.value)


def _walls(
    axes: Axes,
    values: dict[str, Any],
    slot: list[Element],
    edges: tuple[float, float],
    height: float,
    side: int,
) -> None:
    """The walls at the far ends: one piece for each run of lanes that end at the same."""
    ends = [element.left if side < 0 else element.right for element in slot]
    x, lane = edges[0] if side < 0 else edges[1], height / max(len(slot), 1)
    for i, end in enumerate(ends):
        if end in FIXED and (i == 0 or ends[i - 1] != end):
            last = next((j for j in range(i, len(ends)) if ends[j] != end), len(ends))
            y1, y0 = height - lane * i - 0.08, height - lane * last + 0.08
            machine_symbols.wall(axes, x, y0, y1, side, end == BASE, end)


def _over(axes: Axes, element: Element, plan: Layout, y: float) -> None:
    """An element above the bodies, between stems of those that it joins, or a stem and a wall of its own."""
    x0, x1 = _stem(axes, element, plan, y, -1), _stem(axes, element, plan, y, 1)
    _element(axes, element, x0, x1, y)


def _stem(axes: Axes, element: Element, plan: Layout, y: float, side: int) -> float:
    """Draw one end of an element above the bodies; x of the end [cm]."""
    end = element.left if side < 0 else element.right
    x = _end(element, plan, side)
    if end in FIXED:
        machine_symbols.wall(axes, x, y - 0.35, y + 0.35, side, end == BASE, end)
    else:
        machine_symbols.line(axes, [x, x], [plan.height, y + 0.12], zorder=1)
    return x


def _end(element: Element, plan: Layout, side: int) -> float:
    """End of an element above the bodies: at a stem on a body, or at a wall of its own [cm]."""
    end = element.left if side < 0 else element.right
    if end in FIXED:
        return _end(element, plan, -side) + side * element.width
    box = plan.box(end)
    return box.centre - side * STEM * box.width


def _direction(axes: Axes, values: dict[str, Any], plan: Layout, y: float) -> None:
    """The positive direction, and the motion of base."""
    x = plan.boxes[0].x
    if "base" in values:
        machine_symbols.arrow(axes, x, x + 0.6, y + BASE_CM, "base", both=True)
        machine_symbols.label(axes, x + 0.7, y + BASE_CM, f"base: {base_label(values)}", ha="left")
    turning = [machine_symbols.turns(values, name) for name in values["bodies"]]
    machine_symbols.arrow(axes, x, x + 0.8, y, bent=all(turning))
    words = "$x$ (angle)" if all(turning) else "$x$ (angle of discs)" if any(turning) else "$x$"
    machine_symbols.label(axes, x + 0.95, y, words, ha="left", fontsize=7)


# Where everything stands in the drawing of a scene, in centimetres.


LANE_CM = 1.15  # height that an element takes, with its labels
LEAST_HEIGHT_CM = 1.3
LEAST_WIDTH_CM = 1.5  # of a body
NARROW_CM = 0.5  # between bodies that nothing joins
SOURCE_CM = 0.62  # height that a force takes, with its label
MOTOR_CM = 1.25
APART_CM = 0.25  # between labels of two bodies
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
            body = _body_width(values, names[i])
            further = _room(values, boxes[-1], names[i], body) - x if boxes else 0.0
            if further > 0:
                edges[-1] = (edges[-1][0], x + further)
                x += further
            boxes.append(Box(names[i], x, body))
            x = boxes[-1].right
    return boxes, edges


def _room(values: dict[str, Any], before: Box, name: str, width: float) -> float:
    """Least left edge of a body whose labels keep clear of those of the body before [cm]."""
    apart = 0.0
    for of in (top_labels, floor_labels):
        one, other = (_widest(of(values, body)) for body in (before.name, name))
        if one and other:
            apart = max(apart, (one + other) / 2 + APART_CM)
    return before.centre + apart - width / 2


def _widest(labels: list[str]) -> float:
    return max(map(len, labels), default=0) * CHARACTER_CM


def _body_width(values: dict[str, Any], name: str) -> float:
    """Room for name and mass, and for what drives the body."""
    inside = max(len(name), len(short(values["bodies"][name]))) * 0.15 + 0.4
    inside += 2 * machine_symbols.FACE_CM if machine_symbols.turns(values, name) else 0.0
    return max(LEAST_WIDTH_CM, inside, OVERHANG * label_width(values, name))


def label_width(values: dict[str, Any], name: str) -> float:
    """Width of the longest label on top of a body or below it [cm]."""
    return _widest([*top_labels(values, name), *floor_labels(values, name)])


def top_labels(values: dict[str, Any], name: str) -> list[str]:
    """Labels above a body: its forces and rotors."""
    return [label for _, label in [*source_labels(values, name), *rotors_on(values, name)]]


def floor_labels(values: dict[str, Any], name: str) -> list[str]:
    """Labels below a body: the frictions against ground and base."""
    return [text for key, friction in floors(values, name) for text in (key, friction_label(friction))]


def _stack(values: dict[str, Any], name: str) -> float:
    """Height of motor, rotors and forces on a body [cm]."""
    rotors = MOTOR_CM * len(rotors_on(values, name))
    return rotors + SOURCE_CM * len(source_labels(values, name))
