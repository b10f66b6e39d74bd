"""What a sweep has still to compute, handed out in batches of a length that suits workers and end."""

from collections import deque
from collections.abc import Iterable, Iterator
from math import ceil

from vibsim.sweeps.plan.sweep_plan import Plan
from vibsim.sweeps.points.batch import Piece
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.schedule.chain import Chain
from vibsim.sweeps.statistics.columns import DONE

ROUNDS = 4  # what is left is shared out in at least so many rounds, so that no worker idles at the end
LARGEST = 1000  # points in a batch

Handed = list[tuple[Chain, Piece]]


class Backlog:
    """Points to compute, in memory that does not grow with their number.

    seconds : computing time that a batch should take, so that handing it out costs little beside it
    """

    def __init__(self, plan: Plan, table: Table, seconds: float):
        self._chains = (Chain(plan, table, indices) for indices in plan.chains())
        self._begun: deque[Chain] = deque()  # chains whose last piece has come back
        self._left = plan.count - table.count(DONE)
        self._seconds = seconds
        self._pace = 0.0  # computing time of a point [s], of the last ones more than of the first; 0: unknown

    def batch(self, workers: int) -> Handed:
        """The next batch, for one of so many workers; empty where there is nothing to do at the moment."""
        handed: Handed = []
        room = self._batch_size(workers)
        while room > 0 and (chain := self._next_chain()) is not None:
            piece = chain.piece(room)
            if piece is not None:
                handed.append((chain, piece))
                room -= len(piece)
                self._left -= len(piece)
        return handed

    def take(self, handed: Handed, points: list[Point]) -> None:
        """A batch has come back whole: its chains can go on, and its points tell the pace."""
        at = 0
        for chain, piece in handed:
            chain.take(points[at : at + len(piece)])
            at += len(piece)
            if not chain.ended:
                self._begun.append(chain)
        self._note(points)

    def _batch_size(self, workers: int) -> int:
        share = ceil(max(self._left, 1) / (ROUNDS * workers))
        fitting = int(self._seconds / self._pace) if self._pace else 1
        return max(1, min(share, fitting, LARGEST))

    def _next_chain(self) -> Chain | None:
        return self._begun.popleft() if self._begun else next(self._chains, None)

    def _note(self, points: Iterable[Point]) -> None:
        times = list(_times(points))
        if times:
            mean = sum(times) / len(times)
            self._pace = (self._pace + mean) / 2 if self._pace else mean


def _times(points: Iterable[Point]) -> Iterator[float]:
    return (point.values["wall_time"] for point in points if "wall_time" in point.values)
