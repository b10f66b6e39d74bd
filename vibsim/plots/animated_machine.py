"""Layout of the moving machine: slots wide enough for the motion, gaps of stops to the scale of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from vibsim.engine.columns import part_columns
from vibsim.physics.parts import ANGLE, MOTOR, ROTOR, Scene, columns_of
from vibsim.plots import machine_symbols
from vibsim.plots.machine import LANE_CM, MOTOR_CM, Layout, layout
from vibsim.plots.machine_symbols import BASE, FIXED, GROUND, Element, floors, rotors_on
from vibsim.plots.samples import PUSHING, impact_events, period_of
from vibsim.plots.style import GREY, ORANGE, VERMILLION
from vibsim.plots.subject import PlotError, Span, Subject
from vibsim.plots.traces import states_at
from vibsim.results.columns import base_motion

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
    closing : by which the ends of each slot come closer than at rest, at the most [cm]
    """

    values: dict[str, Any]
    plan: Layout
    scale: float
    gaps: dict[str, float]
    closing: list[float] = field(default_factory=list)

    def bracket(self, element: Element, slot: int) -> float:
        """From the lips of a hook to the body that bears them [cm]: so long that the head of the rod, which
        goes further in while the ends come closer, never meets that body.
        """
        closing = self.closing[slot] if 0 <= slot < len(self.closing) else 0.0
        return NOSE_CM + max(self.gaps[element.key], 0.0) + closing

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
    closing = [scale * max(-float(each.min()), 0.0) for each in between]
    widen(plan, closing, drawn)
    return Stage(values, plan, scale, drawn, closing)


def _relative(slot: list[Element], number: int, names: list[str], motion: Ends) -> np.ndarray:
    """Elongation of a slot at each frame: distance of its ends beyond that at rest [m]."""
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
        needed = [
            _needed(each, gaps[each.key], closing[number]) for each in slot if each.kind in ("stop", "hook")
        ]
        width = max([width, *needed])
        plan.edges[number] = (x, x + width)
        x += width
        if number < len(plan.boxes):
            box = plan.boxes[number]
            plan.boxes[number] = type(box)(box.name, x, box.width)
            x += box.width


def _needed(element: Element, gap: float, closing: float) -> float:
    """Width of a slot at rest in which a stop has room for its motion [cm]; of a hook twice the closing, by
    which its lips slide along the rod and the rod along the bracket.
    """
    base = NOSE_CM + SUPPORT_CM + ROD_CM + abs(gap)
    return base + (2 * closing if element.kind == "hook" else closing)


def attached(stage: Stage, element: Element, slot: int, side: int) -> float:
    """Position of an element's left (side -1) or right (1) end at rest [cm]."""
    if slot >= 0:
        return stage.plan.edges[slot][0 if side < 0 else 1]
    name = element.left if side < 0 else element.right
    if name in FIXED:
        return attached(stage, element, slot, -side) + side * element.width
    box = stage.plan.box(name)
    return box.centre - side * 0.3 * box.width


# What moves the drawing: displacements of the ends, plates of the stops, the rotor's angle, the floor.


FLASH = 0.15  # seconds of the film that an impact is seen
SMOOTHED = 4  # periods over which a drift is taken out
MOST_FRAMES = 60_000
FLOOR, COSINE, SINE = "floor", "cosine", "sine"


@dataclass(frozen=True)
class Channels:
    """The motion of the drawing.

    Attributes
    ----------
    stage : the machine at rest
    times : of the frames (n) [s]
    names : of the channels: ends, keys of stops, FLOOR, COSINE and SINE
    values : (n, channels) [cm]; cosine and sine of the rotor's angle
    lit : which stops are in contact or were just struck, (n, stops)
    states : columns of the run at the frames, by name
    """

    stage: Stage
    times: np.ndarray
    names: list[str]
    values: np.ndarray
    lit: np.ndarray
    states: dict[str, np.ndarray]


def channels_of(subject: Subject, span: Span, step: float, speed: float) -> Channels:
    """The channels at instants `step` [s] apart.

    speed : seconds of motion per second of the film

    Raises PlotError for more than MOST_FRAMES frames.
    """
    count = int(np.floor((span[1] - span[0]) / step)) + 1
    if count > MOST_FRAMES:
        raise PlotError(f"{count} frames are too many, {MOST_FRAMES} go: show a shorter --window")
    times = np.minimum(span[0] + step * np.arange(count), subject.result.t_reached)
    scene = subject.scene
    names = (*subject.tables.states, *part_columns(scene)[: len(scene.stops)])
    states = states_at(subject.result, names, times)
    motion = {body.name: states[columns_of(body.name)[0]] for body in scene.line}
    motion[BASE] = base_motion(scene, times)[0]
    motion[GROUND] = np.zeros(count)
    if _drifts(subject):
        motion = _followed(motion, times, SMOOTHED * period_of(subject, span))
    values = subject.case.long_values()
    stage = stage_for(values, motion, {f"stops.{stop.name}": float(stop.gap) for stop in scene.stops})
    moved = {name: stage.scale * x for name, x in motion.items()}
    moved |= plates(stage, moved)
    moved |= {FLOOR: np.fmod(moved[GROUND], FLOOR_TICK_CM)}
    for name, column in angle_columns(scene).items():
        phi = states[column] if column else np.zeros(count)
        moved |= {f"{COSINE}{name}": np.cos(phi), f"{SINE}{name}": np.sin(phi)}
    lit = _lit(subject, times, states, FLASH * speed)
    order = [f"stops.{stop.name}" for stop in scene.stops]
    rows = [order.index(element.key) for element in stage.stops]
    return Channels(stage, times, list(moved), np.column_stack(list(moved.values())), lit[:, rows], states)


def angle_columns(scene: Scene) -> dict[str, str]:
    """Columns of the angles of motor and rotors by what their channels end with: nothing of a motor, which
    has channels in every scene.
    """
    rotors = {body.name: body.columns[0] or "" for body in scene.bodies if body.kind == ROTOR}
    angles = {"": rotors.pop(MOTOR, ANGLE if scene.has_motor else "")}
    return angles | {f" {name}": column for name, column in rotors.items()}


def _drifts(subject: Subject) -> bool:
    """Whether nothing holds the bodies at the ground or the base, so that they may wander off."""
    parts = (*subject.scene.links, *subject.scene.stops)
    return not any(end < 0 for part in parts for end in (part.P, part.Q))


def _followed(motion: dict[str, np.ndarray], times: np.ndarray, length: float) -> dict[str, np.ndarray]:
    """The motion as seen by an eye that follows it: less the mean of all bodies over `length` [s] about."""
    moving = [x for name, x in motion.items() if name not in (BASE, GROUND)]
    mean = np.mean(moving, axis=0)
    half = max(int(length / 2 / (times[1] - times[0])), 1) if len(times) > 1 else 1
    sums = np.concatenate([[0.0], np.cumsum(mean)])
    low, high = np.arange(len(mean)) - half, np.arange(len(mean)) + half + 1
    low, high = np.clip(low, 0, len(mean)), np.clip(high, 0, len(mean))
    smooth = (sums[high] - sums[low]) / (high - low)
    return {name: x - smooth for name, x in motion.items()}


def plates(stage: Stage, moved: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Positions [cm] of the plates of stops, and heads of hooks: free they go with the end that bears them,
    in contact with the other.
    """
    places = {}
    for element, _, slot in stage.placed:
        if element.kind not in ("stop", "hook"):
            continue
        left = attached(stage, element, slot, -1) + moved[element.left]
        right = attached(stage, element, slot, 1) + moved[element.right]
        at_rest = attached(stage, element, slot, 1) - attached(stage, element, slot, -1)
        if element.kind == "stop":  # nose of the left end, plate borne by the right one
            reach = at_rest - NOSE_CM - stage.gaps[element.key]
            places[element.key] = np.maximum(right - reach, left + NOSE_CM)
        else:  # lips of the right end, head borne by the left one
            bracket = stage.bracket(element, slot)
            reach = at_rest - bracket + stage.gaps[element.key]
            places[element.key] = np.maximum(left + reach, right - bracket)
    return places


def _lit(subject: Subject, times: np.ndarray, states: dict[str, np.ndarray], length: float) -> np.ndarray:
    """Stops in contact at each frame, or struck within `length` [s] before it."""
    stops = subject.scene.stops
    columns = part_columns(subject.scene)[: len(stops)]
    lit = np.zeros((len(times), len(stops)), dtype=bool)
    for number, name in enumerate(columns):
        lit[:, number] = np.isin(states[name], PUSHING)
    if not stops:
        return lit
    struck, part = impact_events(subject.result, (float(times[0]) - length, float(times[-1])), "part")
    for number in range(len(stops)):
        own = struck[part == number]
        last = np.searchsorted(own, times, side="right") - 1
        ago = times - own[np.maximum(last, 0)] if len(own) else np.full(len(times), np.inf)
        lit[:, number] = lit[:, number] | ((last >= 0) & (ago <= length))
    return lit


def speed_text(speed: float) -> str:
    """Speed of a film, in words."""
    if speed == 1:
        return "real time"
    return f"{1 / speed:g} times slower" if speed < 1 else f"{speed:g} times faster"


def decimals_of(times: np.ndarray) -> int:
    """Of a clock that shows another time [s] at each frame; three at least."""
    step = float(times[1] - times[0]) if len(times) > 1 else 1.0
    return max(3, -math.floor(math.log10(step)))


# A drawing whose every vertex moves along with a few channels: bodies, base, stops, rotor.
#
#     vertex = start + sum of coefficient * channel
#
# The drawing is made once with all channels at 0 and once with each at 1, and the differences are the
# coefficients. Films and pages draw from the same list.


ROUND = np.linspace(0, 2 * np.pi, 25)  # corners of a circle


@dataclass(frozen=True)
class Shape:
    """One line, area, arrow or text.

    Attributes
    ----------
    kind : "line", "area", "arrow" or "text"
    vertices : (n, 2) [cm]
    look : colour, fill, width [pt], dash, text, size [pt], align
    key : dotted key of the part that it belongs to, or empty
    """

    kind: str
    vertices: np.ndarray
    look: dict[str, Any]
    key: str = ""


@dataclass
class Recorder:
    """Takes the place of axes: what is drawn on it is kept as shapes."""

    shapes: list[Shape] = field(default_factory=list)

    def plot(self, x: Any, y: Any, gid: str | None = None, **look: Any) -> None:
        """A line through points."""
        own = {"colour": to_hex(look["color"]), "width": look["linewidth"]}
        own["dash"] = bool(look.get("linestyle"))
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        self.shapes.append(Shape("line", np.column_stack([x, y]), own, gid or ""))

    def add_patch(self, patch: Any) -> None:
        """An area with an edge."""
        look = {
            "fill": to_hex(patch.get_facecolor()) if patch.get_fill() else "",
            "colour": to_hex(patch.get_edgecolor()),
            "width": patch.get_linewidth(),
            "hatch": bool(patch.get_hatch()),
        }
        self.shapes.append(Shape("area", _corners(patch), look, patch.get_gid() or ""))

    def text(self, x: float, y: float, text: str, **look: Any) -> None:
        """A text at a point."""
        own = {name: look.get(name, "") for name in ("ha", "weight", "style")}
        own |= {"text": text, "size": look["fontsize"], "colour": to_hex(look["color"])}
        self.shapes.append(Shape("text", np.array([[x, y]], float), own))

    def annotate(self, text: str, xy: Any, xytext: Any, arrowprops: dict[str, Any], **_: Any) -> Any:
        """An arrow from a place to another."""
        look = {"colour": to_hex(arrowprops["color"]), "width": arrowprops["linewidth"]}
        look |= {"both": arrowprops["arrowstyle"].startswith("<")}
        self.shapes.append(Shape("arrow", np.array([xytext, xy], float), look))
        return _Named()


class _Named:
    def set_gid(self, gid: str | None) -> None:
        """Arrows need no name."""


def _corners(patch: Any) -> np.ndarray:
    if isinstance(patch, Circle):
        x, y = patch.center
        return np.column_stack([x + patch.radius * np.cos(ROUND), y + patch.radius * np.sin(ROUND)])
    if isinstance(patch, Polygon):
        return np.asarray(patch.get_xy())
    assert isinstance(patch, Rectangle | FancyBboxPatch)
    x, y, width, height = patch.get_x(), patch.get_y(), patch.get_width(), patch.get_height()
    return np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]])


@dataclass(frozen=True)
class Moving:
    """A shape and how it moves: coefficients (channels, n, 2) by which its vertices follow the channels."""

    shape: Shape
    coefficients: np.ndarray

    def at(self, channels: np.ndarray) -> np.ndarray:
        """Vertices (n, 2) [cm] for the values of the channels."""
        return self.shape.vertices + np.tensordot(channels, self.coefficients, axes=1)


def moving_shapes(draw: Callable[[Recorder, np.ndarray], None], count: int) -> list[Moving]:
    """The display list of what `draw` draws for the values of `count` channels, to which it is linear.

    Raises ValueError where it draws different shapes for different values.
    """
    still = _recorded(draw, np.zeros(count))
    moved = [_recorded(draw, unit) for unit in np.eye(count)]
    if any([shape.vertices.shape for shape in each] != [s.vertices.shape for s in still] for each in moved):
        raise ValueError("the drawing has different shapes for different positions")
    return [
        Moving(shape, np.array([each[i].vertices - shape.vertices for each in moved]))
        for i, shape in enumerate(still)
    ]


def _recorded(draw: Callable[[Recorder, np.ndarray], None], channels: np.ndarray) -> Sequence[Shape]:
    recorder = Recorder()
    draw(recorder, channels)
    return recorder.shapes


# The machine at given positions, drawn with the symbols of its still drawing.


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
                    machine_symbols.line(axes, [x, x], [plan.height, y + 0.12])
        _walls(axes, element, x0, x1, y)
        bracket = stage.bracket(element, slot) if element.kind == "hook" else 0.0
        _element(axes, element, x0, x1, y, at, bracket)
    for box in plan.boxes:
        shift = at[box.name]
        machine_symbols.body(axes, box.x, box.width, plan.height, stage.values, box.name, shift)
    for box in plan.boxes:
        for i, (key, _) in enumerate(rotors_on(stage.values, box.name)):
            name = "" if key == MOTOR else f" {key.partition('.')[2]}"
            angle = at[f"{COSINE}{name}"], at[f"{SINE}{name}"]
            _rotor(axes, box.centre + at[box.name], plan.height + MOTOR_CM * i, *angle, key)


def _element(
    axes: Any, element: Element, x0: float, x1: float, y: float, at: dict[str, float], bracket: float
) -> None:
    if element.kind == "stop":
        plate, nose = at[element.key], x0 + NOSE_CM
        machine_symbols.line(axes, [x0, nose], [y, y])
        machine_symbols.line(axes, [nose, nose], [y - 0.16, y + 0.16], linewidth=2 * machine_symbols.LINE)
        _plate(axes, element.key, plate, y, 0.2)
        machine_symbols.support(axes, plate, x1, y, element.law, element.key)
    elif element.kind == "hook":
        head, lips = at[element.key], x1 - bracket
        rod = ROD_CM + bracket - NOSE_CM  # so long that the lips never come to its spring
        machine_symbols.support(axes, x0, head - rod, y, element.law, element.key)
        machine_symbols.line(axes, [head - rod, head], [y, y])
        _plate(axes, element.key, head, y, 0.14)
        for side in (-1, 1):
            machine_symbols.line(axes, [lips, lips, x1], [y + side * 0.06, y + side * 0.22, y + side * 0.22])
    elif element.kind == "law":
        machine_symbols.law(axes, x0, x1, y, element.law, element.key)
    else:
        draw = {
            "spring": machine_symbols.spring,
            "damper": machine_symbols.damper,
            "clearance": machine_symbols.clearance,
            "friction": machine_symbols.pads,
        }[element.kind]
        draw(axes, x0, x1, y, element.key)
    machine_symbols.label(axes, (x0 + x1) / 2, y + 0.4, element.title.partition(":")[0], style="italic")


def _plate(axes: Any, key: str, x: float, y: float, reach: float) -> None:
    """Draw the plate of a stop, which bodies strike."""
    look = {"linewidth": 2 * machine_symbols.LINE, "color": VERMILLION}
    machine_symbols.line(axes, [x, x], [y - reach, y + reach], key, **look)


def _walls(axes: Any, element: Element, x0: float, x1: float, y: float) -> None:
    for end, x, side in ((element.left, x0, -1), (element.right, x1, 1)):
        if end in FIXED:
            machine_symbols.wall(axes, x, y - 0.4, y + 0.4, side, end == BASE, end)


def _ground(axes: Any, stage: Stage, at: dict[str, float]) -> None:
    """Draw the surfaces on which bodies rub, with marks that pass an eye that follows; a line elsewhere."""
    for box in stage.plan.boxes:
        own = floors(stage.values, box.name)
        x0, x1 = box.x - 0.9, box.right + 0.9
        if not own and machine_symbols.turns(stage.values, box.name):
            continue
        if not own:
            machine_symbols.line(axes, [x0, x1], [-0.16, -0.16], color=GREY, linewidth=0.6)
            for x in (box.x + 0.3, box.right - 0.3):
                wheel = Circle((x + at[box.name], -0.08), 0.08, fill=False, edgecolor=GREY, linewidth=0.6)
                axes.add_patch(wheel)
            continue
        machine_symbols.line(
            axes, [x0, x1], [-0.03, -0.03], f"friction.{own[0][0]}", color=ORANGE, linewidth=1.6
        )
        for k in range(int((x1 - x0) / FLOOR_TICK_CM)):
            x = x0 + k * FLOOR_TICK_CM + at[FLOOR] + FLOOR_TICK_CM
            machine_symbols.line(axes, [x, x - 0.18], [-0.05, -0.25], color=GREY, linewidth=0.6)


def _rotor(axes: Any, x: float, y: float, cosine: float, sine: float, key: str) -> None:
    """A motor, or a rotor, with its unbalanced mass at an angle."""
    centre = y + ROTOR_CM + ROTOR_ABOVE_CM
    machine_symbols.line(axes, [x - 0.22, x, x + 0.22], [y, centre, y])
    axes.add_patch(
        Circle(
            (x, centre),
            ROTOR_CM,
            facecolor="white",
            edgecolor=machine_symbols.INK,
            linewidth=machine_symbols.LINE,
        )
    )
    arm = 0.7 * ROTOR_CM
    mass = (x + arm * cosine, centre + arm * sine)
    machine_symbols.line(axes, [x, mass[0]], [centre, mass[1]], key, linewidth=1.0)
    axes.add_patch(Circle(mass, 0.09, facecolor=VERMILLION, edgecolor=machine_symbols.INK, linewidth=0.5))
