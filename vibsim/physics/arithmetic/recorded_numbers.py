"""Numbers that record how they come about, so that the same operations can be repeated on other doubles.

What is written for all number types leaves behind, on some numbers to begin with, the list of its operations
and of the comparisons that it went by. On other doubles for these the operations give the very bits that the
whole would give, as long as the comparisons fall out the same.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from vibsim.physics.arithmetic.numbers import Doubles

Operation = Callable[[Any, Any], Any]
Step = tuple[Operation, int, int]  # what is done, and the places of its two numbers


class NotRecorded(TypeError):
    """A use of a number that no record can repeat: as a double, or as a key."""


class Record:
    """Operations in their order on numbers in places: `count` inputs first, then constants and results.

    comparisons : (step, outcome): comparisons, with how they fell out
    """

    def __init__(self, inputs: Sequence[float]):
        self.count, self.values = len(inputs), list(inputs)
        self.steps: list[tuple[int, Step]] = []
        self.comparisons: list[tuple[Step, bool]] = []

    @property
    def inputs(self) -> list[Recorded]:
        """The numbers to begin with."""
        return [Recorded(self, place) for place in range(self.count)]

    def place(self, number: Any) -> int:
        """Where a number is, a constant in a place of its own."""
        if isinstance(number, Recorded):
            return number.place
        self.values.append(number)
        return len(self.values) - 1

    def result(self, operation: Operation, one: Any, other: Any) -> Recorded:
        """The number that an operation makes of two."""
        step = operation, self.place(one), self.place(other)
        place = self.place(operation(self.values[step[1]], self.values[step[2]]))
        self.steps.append((place, step))
        return Recorded(self, place)

    def outcome(self, comparison: Operation, one: Any, other: Any) -> bool:
        """How a comparison falls out."""
        step = comparison, self.place(one), self.place(other)
        outcome = bool(comparison(self.values[step[1]], self.values[step[2]]))
        self.comparisons.append((step, outcome))
        return outcome

    def repeated(self, inputs: Sequence[float]) -> list[float] | None:
        """The numbers in all places for other inputs; None where a comparison falls out otherwise."""
        values = [*inputs, *self.values[self.count :]]
        try:
            for place, (operation, one, other) in self.steps:
                values[place] = operation(values[one], values[other])
        except ArithmeticError:
            return None
        for (comparison, one, other), outcome in self.comparisons:
            if comparison(values[one], values[other]) is not outcome:
                return None
        return values


class Recorded:
    """A double in a place of a record."""

    __slots__ = ("place", "record")

    def __init__(self, record: Record, place: int):
        self.record, self.place = record, place

    @property
    def value(self) -> float:
        """The double that it was at first."""
        return self.record.values[self.place]

    def __add__(self, other: Any) -> Recorded:
        return self.record.result(operator.add, self, other)

    def __radd__(self, other: Any) -> Recorded:
        return self.record.result(operator.add, other, self)

    def __sub__(self, other: Any) -> Recorded:
        return self.record.result(operator.sub, self, other)

    def __rsub__(self, other: Any) -> Recorded:
        return self.record.result(operator.sub, other, self)

    def __mul__(self, other: Any) -> Recorded:
        return self.record.result(operator.mul, self, other)

    def __rmul__(self, other: Any) -> Recorded:
        return self.record.result(operator.mul, other, self)

    def __truediv__(self, other: Any) -> Recorded:
        return self.record.result(operator.truediv, self, other)

    def __rtruediv__(self, other: Any) -> Recorded:
        return self.record.result(operator.truediv, other, self)

    def __neg__(self) -> Recorded:
        return self.record.result(_negative, self, self)

    def __abs__(self) -> Recorded:
        return self.record.result(_size, self, self)

    def __lt__(self, other: Any) -> bool:
        return self.record.outcome(operator.lt, self, other)

    def __le__(self, other: Any) -> bool:
        return self.record.outcome(operator.le, self, other)

    def __gt__(self, other: Any) -> bool:
        return self.record.outcome(operator.gt, self, other)

    def __ge__(self, other: Any) -> bool:
        return self.record.outcome(operator.ge, self, other)

    def __eq__(self, other: object) -> bool:
        return self.record.outcome(operator.eq, self, other)

    def __ne__(self, other: object) -> bool:
        return self.record.outcome(operator.ne, self, other)

    def __bool__(self) -> bool:
        return self.record.outcome(operator.ne, self, 0.0)

    def __float__(self) -> float:
        raise NotRecorded("a recorded number was taken as a double")

    def __hash__(self) -> int:
        raise NotRecorded("a recorded number was taken as a key")


def _negative(x: float, _: float) -> float:
    return -x


def _size(x: float, _: float) -> float:
    return abs(x)


def _root(x: float, _: float) -> float:
    return math.sqrt(x)


class RecordedNumbers(Doubles):
    """The kit of `Recorded` numbers, among which plain doubles are constants."""

    name = "double with its record"

    @staticmethod
    def number(value: Any) -> Any:
        return float(value) if isinstance(value, int | Fraction) else value

    @staticmethod
    def sqrt(x: Any) -> Any:
        return x.record.result(_root, x, x) if isinstance(x, Recorded) else math.sqrt(x)
