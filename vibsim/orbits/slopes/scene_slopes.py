"""The scene of a case with the derivatives of all its numbers by some numbers of the case.

A number of the case may stand in several places, multiplied with others and rounded once. Exact scenes, in
fractions, for the case and for one a share of 1e-40 beside it give the derivatives to 40 digits.
"""

from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.orbits.errors import OrbitError
from vibsim.physics.arithmetic.sloped_numbers import Sloped
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.cases import Case

SHARE = Fraction(1, 10**40)  # of the number, or of its unit where it is 0


def sloped_scene(case: "Case", keys: Sequence[str]) -> Scene[Any]:
    """The scene whose numbers carry derivatives by the numbers of `keys`, per SI unit (rad/s for rates).

    Raises OrbitError for a number that cannot be changed without adding or removing a part, and what
    `Case.quantity` raises for keys.
    """
    exact, sides, shifts = case.exact_scene(Fraction), [], []
    for key in keys:
        beside, shift = _beside(case, key)
        sides.append(beside.exact_scene(Fraction))
        shifts.append(shift)
        if not _same_parts(exact, sides[-1]):
            raise OrbitError(f"{key} is where a part comes or goes, so the motion has no derivative by it")
    sloped: Scene[Any] = _joined(case.scene(), exact, sides, shifts)
    return sloped


def _beside(case: "Case", key: str) -> tuple["Case", Fraction | float]:
    """The case with one number a little changed, and by how much in SI units."""
    from vibsim.cases import CaseError
    from vibsim.cases.schema.keys import measured_at
    from vibsim.cases.values.quantities import decimal_text
    from vibsim.cases.values.units import si_unit

    own, measured = case.quantity(key), measured_at(case.full_key(key))
    dimension = measured.dimension if measured else "number"
    unit = {"angle": "turn", "angular rate": "Hz"}[dimension] if own.per_turn else si_unit(dimension).name
    for share in (SHARE, -SHARE):
        value = own.value * (1 + share) if own.value else share
        try:
            beside = case.with_values({key: f"{decimal_text(value)} {unit}".strip()})
        except CaseError as error:
            refused = error
            continue
        shift = value - own.value
        return beside, shift * Fraction(2 * pi) if own.per_turn else shift
    raise refused


def _same_parts(one: Any, other: Any) -> bool:
    if is_dataclass(one):
        pairs = ((getattr(one, each.name), getattr(other, each.name, None)) for each in fields(one))
        return type(one) is type(other) and all(_same_parts(*pair) for pair in pairs)
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(_same_parts, one, other))
    return (one is None) == (other is None)


def _joined(part: Any, exact: Any, sides: Sequence[Any], shifts: Sequence[Any]) -> Any:
    """A part of a scene, its numbers with their derivatives where these are not all 0."""
    if is_dataclass(part) and not isinstance(part, type):
        values = {
            each.name: _joined(
                getattr(part, each.name),
                getattr(exact, each.name),
                [getattr(side, each.name) for side in sides],
                shifts,
            )
            for each in fields(part)
        }
        return replace(part, **values)
    if isinstance(part, tuple):
        rows = zip(part, exact, *sides, strict=True)
        return tuple(_joined(one, there, besides, shifts) for one, there, *besides in rows)
    if not isinstance(part, float):
        return part
    slopes = [float((side - exact) / shift) for side, shift in zip(sides, shifts, strict=True)]
    return Sloped(part, np.array(slopes)) if any(slopes) else part
