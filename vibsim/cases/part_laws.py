"""Laws of dry friction and of stops as a case writes them: coefficients, and the forces that they make."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from vibsim.cases.quantities import Quantity
from vibsim.cases.schema_kinds import has_formula, sides_of
from vibsim.cases.short_form import BASE, NO_BODIES, Draft, Ends, FoundDefault
from vibsim.physics import elementary
from vibsim.physics.elementary import two_pi_fraction
from vibsim.physics.parts import EXPONENTIAL, HYPERBOLIC

COULOMB = "coulomb"
SIDES = ("plus", "minus")  # of v_rel: keys that hold the coefficients of one direction each


class Coefficients(NamedTuple):
    """Keys of a law: those that it needs, and those that it may have."""

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()

    @property
    def all(self) -> tuple[str, ...]:
        return self.needed + self.optional


LAWS = {
    COULOMB: Coefficients(("mu",), ("static",)),
    HYPERBOLIC: Coefficients(("mu_s", "mu_d", "d")),
    EXPONENTIAL: Coefficients(("mu_s", "mu_d", "v0")),
}
KEYS = tuple(dict.fromkeys(key for law in LAWS.values() for key in law.all))


class Direction(NamedTuple):
    """Friction in one direction of slip, exact; forces as multiples of the load.

    slip : what slips at all speeds; hold : the most that it holds; drop, rate : of what falls with speed, s/m
    """

    slip: Fraction
    hold: Fraction
    drop: Fraction = Fraction(0)
    rate: Fraction = Fraction(0)

    @property
    def start(self) -> Fraction:
        """The coefficient of friction with which slip begins."""
        return self.slip + self.drop


def directions(part: dict[str, Any]) -> tuple[Direction, Direction]:
    """Friction coefficients of a part for slip forwards and backwards."""
    of_law = DIRECTIONS[part.get("law", COULOMB)]
    forwards, backwards = (of_law(part.get(side) or part) for side in SIDES)
    return forwards, backwards


def falls(part: dict[str, Any]) -> bool:
    """Whether a friction falls with the speed of slip by a built-in law, in one direction at least."""
    return part.get("law", COULOMB) != COULOMB and any(side.drop for side in directions(part))


def _coulomb(values: dict[str, Any]) -> Direction:
    mu = values["mu"].value
    return Direction(mu, mu * (values["static"].value if "static" in values else 1))


def _falling(mu_s: Fraction, mu_d: Fraction, rate: Fraction) -> Direction:
    """mu_d + (mu_s - mu_d) f(rate |v|); where nothing falls, mu_s at all speeds."""
    if mu_s == mu_d or rate == 0:
        return Direction(mu_s, mu_s)
    return Direction(mu_d, mu_s, mu_s - mu_d, rate)


def _hyperbolic(values: dict[str, Any]) -> Direction:
    return _falling(values["mu_s"].value, values["mu_d"].value, values["d"].value)


def _exponential(values: dict[str, Any]) -> Direction:
    return _falling(values["mu_s"].value, values["mu_d"].value, 1 / values["v0"].value)


DIRECTIONS = {COULOMB: _coulomb, HYPERBOLIC: _hyperbolic, EXPONENTIAL: _exponential}


def coefficients_fit_the_law(draft: Draft) -> Iterator[FoundDefault]:
    """The coefficients of the law for both directions, or plus and minus with those of one each."""
    for key, part in draft.parts("friction"):
        law = LAWS.get(part.get("law", COULOMB))
        if has_formula("friction", part, "mu"):
            yield from _with_sides(key, part)
        elif law is not None:
            yield from _of_both(key, part, law)


def _with_sides(key: str, part: dict[str, Any]) -> Iterator[FoundDefault]:
    """A formula of mu holds for both directions."""
    sides = [name for name in SIDES if name in part]
    if sides:
        what = f"mu holds for both directions, so {' and '.join(sides)} must be left out"
        yield FoundDefault(f"{key}.{sides[0]}", what, of_the_name=True)


def _of_both(key: str, part: dict[str, Any], law: Coefficients) -> Iterator[FoundDefault]:
    sides = [name for name in SIDES if name in part]
    formulas = sides_of("friction", part)
    if formulas and "law" in part:
        what = f"names a built-in law, and {next(iter(formulas))}.mu is a formula; leave one of them out"
        yield FoundDefault(f"{key}.law", what, of_the_name=True)
    yield from _of_other_laws(key, part, law)
    common = [name for name in law.all if name in part]
    if common and sides:
        what = f"{common[0]} holds for both directions, so {' and '.join(sides)} must be left out"
        yield FoundDefault(f"{key}.{sides[0]}", what, of_the_name=True)
    elif not sides:
        yield from _of_one(key, part, law, or_sides=True)
    elif len(sides) == 1:
        other = "minus" if sides == ["plus"] else "plus"
        what = f"{other} is missing; a friction needs both directions, or {law.needed[0]} for both"
        yield FoundDefault(f"{key}.{sides[0]}", what, of_the_name=True)
    else:
        for name in sides:
            if isinstance(part[name], dict) and name not in formulas:
                yield from _of_other_laws(f"{key}.{name}", part[name], law)
                yield from _of_one(f"{key}.{name}", part[name], law, or_sides=False)


def _of_other_laws(key: str, values: dict[str, Any], law: Coefficients) -> Iterator[FoundDefault]:
    name = next(name for name, one in LAWS.items() if one is law)
    for other in KEYS:
        if other in values and other not in law.all:
            owners = " and ".join(one for one, coefficients in LAWS.items() if other in coefficients.all)
            what = f"belongs to law {owners}; {name} has {', '.join(law.all)}"
            yield FoundDefault(f"{key}.{other}", what, of_the_name=True)


def _of_one(key: str, values: dict[str, Any], law: Coefficients, or_sides: bool) -> Iterator[FoundDefault]:
    missing = [name for name in law.needed if name not in values]
    if missing:
        listed = ", ".join(f"{name}: ..." for name in law.needed)
        more = f", or plus: {{{listed}}} and minus: {{{listed}}}" if or_sides else ""
        *first, last = missing
        needed = f"{', '.join(first)} and {last}" if first else last
        yield FoundDefault(key, f"needs {needed}{more}", of_the_name=True)


def friction_falls(draft: Draft) -> Iterator[FoundDefault]:
    """mu_s >= mu_d."""
    for key, part in draft.parts("friction"):
        formulas = sides_of("friction", part)
        if has_formula("friction", part, "mu"):
            continue
        for side in (key, *(f"{key}.{name}" for name in SIDES if name in part and name not in formulas)):
            static, dynamic = draft.quantity(f"{side}.mu_s"), draft.quantity(f"{side}.mu_d")
            if static is not None and dynamic is not None and static.value < dynamic.value:
                what = f"must be <= mu_s, since friction falls with speed; got {dynamic} > {static}"
                yield FoundDefault(f"{side}.mu_d", what)


# Rules for stops: the keys of their law, and a start that no rigid stop forbids.


NEEDED = {"elastic": "k", "rigid": "e"}
FOREIGN = {"elastic": ("e",), "rigid": ("k", "c", "release")}
OTHER = {"elastic": "rigid", "rigid": "elastic"}
EXAMPLES = {"k": "k: 1 MN/m", "e": "e: 0.8"}
OF_SINES = 1e-12  # rounding of the place of a base [-]
OF_DOUBLES = 2.0**-52  # of places that are sums and differences of doubles: 0.1 + 0.2 and 0.3 touch [-]


def stops_have_their_law(draft: Draft) -> Iterator[FoundDefault]:
    """An elastic stop has k, a rigid one e, and neither what is the other's."""
    for key, part in draft.parts("stops"):
        law = part.get("law", "elastic")
        if law not in NEEDED or "force" in part:
            continue
        foreign = [name for name in FOREIGN[law] if name in part]
        for name in foreign:
            message = f"belongs to law: {OTHER[law]}; this stop has law: {law}"
            yield FoundDefault(f"{key}.{name}", message, of_the_name=True)
        if NEEDED[law] not in part and not foreign:
            message = f"law: {law} needs {NEEDED[law]}, for example {EXAMPLES[NEEDED[law]]}"
            yield FoundDefault(key, message, of_the_name=True)


@dataclass(frozen=True)
class LimitKeys:
    """Keys of a rigid stop: x of the end `far` - x of the end `near` <= gap [m]."""

    stop: str  # key
    ends: Ends  # as written
    far: str
    near: str
    gap: Any

    def depth(self, places: Mapping[str, Any]) -> Any:
        """How far inside the stop its ends are at these places [m]."""
        return places[self.far] - places[self.near] - self.gap


def starts_are_outside(draft: Draft) -> Iterator[FoundDefault]:
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
        yield FoundDefault(f"{limit.stop}.gap", message)


def _limits(draft: Draft) -> Iterator[LimitKeys]:
    for key, part in draft.parts("stops"):
        ends, gap = Ends.read(part.get("between")), draft.quantity(f"{key}.gap")
        if part.get("law") != "rigid" or ends is None or gap is None:
            continue
        if part.get("acts") == "compression":
            yield LimitKeys(key, ends, ends.P, ends.Q, _size(gap))
        elif part.get("acts") == "extension":
            yield LimitKeys(key, ends, ends.Q, ends.P, _size(gap))


def _lack_of_room(limit: LimitKeys, limits: Sequence[LimitKeys]) -> tuple[Any, list[str]]:
    """By how much [m] the gap of `limit` and those of stops that close a ring of ends with it are too small
    together, wherever the bodies are, and the keys of these stops; (0, []) where there is room.
    """
    ways: dict[str, tuple[Any, list[LimitKeys]]] = {
        limit.far: (limit.gap, [limit])
    }  # the shortest found, by end
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
    return 0 if "x" not in initial else None if x is None else _size(x)


def _size(quantity: Quantity) -> Fraction:
    """A place in SI units: exact, but for turns, which pi makes a number of many digits."""
    return quantity.value * two_pi_fraction(60) ** int(quantity.per_turn)


def _base(draft: Draft) -> Any:
    """X(0), the sum of a sin(phase)."""
    base = draft.section("base")
    if "x" in base:
        return _base_formula(draft)
    terms = base.get("terms")
    keys = [f"base.terms.{number}" for number in terms] if isinstance(terms, dict) else ["base"]
    total = 0.0
    for key in keys:
        a, phase = draft.quantity(f"{key}.a"), draft.quantity(f"{key}.phase")
        if a is None:
            return None
        total += a.number() * elementary.sin(phase.number()) if isinstance(phase, Quantity) else 0.0
    return total


def _base_formula(draft: Draft) -> float | None:
    """X(0) of a formula; None where it has no value."""
    from vibsim.cases.formula_places import FormulaScene, Unreadable, places_of
    from vibsim.cases.formula_text import FormulaError
    from vibsim.physics.formula_values import size_of

    place = next(one for one in places_of({"base": draft.section("base")}))
    try:
        return size_of(FormulaScene(draft.values).node(place))
    except (FormulaError, Unreadable):
        return None
