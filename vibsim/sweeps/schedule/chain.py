"""One chain of a sweep: the points that are computed one after another, as far as they are still to do.

A stored point counts when it is done and, where a state is carried, when it began from this very start: its
fingerprint says so. So a chain goes on from its longest valid prefix, and a failed point is tried again. The
point after a failed one begins where the failed one began.
"""

from itertools import takewhile

from vibsim.sweeps.plan.recipe import Start
from vibsim.sweeps.plan.sweep_plan import Index, Plan
from vibsim.sweeps.points.batch import Piece
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.statistics.columns import DONE, MISSING


class Chain:
    """Hands out what is missing, in pieces; the points of one come back before the next is asked for."""

    def __init__(self, plan: Plan, table: Table, indices: list[Index]):
        self._plan, self._table, self._indices = plan, table, indices
        self._at = 0
        self._start: Start | None = None

    def piece(self, most: int) -> Piece | None:
        """The next points to be computed, at most so many; None at the end of the chain."""
        while self._at < len(self._indices):
            stored = self._stored(self._indices[self._at])
            if stored is None:
                return self._missing(most)
            self._pass(stored)
        return None

    def take(self, points: list[Point]) -> None:
        """Pass over the points of the last piece."""
        for point in points:
            self._pass(point)

    @property
    def ended(self) -> bool:
        """Whether all its points were passed."""
        return self._at == len(self._indices)

    def _pass(self, point: Point) -> None:
        self._at += 1
        if self._plan.carry and point.done:
            self._start = self._plan.recipe.start_after(point.values)

    def _missing(self, most: int) -> Piece:
        """From here up to the next stored point: whether that counts, only what comes before it can tell."""
        ahead = self._indices[self._at : self._at + most]
        missing = takewhile(lambda index: self._table.status[index] != DONE, ahead)
        return Piece(tuple((index, self._plan.changes(index)) for index in missing), self._start)

    def _stored(self, index: Index) -> Point | None:
        table = self._table
        if table.status[index] != DONE:
            return None
        if self._plan.carry and table.sha256[index] != self._plan.point_case(index, self._start).sha256:
            table.status[index] = MISSING
            return None
        return table.point(index)
