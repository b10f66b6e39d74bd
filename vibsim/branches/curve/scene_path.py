"""The scenes of a case over one of its numbers, made fast.

The places where the number stands in the long form of the case are found once; from then on a scene is built
with another value in these places, exact and rounded once, without the case being checked as a whole again.
So where the bodies start, which is none of an orbit's business, need not suit every value.
"""

from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

from vibsim.cases import Case, CaseError
from vibsim.cases.number import number
from vibsim.cases.parts.building import build_parts, rebuild_parts
from vibsim.cases.schema.keys import measured_at
from vibsim.cases.values.quantities import Quantity, decimal_text, parse_quantity
from vibsim.cases.values.units import UNITS, si_unit
from vibsim.physics.parts import Scene

BESIDE = Fraction(1, 2**30)  # share by which the value is changed to see where it stands
TURNS = {"angle": "turn", "angular rate": "Hz"}


class ScenePath:
    """Scenes of a case by the value of a parameter.

    keys : of the case, all of that value; unit : of the parameter
    """

    def __init__(self, case: Case, keys: Sequence[str], unit: str):
        self.keys, self.unit = tuple(keys), unit
        self._unit = UNITS[unit]
        self._measured = measured_at(self.keys[0])
        self._values = case.long_values()
        before, after = dict(leaves(self._values)), dict(leaves(self._beside(case).long_values()))
        self._places = [place for place in before if before[place] != after[place]]
        self._sections = list(dict.fromkeys(section for section, *_ in self._places))
        self._scene: Scene | None = None  # the first, whose other parts all have

    def _beside(self, case: Case) -> Case:
        """The case with the parameter a little changed."""
        own, dimension = case.quantity(self.keys[0]), self._dimension
        unit = TURNS[dimension] if own.per_turn else si_unit(dimension).name
        for share in (BESIDE, -BESIDE):
            value = own.value * (1 + share) if own.value else share
            try:
                return case.with_values(dict.fromkeys(self.keys, f"{decimal_text(value)} {unit}".strip()))
            except CaseError as error:
                refused = error
        raise refused

    @property
    def _dimension(self) -> str:
        return self._measured.dimension if self._measured else "number"

    def scene(self, value: float) -> Scene:
        """The scene at a value. Raises ValueError where the key does not allow it."""
        quantity = self._quantity(float(value))
        broken = self._measured.broken_bound(quantity.value) if self._measured else None
        if broken:
            raise ValueError(f"{self.keys[0]} must be {broken}, got {number(value, 6)} {self.unit}".rstrip())
        values, scene = self._values, self._scene
        for place in self._places:
            values = replaced(values, place, quantity)
        if scene is None:
            scene = self._scene = build_parts(values)
            return scene
        for section in self._sections:
            scene = rebuild_parts(scene, values, section)
        return scene

    def _quantity(self, value: float) -> Quantity:
        """What `parse_quantity` reads from a value and the unit, faster for ordinary numbers."""
        if not 1e-200 < abs(value) < 1e200:
            return parse_quantity(f"{value!r} {self.unit}".strip(), self._dimension)
        text, unit = repr(value), self._unit
        exact = Fraction(*Decimal(text).as_integer_ratio())
        in_si = exact if unit.factor == 1 else exact * unit.factor
        return Quantity(f"{text} {unit.name}".strip(), in_si, unit.per_turn)


def leaves(values: Mapping[str, Any], place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """(path, value) of every value of nested values."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from leaves(value, (*place, name))
        else:
            yield (*place, name), value


def replaced(values: Mapping[str, Any], place: tuple[str, ...], quantity: Quantity) -> dict[str, Any]:
    """Nested values with one of them replaced."""
    name, *inner = place
    new = replaced(values[name], tuple(inner), quantity) if inner else quantity
    return {**values, name: new}
