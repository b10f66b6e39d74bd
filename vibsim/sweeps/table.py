"""The points of a sweep as arrays by name, over the axes and the direction."""

from collections.abc import Iterator

import numpy as np

from vibsim.physics.scene import Scene
from vibsim.sweeps.columns import DONE, FAILED, MISSING, PER_POINT, SECTION, columns_of
from vibsim.sweeps.plan import Index
from vibsim.sweeps.point import Point


class Table:
    """All points; what was not computed is NaN, its status MISSING.

    Attributes
    ----------
    numbers : name -> array of the sweep's shape (values) or (*shape, section)
    status : codes of `columns.STATUS_FLAGS` (shape)
    sha256, error : texts (shape)
    """

    def __init__(self, scene: Scene, shape: Index, section: int):
        self.shape, self.section = shape, section
        self.numbers = {name: np.full(shape, np.nan) for name in columns_of(scene, PER_POINT)}
        self.numbers |= {name: np.full((*shape, section), np.nan) for name in columns_of(scene, SECTION)}
        self.status = np.full(shape, MISSING, dtype="i1")
        self.sha256 = np.full(shape, "", dtype=object)
        self.error = np.full(shape, "", dtype=object)

    def put(self, point: Point) -> None:
        """Store a point, in place of what was there."""
        found = {**point.values, **point.section}
        for name, array in self.numbers.items():
            array[point.index] = found.get(name, np.nan)
        self.status[point.index] = point.status
        self.sha256[point.index] = point.sha256
        self.error[point.index] = point.error

    def point(self, index: Index) -> Point:
        """The point at `index`, as it was put."""
        values = {name: float(self.numbers[name][index]) for name in self.numbers if name in PER_POINT}
        section = {name: self.numbers[name][index].tolist() for name in self.numbers if name in SECTION}
        status, sha256, error = self.status[index], self.sha256[index], self.error[index]
        return Point(index, int(status), str(sha256), str(error), values, section)

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
