"""Rules for stops: the keys of their law, and a start that no rigid stop forbids."""

from collections.abc import Iterator
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


def starts_are_outside(draft: Draft) -> Iterator[Finding]:
    """No body starts beyond a rigid stop, whose depth is never above 0."""
    for key, part in draft.parts("stops"):
        ends, gap = Ends.read(part.get("between")), draft.quantity(f"{key}.gap")
        if part.get("law") != "rigid" or ends is None or gap is None:
            continue
        places = [_place(draft, end) for end in (ends.P, ends.Q)]
        if None in places or part.get("acts") not in ("extension", "compression"):
            continue
        ahead: Any = places[0] - places[1]
        depth = (ahead if part["acts"] == "compression" else -ahead) - gap.value
        rounding = OF_SINES if BASE in (ends.P, ends.Q) else OF_DOUBLES
        if depth > rounding * float(abs(places[0]) + abs(places[1]) + abs(gap.value)):
            message = (
                f"{ends.P} and {ends.Q} start {float(depth):.6g} m inside this rigid stop; "
                "give it a larger gap, or the bodies another initial.NAME.x"
            )
            yield Finding(f"{key}.gap", message)


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
