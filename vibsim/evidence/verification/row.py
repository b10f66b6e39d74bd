"""One row of the verification: a number as expected and as obtained, its error and the bound of it."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

from vibsim.cases.number import number


@dataclass(frozen=True)
class Point:
    """A number of a run held against what it should be; the bound is on the absolute error.

    what : which number, such as "x1 at 4 s"; unit : of all four
    """

    what: str
    expected: float
    obtained: float
    error: float
    bound: float
    unit: str = ""

    @property
    def share(self) -> float:
        """Error as a part of the bound; infinite where the error is no number."""
        if self.error == 0:
            return 0.0
        share = self.error / self.bound if self.bound else inf
        return share if share == share else inf


@dataclass(frozen=True)
class Row:
    """One row of the table.

    check, what : the check that it belongs to, and the number; because : where the bound comes from
    points : everything that was compared, where it was more than one number

    An error that is not within the bound, NaN included, falls short.
    """

    check: str
    what: str
    expected: str
    obtained: str
    error: float
    bound: float
    unit: str
    because: str
    points: tuple[Point, ...] = ()

    @property
    def name(self) -> str:
        return f"{self.check}: {self.what}"

    @property
    def passed(self) -> bool:
        return bool(self.error <= self.bound)


def number_row(check: str, point: Point, because: str, points: Iterable[Point] = ()) -> Row:
    """The row of one number."""
    unit = f" {point.unit}" if point.unit else ""
    return Row(
        check,
        point.what,
        f"{number(point.expected, 10)}{unit}",
        f"{number(point.obtained, 10)}{unit}",
        point.error,
        point.bound,
        point.unit,
        because,
        tuple(points),
    )


def compared(
    what: str, expected: float, obtained: float, bound: float, unit: str = "", error: float | None = None
) -> Point:
    """A point; the error is the difference unless it is known better."""
    return Point(what, expected, obtained, abs(obtained - expected) if error is None else error, bound, unit)


def worst_row(check: str, points: Iterable[Point], because: str) -> Row:
    """The row of many numbers: it shows the one that comes nearest to its bound, or is furthest beyond it."""
    listed = list(points)
    return number_row(check, max(listed, key=lambda point: point.share), because, listed)


def counted_row(check: str, what: str, expected: int, obtained: int, because: str) -> Row:
    """The row of a whole number, which must be right."""
    return number_row(check, compared(what, expected, obtained, 0.0), because)
