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

from vibsim.physics.numbers import Doubles

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
        """Place of a number; a constant gets a place of its own."""
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
        """Outcome of a comparison, which is recorded."""
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
    def value(self) -> float:
        """The double that it was at first."""
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
