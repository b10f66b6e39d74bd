"""A bifurcation followed in two parameters: orbits with a multiplier on the unit circle, or that graze.

Unknowns are those of the branch and the second parameter; to the equations of the orbit comes the test value
that is zero at the bifurcation. Its derivative is a difference quotient: an error of it slows Newton's method
down and moves no solution.
"""

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vibsim.cases import Case, CaseError
from vibsim.orbits.branches.correction import (
    SHARP,
    ContinuationError,
    NoCase,
    Pace,
    correct,
    kernel,
    tangent,
    turn,
)
from vibsim.orbits.branches.family import SHIFT, STEEP, Family, FamilyPoint
from vibsim.orbits.branches.grazing import TouchFamily, Window, window_of
from vibsim.orbits.branches.node import LEAST_LIMIT, Node
from vibsim.orbits.branches.special_points import (
    DOUBLING,
    FOLD,
    GRAZING,
    STICKING,
    TORUS,
    critical_share,
    excess_at,
)
from vibsim.orbits.stability import length_of, moduli, modulus

DIFFERENCE = 2.0**-20  # of a scaled unknown: rounding over it and what it leaves out are about 1e-8
ASIDE = 2.0**-12  # scaled: beside a kink, far beyond what difference quotients reach
FAMILIES = 4  # values of the second parameter that are kept
LOCUS_PACE = Pace(first=0.01, least=1e-7, most=0.05)
END = "end of the range"
GRAZED = "a rigid stop is grazed: here the locus meets that of the grazing"
INFINITE = 1e6  # scaled derivative of a test value beside which a rigid stop is grazed
KINDS = (FOLD, DOUBLING, TORUS, GRAZING, STICKING)
WATCHED = (GRAZING, STICKING)  # changes of order, where multipliers are on no circle


class ParameterPlane:
    """The orbits of a case over two parameters, with a bifurcation of a kind.

    family : over the first parameter; keys, unit : of the second; scale : of the second
    pair : the multiplier that is followed along Neimark-Sacker points
    part : number of the stop that is grazed, or the friction that begins to hold
    window, share : when the stop is grazed, and when the friction begins to hold [s / period]
    """

    def __init__(
        self,
        family: Family,
        keys: Sequence[str],
        unit: str,
        scale: float,
        kind: str,
        pair: complex,
        part: int = -1,
    ):
        self.family, self.keys, self.unit, self.kind, self.pair = family, tuple(keys), unit, kind, pair
        self.part, self.share = part, 0.0
        self.window: Window | None = None
        self.scale = np.append(family.scale, scale)
        self._families: OrderedDict[float, Family] = OrderedDict()
        self._past: dict[float, TouchFamily] = {}

    def family_at(self, second: float) -> Family:
        """The orbits over the first parameter at a value of the second. Raises NoCase."""
        if second not in self._families:
            try:
                case = self.case_at(second)
            except CaseError as error:
                raise NoCase(str(error)) from error
            self._families[second] = self.family.over(case)
            if len(self._families) > FAMILIES:
                self._families.popitem(last=False)
        self._families.move_to_end(second)
        return self._families[second]

    def case_at(self, second: float) -> Case:
        """The case at a value of the second parameter. Raises CaseError."""
        return self.family.case.with_values(dict.fromkeys(self.keys, f"{second!r} {self.unit}".strip()))

    def watch(self, z: np.ndarray) -> None:
        """Look when the stop is grazed, or the friction holds, on the orbit at scaled unknowns.

        Raises ContinuationError.
        """
        family = self.family_at(float(z[-1] * self.scale[-1]))
        point = family(z[:-1])
        if self.kind == STICKING:
            self.share = critical_share(family.map(point.parameter).scene, point.end, self.part)
        else:
            self.window = window_of(family.map(point.parameter), point.end.X, point.period, self.part)
            self._past.clear()

    def __call__(self, z: np.ndarray) -> "PlanePoint":
        """The motion over one return from scaled unknowns. Raises ContinuationError."""
        second = float(z[-1] * self.scale[-1])
        family = self.family_at(second)
        if self.window is not None:
            if second not in self._past:
                self._past[second] = TouchFamily(family, self.window)
            family = self._past[second]
        return PlanePoint(self, z, family(z[:-1]))

    def test(self, point: FamilyPoint) -> float:
        """The value that is zero at the bifurcation."""
        node = Node(point, point.z, 0)
        if self.kind == FOLD:
            return node.fold
        if self.kind == GRAZING:
            return float(point.end.clearance)
        if self.kind == STICKING:
            scene = point.family.map(point.parameter).scene
            return excess_at(scene, point.end, self.part, self.share)
        return node.doubling if self.kind == DOUBLING else node.torus(self.pair)


class PlanePoint:
    """A motion over one return, as a point of a locus; see `correction.CorrectedPoint`."""

    settled = rounded = True
    first_slope: np.ndarray | None = None  # each point has its own
    narrow_slope: np.ndarray | None = None

    def __init__(self, plane: ParameterPlane, z: np.ndarray, point: FamilyPoint):
        self.plane, self.z, self.point = plane, z, point

    @property
    def second(self) -> float:
        """The second parameter."""
        return float(self.z[-1] * self.plane.scale[-1])

    @cached_property
    def residual(self) -> np.ndarray:
        """Of the equations of the orbit and the test, scaled."""
        return np.append(self.point.residual, self.excess / self._size)

    @cached_property
    def _gradient(self) -> np.ndarray:
        """Derivative of the test by the unknowns."""
        gradient = self._quotients(DIFFERENCE)
        steepness = length_of(gradient)
        if self.plane.kind in WATCHED or steepness <= STEEP:
            return gradient
        return self._quotients(DIFFERENCE * STEEP / steepness)  # near grazing it is as bent as it is steep

    def _quotients(self, shift: float) -> np.ndarray:
        """Difference quotients of the test by the unknowns."""
        here, gradient = self.plane.test(self.point), np.empty(len(self.z))
        for i, one in enumerate(np.eye(len(self.z))):
            beside, width = self._beside(shift * one, shift)
            gradient[i] = (self.plane.test(beside) - here) / width
        return gradient

    def _beside(self, shift: np.ndarray, width: float) -> tuple[FamilyPoint, float]:
        """The motion at shifted unknowns, and the width; on the other side where the case has none here."""
        try:
            return self.plane(self.z + shift).point, width
        except NoCase:
            return self.plane(self.z - shift).point, -width

    @cached_property
    def _size(self) -> float:
        beside = self._aside if self.plane.kind == STICKING else self
        return length_of(beside._gradient) or 1.0

    @property
    def grazes(self) -> bool:
        """Whether multipliers grow without bound beside it, as where a rigid stop is all but grazed."""
        scene = self.point.end.coordinates.scene
        return self.plane.kind not in WATCHED and bool(scene.rigid_stops) and self._size > INFINITE

    @property
    def linear(self) -> np.ndarray:
        """Derivative of the residual by z without the second parameter."""
        return self.jacobian()[:, :-1]

    def jacobian(self, slope: np.ndarray | None = None) -> np.ndarray:
        """Derivative of the residual by z; at a kink of the return map that of its own side."""
        if self.plane.kind != STICKING:
            return self._jacobian
        rows: np.ndarray = self._aside._jacobian.copy()
        rows[-1] *= self._aside._size / self._size
        return rows

    @cached_property
    def _jacobian(self) -> np.ndarray:
        shift = np.zeros(len(self.z))
        shift[-1] = SHIFT
        beside, width = self._beside(shift, SHIFT)
        by_second = (beside.residual - self.point.residual) / width
        upper = np.column_stack([self.point.jacobian(), by_second])
        return np.vstack([upper, self._gradient / self._size])

    @cached_property
    def _aside(self) -> "PlanePoint":
        """The motion beside this one along its branch, on the same side of the limit of its friction.

        Along the branch, as of a motion that is its own mirror image both reversals have to get there.
        """
        shift, side = ASIDE * np.append(kernel(self.point.jacobian())[-1], 0.0), 1 if self.excess > 0 else -1
        return max((self.plane(self.z + way * shift) for way in (1, -1)), key=lambda one: side * one.excess)

    @property
    def excess(self) -> float:
        """The test value, not scaled."""
        return self.plane.test(self.point)

    def moved(self, step: np.ndarray, slope: np.ndarray | None = None) -> np.ndarray:
        """z after a Newton step."""
        return np.asarray(self.z + step)

    @property
    def critical(self) -> list[int]:
        """Places of the multipliers that are on the circle, among all."""
        multipliers = self.point.multipliers
        if self.plane.kind in WATCHED:
            return []
        target = {FOLD: 1.0, DOUBLING: -1.0}.get(self.plane.kind)
        if target is not None:
            return [int(np.argmin(moduli(multipliers - target)))]
        pair = self.plane.pair
        return [int(np.argmin(moduli(multipliers - mu))) for mu in (pair, pair.conjugate())]

    @property
    def index(self) -> int:
        """Number of the other multipliers outside the unit circle."""
        others = np.delete(self.point.multipliers, self.critical)
        return int(np.count_nonzero(moduli(others) > 1))


@dataclass(frozen=True)
class LocusStep:
    """One step along a locus; next: length of the one behind; ended: why none follows."""

    point: PlanePoint
    tangent: np.ndarray
    next: float
    ended: str = ""


def walk(
    plane: ParameterPlane,
    start: PlanePoint,
    along: np.ndarray,
    step: float,
    spans: Sequence[tuple[float, float]],
) -> Iterator[LocusStep]:
    """Steps from a point of a locus, until it leaves the ranges of the two parameters or ends."""
    here, direction = start, along
    while True:
        try:
            point, ahead, turned = _next(plane, here, direction, step)
        except _Short as error:
            last = _onto_bound(plane, here, direction, step, spans[1]) if error.no_case else None
            if last is not None:
                yield LocusStep(last, direction, step, END)
                return
            if step / 2 < LOCUS_PACE.least:
                yield LocusStep(here, direction, step, str(error))
                return
            step /= 2
            continue
        following = LOCUS_PACE.following(step, turned, 4)
        ended = _ended(point, spans)
        if ended == END:
            point = _at_bound(plane, here, point, spans)
        yield LocusStep(point, ahead, following, ended)
        if ended:
            return
        here, direction, step = point, ahead, following


class _Short(Exception):
    """A step that must be shorter; no_case: because the case does not allow a value that it leads to."""

    def __init__(self, reason: str, no_case: bool = False):
        super().__init__(reason)
        self.no_case = no_case


def _next(
    plane: ParameterPlane, here: PlanePoint, direction: np.ndarray, step: float
) -> tuple[PlanePoint, np.ndarray, float]:
    """The next point, the tangent there and how far it turned [rad]. Raises _Short."""
    try:
        point = correct(plane, here.z + step * direction, direction, 2 * step).point
        ahead = tangent(point.jacobian(), direction)
    except ContinuationError as error:
        raise _Short(str(error), isinstance(error, NoCase)) from error
    turned = turn(direction, ahead)
    if turned > SHARP:
        raise _Short("the locus turns too sharply")
    if plane.kind == TORUS:
        follow_pair(plane, point)
    if plane.kind in WATCHED:
        follow_change(plane, point)
    return point, ahead, turned


def follow_change(plane: ParameterPlane, point: PlanePoint) -> None:
    """Go on with the touch or the stick where it is now; raises _Short where there is none."""
    try:
        plane.watch(point.z)
    except ContinuationError as error:
        raise _Short(str(error)) from error


def follow_pair(plane: ParameterPlane, point: PlanePoint) -> None:
    """Go on with the pair of multipliers on the circle; raises _Short where it has become real."""
    pairs = [mu for mu in point.point.multipliers if mu.imag > 0 and abs(modulus(mu) - 1) < 1e-6]
    if not pairs:
        raise _Short("the pair meets on the real axis: here the Neimark-Sacker points end")
    plane.pair = min(pairs, key=lambda mu: modulus(mu - plane.pair))


def _at_bound(
    plane: ParameterPlane, here: PlanePoint, point: PlanePoint, spans: Sequence[tuple[float, float]]
) -> PlanePoint:
    """The point at the end of the range of a parameter, between one inside and one outside."""
    for place, span in zip((-2, -1), spans, strict=True):
        value = float(point.z[place] * plane.scale[place])
        bound = min(max(value, min(span)), max(span)) / plane.scale[place]
        if min(span) <= value <= max(span):
            continue
        share = (bound - here.z[place]) / (point.z[place] - here.z[place])
        start = here.z + share * (point.z - here.z)
        start[place] = bound
        try:
            point = correct(plane, start, np.eye(len(start))[place], 0.1).point
        except ContinuationError:
            continue
    return point


def _onto_bound(
    plane: ParameterPlane, here: PlanePoint, direction: np.ndarray, step: float, span: tuple[float, float]
) -> PlanePoint | None:
    """The point at the end of the range of the second parameter, where the case allows nothing beyond it.

    None where that is more than two steps away, or Newton's method fails.
    """
    if not direction[-1]:
        return None
    bound = (max(span) if direction[-1] > 0 else min(span)) / plane.scale[-1]
    away = float(bound - here.z[-1]) / float(direction[-1])
    if away <= LOCUS_PACE.least * 1e-6:
        return here
    if away > 2 * step:
        return None
    start = here.z + away * direction
    for start[-1] in (bound, np.nextafter(bound, here.z[-1])):  # one may be beyond by rounding
        try:
            point: PlanePoint = correct(
                plane, start, np.eye(len(start))[-1], max(4 * away, LEAST_LIMIT)
            ).point
            return point
        except ContinuationError:
            continue
    return None


def _ended(point: PlanePoint, spans: Sequence[tuple[float, float]]) -> str:
    values: list[Any] = [point.point.parameter, point.second]
    outside = any(not min(span) <= value <= max(span) for value, span in zip(values, spans, strict=True))
    return END if outside else GRAZED if point.grazes else ""
