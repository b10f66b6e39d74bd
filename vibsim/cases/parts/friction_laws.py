"""Laws of dry friction as a case writes them: the coefficients of each law, and the forces that they make."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from vibsim.cases.parts.draft import Draft, Finding
from vibsim.physics.friction_laws import EXPONENTIAL, HYPERBOLIC

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


def directions(part: dict[str, Any]) -> tuple[Direction, Direction]:
    """What the coefficients of a friction say of slip forwards and backwards."""
    of_law = DIRECTIONS[part.get("law", COULOMB)]
    forwards, backwards = (of_law(part.get(side) or part) for side in SIDES)
    return forwards, backwards


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


def coefficients_fit_the_law(draft: Draft) -> Iterator[Finding]:
    """The coefficients of the law for both directions, or plus and minus with those of one each."""
    for key, part in draft.parts("friction"):
        law = LAWS.get(part.get("law", COULOMB))
        if law is not None:
            yield from _of_both(key, part, law)


def _of_both(key: str, part: dict[str, Any], law: Coefficients) -> Iterator[Finding]:
    sides = [name for name in SIDES if name in part]
    yield from _of_other_laws(key, part, law)
    common = [name for name in law.all if name in part]
    if common and sides:
        what = f"{common[0]} holds for both directions, so {' and '.join(sides)} must be left out"
        yield Finding(f"{key}.{sides[0]}", what, of_the_name=True)
    elif not sides:
        yield from _of_one(key, part, law, or_sides=True)
    elif len(sides) == 1:
        other = "minus" if sides == ["plus"] else "plus"
        what = f"{other} is missing; a friction needs both directions, or {law.needed[0]} for both"
        yield Finding(f"{key}.{sides[0]}", what, of_the_name=True)
    else:
        for name in sides:
            if isinstance(part[name], dict):
                yield from _of_other_laws(f"{key}.{name}", part[name], law)
                yield from _of_one(f"{key}.{name}", part[name], law, or_sides=False)


def _of_other_laws(key: str, values: dict[str, Any], law: Coefficients) -> Iterator[Finding]:
    name = next(name for name, one in LAWS.items() if one is law)
    for other in KEYS:
        if other in values and other not in law.all:
            owners = " and ".join(one for one, coefficients in LAWS.items() if other in coefficients.all)
            what = f"belongs to law {owners}; {name} has {', '.join(law.all)}"
            yield Finding(f"{key}.{other}", what, of_the_name=True)


def _of_one(key: str, values: dict[str, Any], law: Coefficients, or_sides: bool) -> Iterator[Finding]:
    missing = [name for name in law.needed if name not in values]
    if missing:
        listed = ", ".join(f"{name}: ..." for name in law.needed)
        more = f", or plus: {{{listed}}} and minus: {{{listed}}}" if or_sides else ""
        *first, last = missing
        needed = f"{', '.join(first)} and {last}" if first else last
        yield Finding(key, f"needs {needed}{more}", of_the_name=True)


def friction_falls(draft: Draft) -> Iterator[Finding]:
    """mu_s >= mu_d."""
    for key, part in draft.parts("friction"):
        for side in (key, *(f"{key}.{name}" for name in SIDES if name in part)):
            static, dynamic = draft.quantity(f"{side}.mu_s"), draft.quantity(f"{side}.mu_d")
            if static is not None and dynamic is not None and static.value < dynamic.value:
                what = f"must be <= mu_s, since friction falls with speed; got {dynamic} > {static}"
                yield Finding(f"{side}.mu_d", what)
