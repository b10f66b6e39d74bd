"""The points of a sweep as arrays by name, over the axes and the direction."""

from collections.abc import Callable, Iterator

import numpy as np

from vibsim.sweeps.plan.sweep_plan import Index, Plan
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.statistics.columns import DONE, FAILED, MISSING

TEXTS_AND_STATUS = ("status", "sha256", "error")
PIECE = 2**20  # numbers


class Table:
    """All points; what was not computed is NaN, its status MISSING.

    Attributes
    ----------
    numbers : name -> array of the sweep's shape, or with a further dimension such as (*shape, section)
    status : codes of `columns.STATUS_FLAGS` (shape)
    sha256, error : texts (shape)
    """

    def __init__(self, plan: Plan):
        shape = self.shape = plan.shape
        self._further = {name for name, column in plan.columns.items() if column.dimension}
        self.numbers = {name: _unknown(plan.shape_of(name)) for name in plan.columns}
        self.status = np.full(shape, MISSING, dtype="i1")
        self.sha256 = np.full(shape, "", dtype=object)
        self.error = np.full(shape, "", dtype=object)

    def column(self, name: str) -> np.ndarray:
        """A column of numbers, or status, sha256 or error."""
        return getattr(self, name) if name in TEXTS_AND_STATUS else self.numbers[name]

    def fill(self, read: Callable[[str], np.ndarray]) -> None:
        """Take over all columns as `read` gives them."""
        for name in (*self.numbers, *TEXTS_AND_STATUS):
            self.column(name)[...] = read(name)

    def put(self, point: Point) -> None:
        """Store a point, in place of what was there; what is shorter than its dimension gets NaN in front."""
        for name, array in self.numbers.items():
            if name not in self._further:
                array[point.index] = point.values.get(name, np.nan)
                continue
            row, values = array[point.index], point.arrays.get(name)
            row[...] = np.nan
            if values is not None:
                row[len(row) - len(values) :] = values
        self.status[point.index] = point.status
        self.sha256[point.index] = point.sha256
        self.error[point.index] = point.error

    def point(self, index: Index) -> Point:
        """The point at `index`, as it was put."""
        further = self._further
        values = {name: float(array[index]) for name, array in self.numbers.items() if name not in further}
        arrays = {name: array[index].copy() for name, array in self.numbers.items() if name in further}
        status, sha256, error = self.status[index], self.sha256[index], self.error[index]
        return Point(index, int(status), str(sha256), str(error), values, arrays)

    def count(self, status: int) -> int:
        """Number of points of a status."""
        return int(np.count_nonzero(self.status == status))

    @property
    def complete(self) -> bool:
        """Whether every point was computed, failed ones included."""
        return self.count(MISSING) == 0

    @property
    def done(self) -> bool:
        """Whether every point was computed and none failed."""
        return self.count(DONE) == self.status.size

    def failures(self) -> Iterator[tuple[Index, str]]:
        """Index and reason of each failed point."""
        for index in np.argwhere(self.status == FAILED).tolist():
            yield tuple(index), str(self.error[tuple(index)])


def _unknown(shape: Index) -> np.ndarray:
    """An array of NaN, filled piece by piece: memory can come slowly, and Ctrl-C is heard between pieces."""
    array = np.empty(shape)
    flat = array.reshape(-1)
    for first in range(0, flat.size, PIECE):
        flat[first : first + PIECE] = np.nan
    return array
