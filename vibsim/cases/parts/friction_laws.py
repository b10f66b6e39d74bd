"""Laws of dry friction as a case writes them: the coefficients of each law, and the forces that they make."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from vibsim.cases.parts.draft import Draft, Finding

COULOMB = "coulomb"
SIDES = ("plus", "minus")  # of v_rel: keys that hold the coefficients of one direction each


@dataclass(frozen=True)
class Coefficients:
    """Keys of a law: those that it needs, and those that it may have."""

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()

    @property
    def all(self) -> tuple[str, ...]:
        return self.needed + self.optional


LAWS = {COULOMB: Coefficients(("mu",), ("static",))}
KEYS = tuple(dict.fromkeys(key for law in LAWS.values() for key in law.all))


@dataclass(frozen=True)
class Direction:
    """Friction in one direction of slip as multiples of the load, exact.

    slip : force while slipping; hold : the most that it holds
    """

    slip: Fraction
    hold: Fraction


def directions(part: dict[str, Any]) -> tuple[Direction, Direction]:
    """What the coefficients of a friction say of slip forwards and backwards."""
    forwards, backwards = (_direction(part.get(side) or part) for side in SIDES)
    return forwards, backwards


def _direction(given: dict[str, Any]) -> Direction:
    mu = given["mu"].value
    return Direction(mu, mu * (given["static"].value if "static" in given else 1))


def coefficients_fit_the_law(draft: Draft) -> Iterator[Finding]:
    """The coefficients of the law for both directions, or plus and minus with those of one each."""
    for key, part in draft.parts("friction"):
        law = LAWS.get(part.get("law", COULOMB))
        if law is not None:
            yield from _of_both(key, part, law)


def _of_both(key: str, part: dict[str, Any], law: Coefficients) -> Iterator[Finding]:
    sides = [name for name in SIDES if name in part]
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
                yield from _of_one(f"{key}.{name}", part[name], law, or_sides=False)


def _of_one(key: str, given: dict[str, Any], law: Coefficients, or_sides: bool) -> Iterator[Finding]:
    missing = [name for name in law.needed if name not in given]
    if missing:
        listed = ", ".join(f"{name}: ..." for name in law.needed)
        more = f", or plus: {{{listed}}} and minus: {{{listed}}}" if or_sides else ""
        yield Finding(key, f"needs {' and '.join(missing)}{more}", of_the_name=True)
