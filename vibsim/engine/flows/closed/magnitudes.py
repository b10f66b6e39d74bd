"""Magnitudes of sums and products: what their rounding is proportional to, however much they cancel."""

from __future__ import annotations

from typing import Any, Generic, cast

from vibsim.physics.arithmetic.numbers import N, abs


class Magnitude(Generic[N]):
    """A number of which only the magnitude counts: |a + b| and |a - b| are taken as |a| + |b|.

    What is written for numbers gives, on magnitudes, the sum of the magnitudes of its terms. Such a number is
    zero only where every term is.
    """

    __slots__ = ("size",)

    def __init__(self, value: N | int) -> None:
        self.size = abs(value)

    def __add__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size + size_of(other))

    __radd__ = __sub__ = __rsub__ = __add__

    def __mul__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size * size_of(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size / size_of(other))

    def __neg__(self) -> Magnitude[N]:
        return self

    def __eq__(self, other: object) -> bool:
        return bool(self.size == other)

    __hash__ = None  # type: ignore[assignment]


def size_of(value: Any) -> Any:
    """The magnitude of a number, or of a `Magnitude` what it stands for."""
    return value.size if isinstance(value, Magnitude) else abs(value)


def magnitudes(values: list[N]) -> list[N]:
    """The numbers as magnitudes, for what is written for numbers."""
    return cast("list[N]", [Magnitude(value) for value in values])
