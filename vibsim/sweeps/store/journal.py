"""The journal of a sweep: finished points, as they come."""

from pathlib import Path
from typing import Any

import numpy as np

from vibsim.files.journal import Journal as Records
from vibsim.files.journal import journal_path as journal_path
from vibsim.sweeps.plan.sweep_plan import Plan
from vibsim.sweeps.points.point import Point

NUMBER = 60  # bytes of a number and its name
TEXTS = 1500  # bytes of place, fingerprint and the reason of a failure


class Journal(Records):
    """A journal whose records are points."""

    def __init__(self, target: Path, what: str = "sweep", shown: str | Path = ""):
        super().__init__(target, what, shown)

    def _plain(self, point: Point) -> dict[str, Any]:
        """A point as plain data. Arrays are the hex digits of their doubles, which is five times as fast as
        decimals.
        """
        return {
            **vars(point),
            "arrays": {name: array.astype("<f8").tobytes().hex() for name, array in point.arrays.items()},
        }

    def _from_plain(self, plain: dict[str, Any]) -> Point:
        return point_from(plain)


def point_from(plain: dict[str, Any]) -> Point:
    """The point that a journal wrote down."""
    arrays = {name: np.frombuffer(bytes.fromhex(digits), "<f8") for name, digits in plain["arrays"].items()}
    return Point(**{**plain, "index": tuple(plain["index"]), "arrays": arrays})


def record_bytes(plan: Plan) -> int:
    """Room that one point takes at most, about [bytes]."""
    further = [name for name, column in plan.columns.items() if column.dimension]
    doubles = sum(plan.shape_of(name)[-1] for name in further)
    return 2 * 8 * doubles + NUMBER * len(plan.columns) + TEXTS
