"""What is kept of a branch: its points and special points, as plain numbers."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from vibsim.branches.curve.node import Node
from vibsim.branches.special.special import Special
from vibsim.branches.tracing.walk import Step
from vibsim.orbits.matrices import length_of
from vibsim.orbits.multipliers import sides_of_circle
from vibsim.orbits.returns.word import Word


@dataclass(frozen=True)
class OrbitRecord:
    """An orbit of a branch.

    parameter : in the unit of the branch; period : time of return [s]; state : unknowns on the section
    multipliers : complex, the largest first; word : the events as a circle
    fold, doubling : det(P' - I) and det(P' + I); margin : smallest gap at a turn without contact [m], or inf
    drift : of bodies that are held nowhere, per period [m]; residual : of the equations, scaled
    """

    parameter: float
    period: float
    state: tuple[float, ...]
    multipliers: tuple[complex, ...]
    word: Word
    fold: float
    doubling: float
    margin: float
    drift: tuple[float, ...]
    residual: float
    uncertified: int

    @property
    def index(self) -> int:
        """Number of multipliers outside the unit circle, by more than rounding."""
        return sides_of_circle(np.array(self.multipliers))[2]

    @property
    def stable(self) -> bool:
        """Whether all multipliers are inside the unit circle, by more than rounding."""
        return sides_of_circle(np.array(self.multipliers))[0] == len(self.multipliers)


@dataclass(frozen=True)
class PointRecord:
    """A point of a branch, and what it takes to go on from it.

    way : 1 forwards, -1 backwards from the start; number : of steps from there
    unknowns, tangent : scaled; step : length of the next step; ended : why none follows, or empty
    """

    way: int
    number: int
    orbit: OrbitRecord
    unknowns: tuple[float, ...]
    tangent: tuple[float, ...]
    step: float
    iterations: int
    ended: str = ""


@dataclass(frozen=True)
class SpecialRecord:
    """A special point of a branch, as of `vibsim.branches.special.special`.

    way, number : of the point behind it, seen from the start
    before, after : the words on both sides, the way the branch was walked; jump : of the index on that way
    """

    way: int
    number: int
    kind: str
    orbit: OrbitRecord
    unknowns: tuple[float, ...]
    tangent: tuple[float, ...]
    before: Word
    after: Word
    jump: int


def orbit_record(node: Node) -> OrbitRecord:
    """What is kept of a node."""
    point, end = node.point, node.point.end
    return OrbitRecord(
        parameter=point.parameter,
        period=point.period,
        state=tuple(end.X.tolist()),
        multipliers=tuple(node.multipliers.tolist()),
        word=node.word,
        fold=node.fold,
        doubling=node.doubling,
        margin=float(end.margin),
        drift=tuple(end.drift.values()),
        residual=length_of(point.residual),
        uncertified=int(end.uncertified),
    )


def point_record(node: Node, way: int, number: int, step: float, ended: str = "") -> PointRecord:
    """A point of a branch as it is kept."""
    places = tuple(node.z.tolist()), tuple(node.tangent.tolist())
    return PointRecord(way, number, orbit_record(node), *places, step, node.iterations, ended)


def records_of(step: Step, way: int, number: int) -> tuple[PointRecord, list[SpecialRecord]]:
    """What is kept of step `number` of a walk: its point, and the special points in front of it."""
    specials = [special_record(each, way, number) for each in step.specials]
    return point_record(step.node, way, number, step.next, step.ended), specials


def special_record(special: Special, way: int, number: int) -> SpecialRecord:
    """A special point as it is kept."""
    node = special.node
    return SpecialRecord(
        way,
        number,
        special.kind,
        orbit_record(node),
        tuple(node.z.tolist()),
        tuple(node.tangent.tolist()),
        *special.words,
        special.jump,
    )


def plain(record: PointRecord | SpecialRecord) -> dict[str, Any]:
    """A record as plain data for JSON."""
    return {**asdict(record), "orbit": plain_orbit(record.orbit)}


def plain_orbit(orbit: OrbitRecord) -> dict[str, Any]:
    """An orbit as plain data for JSON."""
    return {**asdict(orbit), "multipliers": [[mu.real, mu.imag] for mu in orbit.multipliers]}


def read_record(data: Mapping[str, Any]) -> PointRecord | SpecialRecord:
    """The record that `plain` wrote down."""
    fields = {**data, "orbit": read_orbit(data["orbit"])}
    fields |= {name: tuple(data[name]) for name in ("unknowns", "tangent")}
    if "kind" not in data:
        return PointRecord(**fields)
    return SpecialRecord(**{**fields, **{name: read_word(data[name]) for name in ("before", "after")}})


def read_orbit(data: Mapping[str, Any]) -> OrbitRecord:
    """The orbit that `plain_orbit` wrote down."""
    lists = {name: tuple(data[name]) for name in ("state", "drift")}
    multipliers = tuple(complex(*pair) for pair in data["multipliers"])
    return OrbitRecord(**{**data, **lists, "multipliers": multipliers, "word": read_word(data["word"])})


def read_word(pairs: Any) -> Word:
    """A word from pairs of kind and part."""
    return tuple((str(kind), int(part)) for kind, part in pairs)
