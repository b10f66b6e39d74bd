"""Symbols of a machine drawing: springs, dampers, stops, frictions and clearances, with their labels."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from vibsim.cases.problems import one_line
from vibsim.cases.quantities import is_inertia
from vibsim.cases.schema_kinds import Formula
from vibsim.plots.style import BLUE, GREEN, GREY, ORANGE, VERMILLION

GROUND, BASE = "ground", "base"
FIXED = (GROUND, BASE)
LEFT, RIGHT, ANYWHERE = -1, 1, 0
ELASTIC, DAMPED, RIGID, NONLINEAR = "elastic", "damped", "rigid", "nonlinear"
VARIABLE = re.compile("d|v|p|t|(?:x|v|phi|w)_.*|phi|phidot")  # of the motion, that a law may read

CHARACTER_CM = 0.12  # about the width of a character of a label, at 6 pt
LABEL_DIGITS = 6
MOST_ARGUMENTS = 3
RAISED = str.maketrans({"^": "", "2": "\N{SUPERSCRIPT TWO}", "3": "\N{SUPERSCRIPT THREE}"})  # of units
LONGEST_FORMULA = 30  # characters of a formula that a label shows
STUB_CM = 0.45  # on either side of the box of a formula
SHORTEST_CM = 1.7  # of an element, without its label


@dataclass(frozen=True)
class Element:
    """A part, or one half of a link with spring and damper, between two ends.

    Attributes
    ----------
    kind : "spring", "damper", "law" (a formula), "stop", "hook", "friction" or "clearance"; a hook is a stop
        that acts while its ends move apart
    key : dotted key of the part
    left, right : names of its ends, in the order of the drawing
    title, value : labels above and below it
    law : of a stop: ELASTIC, DAMPED, RIGID or NONLINEAR (a formula); of a formula what it reads, as f(d, v)
    """

    kind: str
    key: str
    left: str
    right: str
    title: str
    value: str = ""
    law: str = ""

    @property
    def width(self) -> float:
        """The least width with room for the labels [cm]."""
        characters = max(len(self.title), len(self.value))
        least = {"stop": 2.3, "hook": 2.7}.get(self.kind, SHORTEST_CM)
        if self.kind == "law":
            least = len(self.law) * CHARACTER_CM + 2 * STUB_CM
        return max(least, characters * CHARACTER_CM + 0.3)


def elements(values: dict[str, Any]) -> Iterator[Element]:
    """The elements of the nested values of a case in the long form; those under bodies are left out."""
    order = {name: i for i, name in enumerate(values["bodies"])}
    for name, link in values.get("links", {}).items():
        yield from _link(f"links.{name}", name, link, order, tuple(values.get("states", {})))
    for name, stop in values.get("stops", {}).items():
        yield _stop(f"stops.{name}", name, stop, order)
    for name, friction in values.get("friction", {}).items():
        ends = friction["between"]
        if not {ends.P, ends.Q} & set(FIXED):
            left, right, _ = _placed(ends, order, ANYWHERE)
            yield Element("friction", f"friction.{name}", left, right, name, friction_label(friction))
    for name, clearance in values.get("clearances", {}).items():
        left, right, _ = _placed(clearance["between"], order, RIGHT)
        limit = f"at most {short(clearance['distance'])}"
        yield Element("clearance", f"clearances.{name}", left, right, name, limit)


def short(quantity: Any) -> str:
    """A quantity as it was written, but for digits that a label has no room for; a formula, or its begin."""
    if isinstance(quantity, Formula):
        text = one_line(quantity.text)
        return text if len(text) <= LONGEST_FORMULA else f"{text[: LONGEST_FORMULA - 1]}…"
    number, _, unit = str(quantity).partition(" ")
    unit = unit.translate(RAISED) if "^" in unit else unit
    if len(number.lstrip("-0.").replace(".", "")) > LABEL_DIGITS and "/" not in number:
        number = f"{float(number):.{LABEL_DIGITS}g}"
    return " ".join(filter(None, [number, unit]))


def _link(
    key: str, name: str, link: dict[str, Any], order: dict[str, int], states: tuple[str, ...]
) -> Iterator[Element]:
    left, right, _ = _placed(link["between"], order, ANYWHERE)
    if "force" in link:
        yield Element("law", key, left, right, name, short(link["force"]), arguments(link["force"], states))
        return
    title = name
    for kind, letter in (("spring", "k"), ("damper", "c")):
        if link[letter].value:
            yield Element(kind, key, left, right, title, f"{letter} = {short(link[letter])}")
            title = ""
    if title:
        yield Element("spring", key, left, right, title, "k = 0")


def arguments(formula: Formula, states: tuple[str, ...] = ()) -> str:
    """A formula as a function of what it reads of the motion, of time and of further states: f(d, v)."""
    words = re.findall(r"[A-Za-z_]\w*", one_line(formula.text))
    names = dict.fromkeys(word for word in words if VARIABLE.fullmatch(word) or word in states)
    if len(names) > MOST_ARGUMENTS:
        names = dict.fromkeys([*list(names)[: MOST_ARGUMENTS - 1], "…"])
    return f"f({', '.join(names)})" if names else "f"


def _stop(key: str, name: str, stop: dict[str, Any], order: dict[str, int]) -> Element:
    """P pushes to the right onto Q in compression, and draws Q after it in extension."""
    toward = RIGHT if stop["acts"] == "compression" else LEFT
    left, right, meets = _placed(stop["between"], order, toward)
    value, law = _stop_law(stop)
    kind = "stop" if meets else "hook"
    return Element(kind, key, left, right, f"{name}: gap {short(stop['gap'])}", value, law)


def _stop_law(stop: dict[str, Any]) -> tuple[str, str]:
    """Numbers of a stop, or its formula, and how it is drawn."""
    if "force" in stop:
        return short(stop["force"]), NONLINEAR
    if stop["law"] == RIGID:
        return f"rigid, e = {short(stop['e'])}", RIGID
    if stop["c"].value:
        return f"k = {short(stop['k'])}, c = {short(stop['c'])}", DAMPED
    return f"k = {short(stop['k'])}", ELASTIC


def _placed(ends: Any, order: dict[str, int], toward: int) -> tuple[str, str, bool]:
    """(left end, right end, whether P meets Q there): what does not move stands where a stop is met.

    toward : direction in which P moves onto Q; ANYWHERE for what works both ways.
    """
    if ends.Q in FIXED:
        left_side = order[ends.P] == 0 if toward == ANYWHERE else toward == LEFT
        return (ends.Q, ends.P, True) if left_side else (ends.P, ends.Q, True)
    if ends.P in FIXED:
        left_side = order[ends.Q] == 0 if toward == ANYWHERE else toward == RIGHT
        return (ends.P, ends.Q, True) if left_side else (ends.Q, ends.P, True)
    in_order = order[ends.P] < order[ends.Q]
    left, right = (ends.P, ends.Q) if in_order else (ends.Q, ends.P)
    return left, right, in_order == (toward == RIGHT)


def _coefficients(friction: dict[str, Any]) -> str:
    """The coefficient while slipping, or those at rest and at high speed."""
    if "mu_s" in friction and not isinstance(friction.get("mu"), Formula):
        return f"{short(friction['mu_s'])} … {short(friction['mu_d'])}"
    static = f" (static × {short(friction['static'])})" if "static" in friction else ""
    return f"{short(friction['mu'])}{static}"


def friction_label(friction: dict[str, Any]) -> str:
    """Coefficients and load of a friction, and the velocity of its belt."""
    sides = [friction[side] for side in ("plus", "minus") if side in friction] or [friction]
    label = f"µ = {' / '.join(map(_coefficients, sides))}"
    load = f"N = {short(friction['N'])}" if "N" in friction else ""
    belt = f"belt {short(friction['belt'])}" if belt_speed(friction) else ""
    return ", ".join(part for part in (label, load, belt) if part)


def belt_speed(friction: dict[str, Any]) -> Any:
    """Speed of the belt of a friction; 1 where it is a formula."""
    return 1 if isinstance(friction["belt"], Formula) else friction["belt"].value


def floors(values: dict[str, Any], body: str = "") -> list[tuple[str, dict[str, Any]]]:
    """(name, friction) of those against ground and base, of all bodies or of one."""
    return [
        (name, friction)
        for name, friction in values.get("friction", {}).items()
        if {friction["between"].P, friction["between"].Q} & set(FIXED)
        and (not body or body in (friction["between"].P, friction["between"].Q))
    ]


def source_labels(values: dict[str, Any], body: str) -> list[tuple[str, str]]:
    """(dotted key, label) of each force on a body."""
    return [
        (f"forces.{name}", f"{name}: {_sum_of_terms(force, 'A')}")
        for name, force in values.get("forces", {}).items()
        if force["on"] == body
    ]


def ways_of(force: dict[str, Any]) -> tuple[bool, bool]:
    """Whether a force points against x at some time, and whether along it; a formula may do both."""
    if isinstance(force.get("force"), Formula):
        return True, True
    terms = [*force.get("terms", {}).values()] or ([force] if "A" in force else [])
    sizes = [term["A"] for term in terms]
    constant = force.get("F0")
    if any(isinstance(size, dict | Formula) for size in sizes) or isinstance(constant, Formula):
        return True, True
    reach = sum(abs(size.value) for size in sizes)
    middle = 0 if constant is None else constant.value
    against = middle - reach < 0
    return against, middle + reach > 0 or not against


def base_label(values: dict[str, Any]) -> str:
    """The motion of base, in short."""
    return _sum_of_terms(values["base"], "a")


def rotors_on(values: dict[str, Any], body: str) -> list[tuple[str, str]]:
    """(dotted key, label) of the motor and of each rotor on a body."""
    motor = values.get("motor", {})
    listed = [("motor", _rotor_label("motor", motor))] if motor.get("on") == body else []
    rotors = values.get("rotors", {}).items()
    return listed + [(f"rotors.{name}", _rotor_label(name, one)) for name, one in rotors if one["on"] == body]


def _rotor_label(name: str, rotor: dict[str, Any]) -> str:
    """A rotor and its torque: a formula, torque at standstill and speed without load, or none."""
    laws = (
        [rotor["torque"]] if "torque" in rotor else [rotor[key] for key in ("M0", "Omega0") if key in rotor]
    )
    return f"{name}: {', '.join(map(short, laws))}" if laws else name


def _sum_of_terms(source: dict[str, Any], amplitude: str) -> str:
    formula = source.get("force", source.get("x"))
    if isinstance(formula, Formula):
        return short(formula)
    terms = [*source.get("terms", {}).values()] or ([source] if amplitude in source else [])
    constant = source.get("F0")
    if constant is not None and len(terms) > 0:  # a term of no size says nothing beside a constant
        terms = [term for term in terms if getattr(term[amplitude], "value", 1)]
    parts = [short(constant)] if constant is not None and (constant.value or not terms) else []
    if len(terms) > 2:
        parts.append(f"{len(terms)} harmonics")
    else:
        parts += [_term(term, amplitude) for term in terms]
    return " + ".join(parts)


def _term(term: dict[str, Any], amplitude: str) -> str:
    size = term[amplitude]
    text = "m3 e ω²" if isinstance(size, dict) else short(size)
    phase = f" ({short(term['phase'])})" if term["phase"].value else ""
    return f"{text} at {short(term['omega'])}{phase}"


# Symbols of mechanics: spring, dashpot, stop, wall, floor, belt, pads, arrows. Lengths in centimetres.


INK = "0.15"
LINE = 0.8  # width of lines [pt]
SMALL = 6  # size of labels [pt]
COILS = 5
FORCE_CM = 0.45  # half the length of the arrow of a force
BENT, BENT_CM = 0.3, 0.1  # by which the arrow of a torque is bent, and stands lower [cm]
LAW_CM = 0.32  # height of the box of a formula
FACE_CM = 0.16  # half the width of the face of a disc, which is seen from its side
HALF = 24  # sides of half of its rim
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


def turns(values: dict[str, Any], name: str) -> bool:
    """Whether a body is a disc that turns: its mass is a moment of inertia."""
    return is_inertia(str(values["bodies"][name]))


def body(
    axes: Axes, x: float, width: float, height: float, values: dict[str, Any], name: str, shift: float = 0.0
) -> None:
    """A box with name and mass, or a disc with its inertia; shift : to the right [cm]."""
    x += shift
    look: dict[str, Any] = {
        "facecolor": "0.93",
        "edgecolor": INK,
        "linewidth": LINE,
        "gid": f"bodies.{name}",
        "zorder": 3,
    }
    if turns(values, name):
        face = x + width - FACE_CM
        far, near = _rim(x + FACE_CM, height), _rim(face, height)
        axes.add_patch(Polygon(np.concatenate([far[HALF:], near[: HALF + 1]]), **look))
        axes.add_patch(Polygon(near, fill=False, edgecolor=INK, linewidth=0.6 * LINE, zorder=3))
        width -= 2 * FACE_CM
    else:
        style = "round,pad=0,rounding_size=0.08"
        axes.add_patch(FancyBboxPatch((x, 0), width, height, boxstyle=style, **look))
    label(axes, x + width / 2, height / 2 + 0.16, name, fontsize=7.5, weight="bold", zorder=4)
    label(axes, x + width / 2, height / 2 - 0.2, short(values["bodies"][name]), zorder=4)


def _rim(x: float, height: float) -> np.ndarray:
    """Points (n, 2) of a rim of a disc [cm]: from below over its right half upwards, and back."""
    angles = np.linspace(-np.pi / 2, 3 * np.pi / 2, 2 * HALF + 1)
    return np.column_stack([x + FACE_CM * np.cos(angles), height / 2 * (1 + np.sin(angles))])


def spring(axes: Axes, x0: float, x1: float, y: float, gid: str = "") -> None:
    """A coil, with a straight end on either side."""
    end = 0.16 * (x1 - x0)
    inner = np.linspace(x0 + end, x1 - end, 2 * COILS + 2)
    swing = np.array([0, *[0.14 * (-1) ** i for i in range(2 * COILS)], 0])
    line(axes, [x0, *inner, x1], y + np.array([0, *swing, 0]), gid, color=BLUE)


def law(axes: Axes, x0: float, x1: float, y: float, words: str, gid: str = "") -> None:
    """A force by a formula: a box that says what it reads, between two straight ends."""
    middle, half = (x0 + x1) / 2, len(words) * CHARACTER_CM / 2
    line(axes, [x0, middle - half], [y, y], gid, color=BLUE)
    line(axes, [middle + half, x1], [y, y], color=BLUE)
    corner = (middle - half, y - LAW_CM / 2)
    axes.add_patch(
        Rectangle(corner, 2 * half, LAW_CM, facecolor="white", edgecolor=BLUE, linewidth=LINE, gid=gid)
    )
    label(axes, middle, y, words)


def damper(axes: Axes, x0: float, x1: float, y: float, gid: str = "") -> None:
    """A dashpot: piston in an open cylinder."""
    a, b = x0 + 0.38 * (x1 - x0), x0 + 0.62 * (x1 - x0)
    middle = (a + b) / 2
    line(axes, [x0, a], [y, y], gid, color=GREEN)
    line(axes, [b, a, a, b], [y + 0.15, y + 0.15, y - 0.15, y - 0.15], color=GREEN)
    line(axes, [middle, middle], [y + 0.1, y - 0.1], color=GREEN)
    line(axes, [middle, x1], [y, y], color=GREEN)


def support(axes: Axes, x0: float, x1: float, y: float, law: str, gid: str = "") -> None:
    """Draw the support of a stop: a spring, with a dashpot if it is damped; a bar if it is rigid."""
    if law == RIGID:
        line(axes, [x0, x1], [y, y], gid, color=VERMILLION, linewidth=3 * LINE)
        return
    if law != DAMPED:
        coil(axes, x0, x1, y, gid)
        if law == NONLINEAR:  # an oblique stroke, as over what can be varied
            middle, reach = (x0 + x1) / 2, min(0.22, 0.3 * (x1 - x0))
            line(axes, [middle - reach, middle + reach], [y - 0.2, y + 0.2], color=VERMILLION)
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
    """Draw the ground (hatched) or a base that moves (grey), left (side -1) or right (1) of x."""
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


def force_arrow(
    axes: Axes, middle: float, y: float, ways: tuple[bool, bool], gid: str, torque: bool = False
) -> None:
    """The ways that a force or a torque points, against x and along it."""
    against, along = ways
    reach = -FORCE_CM if against and not along else FORCE_CM
    y -= BENT_CM if torque else 0.0
    arrow(axes, middle - reach, middle + reach, y, gid, both=against and along, bent=torque)


def arrow(
    axes: Axes, x0: float, x1: float, y: float, gid: str = "", both: bool = False, bent: bool = False
) -> None:
    """An arrow from x0 to x1, or with heads at both ends; bent : as of a torque."""
    look = {"linewidth": LINE, "color": INK, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}
    style = {"arrowstyle": "<|-|>" if both else "-|>"}
    if bent:
        style["connectionstyle"] = f"arc3,rad={-BENT if x1 > x0 else BENT}"
    note = axes.annotate("", (x1, y), (x0, y), arrowprops={**style, **look}, annotation_clip=False)
    note.set_gid(gid or None)


def rotor(axes: Axes, x: float, y: float, gid: str = "motor") -> None:
    """A motor, or a rotor, with an unbalanced mass, on what it stands on at y."""
    radius = 0.36
    centre = y + radius + 0.12
    line(axes, [x - 0.22, x, x + 0.22], [y, centre, y], zorder=2)
    axes.add_patch(Circle((x, centre), radius, facecolor="white", edgecolor=INK, linewidth=LINE, gid=gid))
    line(axes, [x, x + 0.2], [centre, centre + 0.16], linewidth=0.6)
    axes.add_patch(
        Circle((x + 0.2, centre + 0.16), 0.075, facecolor=VERMILLION, edgecolor=INK, linewidth=0.5)
    )
    axes.add_patch(Circle((x, centre), 0.035, facecolor=INK, edgecolor=INK))
