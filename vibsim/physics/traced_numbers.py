"""Numbers that record how they come about, so that the same operations can be repeated on other doubles.

What is written for all number types leaves behind, on some numbers to begin with, the list of its operations
and of the comparisons that it went by. On other doubles for these the operations give the very bits that the
whole would give, as long as the comparisons fall out the same. Numbers are doubles, and in formulas exact
fractions. Where they are keys, as within formulas, those that were equal have to be so again, and no others.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

from vibsim.physics.numbers import Doubles

Operation = Callable[[Any, Any], Any]
Step = tuple[Operation, int, int]  # what is done, and the places of its two numbers

SMALL = 64  # whole numbers in formulas that no case has written


class NotRecorded(TypeError):
    """A use of a number that no record can repeat, as of a double."""


class Record:
    """Operations in their order on numbers in places: `count` inputs first, then constants and results.

    steps, comparisons : of what depends on the inputs; these as (step, outcome), with how they fell out
    keys : places of numbers that were keys
    """

    def __init__(self, inputs: Sequence[Any]):
        self.count, self.values = len(inputs), list(inputs)
        self.depends = [True] * self.count
        self.steps: list[tuple[int, Step]] = []
        self.comparisons: list[tuple[Step, bool]] = []
        self.keys: dict[int, None] = {}

    @property
    def inputs(self) -> list[Recorded]:
        """The numbers to begin with."""
        return [Recorded(self, place) for place in range(self.count)]

    def constant(self, value: Any) -> Recorded:
        """A number that does not depend on the inputs, of which it is known where it is a key."""
        return Recorded(self, self._add(value, False))

    def place(self, number: Any) -> int:
        """Place of a number; a constant gets a place of its own."""
        return number.place if isinstance(number, Recorded) else self._add(number, False)

    def _add(self, value: Any, depends: bool) -> int:
        self.values.append(value)
        self.depends.append(depends)
        return len(self.values) - 1

    def result(self, operation: Operation, one: Any, other: Any) -> Recorded:
        """The number that an operation makes of two."""
        a, b = self.place(one), self.place(other)
        depends = self.depends[a] or self.depends[b]
        place = self._add(operation(self.values[a], self.values[b]), depends)
        if depends:
            self.steps.append((place, (operation, a, b)))
        return Recorded(self, place)

    def outcome(self, comparison: Operation, one: Any, other: Any) -> bool:
        """Outcome of a comparison, which is recorded."""
        a, b = self.place(one), self.place(other)
        outcome = bool(comparison(self.values[a], self.values[b]))
        if self.depends[a] or self.depends[b]:
            self.comparisons.append(((comparison, a, b), outcome))
        return outcome

    def for_results(self, places: Iterable[int]) -> None:
        """Keep what results in some places need, and the comparisons and keys."""
        needed = {*places, *self.keys}
        for (_, one, other), _ in self.comparisons:
            needed |= {one, other}
        kept = []
        for place, step in reversed(self.steps):
            if place in needed:
                needed |= {step[1], step[2]}
                kept.append((place, step))
        self.steps = kept[::-1]

    def repeated(self, inputs: Sequence[Any]) -> list[Any] | None:
        """The numbers in all places for other inputs; None where a comparison falls out otherwise, or keys
        that were equal are not, or others are.
        """
        values = [*inputs, *self.values[self.count :]]
        try:
            for place, (operation, one, other) in self.steps:
                values[place] = operation(values[one], values[other])
        except ArithmeticError:
            return None
        for (comparison, one, other), outcome in self.comparisons:
            if comparison(values[one], values[other]) is not outcome:
                return None
        return values if self._same_keys(values) else None

    def _same_keys(self, values: Sequence[Any]) -> bool:
        """Whether the keys among these numbers are equal as they were; and not to a number that a formula may
        come to have by itself: small whole numbers, halves, pi.
        """
        moving, fixed = self._equal_keys
        names = set()
        for place, *others in moving:
            now = values[place]
            if any(values[other] != now for other in others):
                return False
            name = type(now), now
            if name in fixed or name in names or (now != self.values[place] and _is_common(now)):
                return False
            names.add(name)
        return True

    @cached_property
    def _equal_keys(self) -> tuple[list[list[int]], set[tuple[type, Any]]]:
        """The places of keys that are equal and depend on the inputs; the others, each with its type."""
        equal: dict[tuple[type, Any], list[int]] = {}
        for place in self.keys:
            equal.setdefault((type(self.values[place]), self.values[place]), []).append(place)
        moving = {name for name, places in equal.items() if any(self.depends[place] for place in places)}
        return [equal[name] for name in moving], equal.keys() - moving


def _is_common(x: Any) -> bool:
    """Whether a formula may come to have a number by itself."""
    if isinstance(x, Fraction):
        return x.denominator <= 2 and abs(x) <= SMALL
    return bool(x == math.pi or (abs(x) <= SMALL and 2 * x % 1 == 0))


Method = Callable[["Recorded", Any], "Recorded"]


def _both_ways(operation: Operation) -> tuple[Method, Method]:
    """An operation that is recorded, with a recorded number on the left and on the right."""
    return (
        lambda self, other: self.record.result(operation, self, other),
        lambda self, other: self.record.result(operation, other, self),
    )


def _compared(comparison: Operation) -> Callable[[Recorded, Any], bool]:
    """A comparison that is recorded."""
    return lambda self, other: self.record.outcome(comparison, self, other)


class Recorded:
    """A double in a place of a record."""

    __slots__ = ("place", "record")

    def __init__(self, record: Record, place: int):
        self.record, self.place = record, place

    @property
    def value(self) -> Any:
        """The number that it was at first."""
        return self.record.values[self.place]

    __add__, __radd__ = _both_ways(operator.add)
    __sub__, __rsub__ = _both_ways(operator.sub)
    __mul__, __rmul__ = _both_ways(operator.mul)
    __truediv__, __rtruediv__ = _both_ways(operator.truediv)
    __lt__ = _compared(operator.lt)
    __le__ = _compared(operator.le)
    __gt__ = _compared(operator.gt)
    __ge__ = _compared(operator.ge)
    __eq__ = _compared(operator.eq)
    __ne__ = _compared(operator.ne)

    def __neg__(self) -> Recorded:
        return self.record.result(_negative, self, self)

    def __abs__(self) -> Recorded:
        return self.record.result(_size, self, self)

    def __bool__(self) -> bool:
        return self.record.outcome(operator.ne, self, 0.0)

    def __float__(self) -> float:
        raise NotRecorded("a recorded number was taken as a double")

    def __hash__(self) -> int:
        self.record.keys[self.place] = None
        return hash(self.value)

    def __repr__(self) -> str:
        return repr(self.value)

    @property
    def denominator(self) -> int:
        """Raises NotRecorded: what depends on it is no operation."""
        raise NotRecorded("a recorded number was taken as a fraction")


def _negative(x: float, _: float) -> float:
    return -x


def _size(x: float, _: float) -> float:
    return abs(x)


def _root(x: float, _: float) -> float:
    return math.sqrt(x)


def _as_double(x: Any, _: Any) -> float:
    return float(x)


def as_double(x: Any) -> Any:
    """A number as a double, which is recorded where the number is."""
    if not isinstance(x, Recorded):
        return float(x)
    return x.record.result(_as_double, x, x) if isinstance(x.value, Fraction) else x


def _recorded(function: Callable[[float], float]) -> Callable[[Any], Any]:
    """A function of one double that is recorded."""

    def of_two(x: float, _: float) -> float:
        return function(x)

    return lambda x: x.record.result(of_two, x, x) if isinstance(x, Recorded) else function(x)


class RecordedNumbers(Doubles):
    """The kit of `Recorded` numbers, among which plain doubles are constants."""

    sin, cos = staticmethod(_recorded(Doubles.sin)), staticmethod(_recorded(Doubles.cos))

    @staticmethod
    def function(name: str) -> Callable[[Any], Any]:
        return _recorded(Doubles.function(name))

    @staticmethod
    def number(value: Any) -> Any:
        return as_double(value) if isinstance(value, int | Fraction | Recorded) else value

    @staticmethod
    def sqrt(x: Any) -> Any:
        return x.record.result(_root, x, x) if isinstance(x, Recorded) else math.sqrt(x)

    @staticmethod
    def power(x: Any, p: float) -> Any:
        return x.record.result(Doubles.power, x, p) if isinstance(x, Recorded) else Doubles.power(x, p)
