"""A batch: points that one worker computes one after another, and gives back together.

It is made of pieces. Within a piece a state is carried from point to point where the sweep does so; the
pieces have nothing to do with each other.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from vibsim.sweeps.plan.recipe import Recipe, Start
from vibsim.sweeps.plan.sweep_plan import Index
from vibsim.sweeps.points.point import Point, compute_point


@dataclass(frozen=True)
class Piece:
    """Neighbours of one chain: index of each and what it changes in the case; where the first begins."""

    points: tuple[tuple[Index, dict[str, str]], ...]
    start: Start | None = None

    def __len__(self) -> int:
        return len(self.points)


Pieces = tuple[Piece, ...]


def compute_batch(
    recipe: Recipe, pieces: Pieces, engine: str, go_on: Callable[[], bool] | None = None
) -> list[Point]:
    """The points of all pieces, in their order; those that were done before `go_on` said False."""
    points: list[Point] = []
    for piece in pieces:
        done = list(compute_piece(recipe, piece, engine, go_on))
        points += done
        if len(done) < len(piece):
            break
    return points


def compute_piece(
    recipe: Recipe, piece: Piece, engine: str, go_on: Callable[[], bool] | None
) -> Iterator[Point]:
    """The points of a piece, up to one that was given up. After a failed one the next begins where it did."""
    start = piece.start
    for index, changes in piece.points:
        point = compute_point(recipe, index, changes, start, engine, go_on)
        if point is None:
            return
        if recipe.carry and point.done:
            start = recipe.start_after(point.values)
        yield point
