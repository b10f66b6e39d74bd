"""Rules for stops: the keys of their law, and a start that no rigid stop forbids."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vibsim.cases.parts.draft import Draft, Finding
from vibsim.cases.parts.ends import BASE, NO_BODIES, Ends
from vibsim.cases.values.quantities import Quantity
from vibsim.physics.arithmetic import elementary

NEEDED = {"elastic": "k", "rigid": "e"}
FOREIGN = {"elastic": ("e",), "rigid": ("k", "c", "release")}
OTHER = {"elastic": "rigid", "rigid": "elastic"}
EXAMPLES = {"k": "k: 1 MN/m", "e": "e: 0.8"}
OF_SINES = 1e-12  # rounding of the place of a base [-]
OF_DOUBLES = 2.0**-52  # of places that are sums and differences of doubles: 0.1 + 0.2 and 0.3 touch [-]


def stops_have_their_law(draft: Draft) -> Iterator[Finding]:
    """An elastic stop has k, a rigid one e, and neither what is the other's."""
    for key, part in draft.parts("stops"):
        law = part.get("law", "elastic")
        if law not in NEEDED:
            continue
        foreign = [name for name in FOREIGN[law] if name in part]
        for name in foreign:
            message = f"belongs to law: {OTHER[law]}; this stop has law: {law}"
            yield Finding(f"{key}.{name}", message, of_the_name=True)
        if NEEDED[law] not in part and not foreign:
            message = f"law: {law} needs {NEEDED[law]}, for example {EXAMPLES[NEEDED[law]]}"
            yield Finding(key, message, of_the_name=True)


@dataclass(frozen=True)
class Limit:
    """What a rigid stop allows: x of the end `far` - x of the end `near` <= gap [m]."""

    stop: str  # key
    ends: Ends  # as written
    far: str
    near: str
    gap: Any

    def depth(self, places: Mapping[str, Any]) -> Any:
        """How far inside the stop its ends are at these places [m]."""
        return places[self.far] - places[self.near] - self.gap


def starts_are_outside(draft: Draft) -> Iterator[Finding]:
    """No body starts beyond a rigid stop, whose depth is never above 0."""
    limits = list(_limits(draft))
    places = {end: _place(draft, end) for limit in limits for end in (limit.far, limit.near)}
    for limit in limits:
        far, near = places[limit.far], places[limit.near]
        if far is None or near is None:
            continue
        depth = limit.depth(places)
        rounding = OF_SINES if BASE in (limit.far, limit.near) else OF_DOUBLES
        if depth <= rounding * float(abs(far) + abs(near) + abs(limit.gap)):
            continue
        lack, others = _lack_of_room(limit, limits)
        message = (
            f"leaves no room with {' and '.join(others)}: their gaps are {float(lack):.6g} m too small "
            "together; give one of them a larger gap"
            if lack > 0
            else f"{limit.ends.P} and {limit.ends.Q} start {float(depth):.6g} m inside this rigid stop; "
            "give it a larger gap, or the bodies another initial.NAME.x"
        )
        yield Finding(f"{limit.stop}.gap", message)


def _limits(draft: Draft) -> Iterator[Limit]:
    for key, part in draft.parts("stops"):
        ends, gap = Ends.read(part.get("between")), draft.quantity(f"{key}.gap")
        if part.get("law") != "rigid" or ends is None or gap is None:
            continue
        if part.get("acts") == "compression":
            yield Limit(key, ends, ends.P, ends.Q, gap.value)
        elif part.get("acts") == "extension":
            yield Limit(key, ends, ends.Q, ends.P, gap.value)


def _lack_of_room(limit: Limit, limits: Sequence[Limit]) -> tuple[Any, list[str]]:
    """By how much [m] the gap of `limit` and those of stops that close a ring of ends with it are too small
    together, wherever the bodies are, and the keys of these stops; (0, []) where there is room.
    """
    ways: dict[str, tuple[Any, list[Limit]]] = {limit.far: (limit.gap, [limit])}  # the shortest found, by end
    for _ in limits:
        for step in limits:
            if step.near not in ways:
                continue
            length, before = ways[step.near]
            there = length + step.gap
            is_new = all(step.far != one.far for one in before)  # other rings are not gone round
            if is_new and (step.far not in ways or there < ways[step.far][0]):
                ways[step.far] = there, [*before, step]
    length, ring = ways.get(limit.near, (0, []))
    return (-length, [one.stop for one in ring[1:]]) if length < 0 else (0, [])


def _place(draft: Draft, end: str) -> Any:
    """Displacement of an end at t = 0 [m]; None where that cannot be read."""
    if end == BASE:
        return _base(draft)
    if end in NO_BODIES:
        return 0
    initial = draft.section("initial", end)
    x = draft.quantity(f"initial.{end}.x")
    return 0 if "x" not in initial else None if x is None else x.value


def _base(draft: Draft) -> Any:
    """X(0), the sum of a sin(phase)."""
    base = draft.section("base")
    terms = base.get("terms")
    keys = [f"base.terms.{number}" for number in terms] if isinstance(terms, dict) else ["base"]
    total = 0.0
    for key in keys:
        a, phase = draft.quantity(f"{key}.a"), draft.quantity(f"{key}.phase")
        if a is None:
            return None
        total += a.number() * elementary.sin(phase.number()) if isinstance(phase, Quantity) else 0.0
    return total
