"""What is drawn of a scene: one element per spring, damper, stop, friction and clearance, with its labels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

GROUND, BASE = "ground", "base"
FIXED = (GROUND, BASE)
LEFT, RIGHT, ANYWHERE = -1, 1, 0
ELASTIC, DAMPED, RIGID = "elastic", "damped", "rigid"

CHARACTER_CM = 0.12  # about the width of a character of a label, at 6 pt
LABEL_DIGITS = 6
SHORTEST_CM = 1.7  # of an element, without its label


@dataclass(frozen=True)
class Element:
    """A part, or one half of a link with spring and damper, between two ends.

    Attributes
    ----------
    kind : "spring", "damper", "stop", "hook", "friction" or "clearance"; a hook is a stop that acts while its
        ends move apart
    key : dotted key of the part
    left, right : names of its ends, in the order of the drawing
    title, value : labels above and below it
    law : of a stop: ELASTIC, DAMPED or RIGID
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
        return max(least, characters * CHARACTER_CM + 0.3)


def elements(values: dict[str, Any]) -> Iterator[Element]:
    """The elements of the nested values of a case in the long form; those under bodies are left out."""
    order = {name: i for i, name in enumerate(values["bodies"])}
    for name, link in values.get("links", {}).items():
        yield from _link(f"links.{name}", name, link, order)
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
    """A quantity as it was written, but for the digits that a label has no room for."""
    number, _, unit = str(quantity).partition(" ")
    if len(number.lstrip("-0.").replace(".", "")) > LABEL_DIGITS and "/" not in number:
        number = f"{float(number):.{LABEL_DIGITS}g}"
    return " ".join(filter(None, [number, unit]))


def _link(key: str, name: str, link: dict[str, Any], order: dict[str, int]) -> Iterator[Element]:
    left, right, _ = _placed(link["between"], order, ANYWHERE)
    title = name
    for kind, letter in (("spring", "k"), ("damper", "c")):
        if link[letter].value:
            yield Element(kind, key, left, right, title, f"{letter} = {short(link[letter])}")
            title = ""
    if title:
        yield Element("spring", key, left, right, title, "k = 0")


def _stop(key: str, name: str, stop: dict[str, Any], order: dict[str, int]) -> Element:
    """P pushes to the right onto Q in compression, and draws Q after it in extension."""
    toward = RIGHT if stop["acts"] == "compression" else LEFT
    left, right, meets = _placed(stop["between"], order, toward)
    value, law = _stop_law(stop)
    kind = "stop" if meets else "hook"
    return Element(kind, key, left, right, f"{name}: gap {short(stop['gap'])}", value, law)


def _stop_law(stop: dict[str, Any]) -> tuple[str, str]:
    """Numbers of a stop, and how it is drawn."""
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
    if "mu_s" in friction:
        return f"{short(friction['mu_s'])} … {short(friction['mu_d'])}"
    static = f" (static × {short(friction['static'])})" if "static" in friction else ""
    return f"{short(friction['mu'])}{static}"


def friction_label(friction: dict[str, Any]) -> str:
    """Coefficients and load of a friction, and the velocity of its belt."""
    sides = [friction[side] for side in ("plus", "minus") if side in friction] or [friction]
    label = f"µ = {' / '.join(map(_coefficients, sides))}"
    load = f"N = {short(friction['N'])}" if "N" in friction else ""
    belt = f"belt {short(friction['belt'])}" if friction["belt"].value else ""
    return ", ".join(part for part in (label, load, belt) if part)


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


def base_label(values: dict[str, Any]) -> str:
    """The motion of base, in short."""
    return _sum_of_terms(values["base"], "a")


def motor_label(motor: dict[str, Any]) -> str:
    return f"motor: {short(motor['M0'])}, {short(motor['Omega0'])}"


def _sum_of_terms(source: dict[str, Any], amplitude: str) -> str:
    terms = [*source.get("terms", {}).values()] or ([source] if amplitude in source else [])
    constant = source.get("F0")
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
