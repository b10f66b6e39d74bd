"""The return map past a touch: at an orbit that grazes a stop, as if the stop were not there just then.

Beside a grazing the return map has a root of the depth, at a rigid stop an infinite derivative, and the
contact itself comes and goes. What a locus of grazings needs is smooth: the motion through a short window
about the touch without that stop, and how far from the stop it turns there, below zero inside it. At the
grazing itself both are those of the motion.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from math import frexp, ldexp
from typing import Any

import numpy as np

from vibsim.engine.modes.status import OPEN
from vibsim.engine.tangent.carried import Carried
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits import OrbitError, ReturnMap
from vibsim.orbits.branches.correction import CLOSE as correction_CLOSE
from vibsim.orbits.branches.correction import ROUGH as correction_ROUGH
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.family import Family, FamilyPoint
from vibsim.orbits.branches.node import Node
from vibsim.orbits.branches.special_points import CONTACTS, GRAZING, Special
from vibsim.orbits.coordinates import placed
from vibsim.orbits.return_map import Return
from vibsim.orbits.stability import least_squares, length_of
from vibsim.orbits.words import Word, circle
from vibsim.physics.formula_values import gap_of
from vibsim.physics.formulas import begun_later
from vibsim.physics.parts import EVENT_KINDS, RIGID_KINDS, Scene

TOUCHING_SAMPLES = (
    65536  # of a period, among which the touch is looked for: hops may be as short as 1e-4 of it
)
SAME = 1e-4  # share of the period within which events of the stop belong to the touch
WIDEST, TOUCHING_SHARE = 0.05, 0.5  # half of the window: of the period, and of the way to the nearest event
AT_SECTION = 1e-4  # of the period: a touch so near to the section has no window
AT_EVENT = 1e-5  # the same of another event: hops that an incomplete chatter ends with are short
FEW = 3  # of a motion's touches, that may be the grazing
TURNS = 12  # Newton steps to the turn
CLOSE, ROUGH = (
    1e-12,
    1e-8,
)  # of the window, of the last of them, and where rounding keeps it from growing shorter
OF_STOPS = [EVENT_KINDS[kind] for kind in ("contact_begin", "contact_end", *RIGID_KINDS)]


@dataclass(frozen=True)
class Window:
    """Window in which a stop is left out: its number, and the span [s / period] about a middle."""

    stop: int
    middle: float
    half: float

    def times(self, T: float) -> tuple[float, float]:
        """Beginning and end [s]."""
        return (self.middle - self.half) * T, (self.middle + self.half) * T


@dataclass(eq=False)
class Touching(Return):
    """A motion past a touch; clearance: of the stop at the turn [m], below 0 inside it."""

    clearance: float = 0.0


class MapPastTouch(ReturnMap):
    """From the section to itself, without a stop within a window of the motion."""

    def __init__(self, scene: Any, n: int, window: Window):
        super().__init__(scene, n)
        self.window = window
        self._carriers = dict[float, Carrier]()
        stops = tuple(stop for i, stop in enumerate(scene.stops) if i != window.stop)
        self._without = replace(scene, stops=stops)

    def _motion(self, X: np.ndarray, T: float | None, disturbances: np.ndarray) -> Touching:
        """As of a `ReturnMap`. Raises OrbitError where the motion does not turn within the window."""
        T = self.section.time(self.n) if self.section.timed else self.time_of_return(X) if T is None else T
        at, window = self.coordinates, self.window.times(T)
        first = self.carrier.carry(at.lifted(X), window[0], disturbances)
        past = self._from(self._without, window[0])
        touch = past.carry(first.state, window[1] - window[0], first.vectors)
        last = self._from(self.scene, window[1]).carry(touch.state, T - window[1], touch.vectors)
        carried = joined([(0.0, first), (window[0], touch), (window[1], last)], self.window.stop)
        clearance = self._clearance(past, first.state, window)
        return Touching(at, np.asarray(X, dtype="f8"), T, self._ahead(carried), carried, clearance)

    def plain(self, X: np.ndarray, T: float | None = None) -> Touching:
        """The same: derivatives are no part of what takes long."""
        return self._motion(X, T, self.coordinates.disturbances)

    def _from(self, scene: Any, t: float) -> Carrier:
        """A carrier of motions that begin at the time t [s]."""
        key = -t if scene is self.scene else t
        if key not in self._carriers:
            self._carriers[key] = Carrier(later(scene, t))
        return self._carriers[key]

    def _clearance(self, past: Carrier, state: np.ndarray, window: tuple[float, float]) -> float:
        """The gap where it turns within the window [m]. Raises OrbitError."""
        begin, end = window
        s, last = (end - begin) / 2, end - begin
        for _ in range(TURNS):
            there = past.carry(state, s, [])
            gap, rate, bend = gap_of(self.scene, self.window.stop, begin + s, there.state, there.rate)
            if not bend > 0:
                break
            step = rate / bend
            s -= step
            if not 0 < s < end - begin:
                break
            if abs(step) <= CLOSE * (end - begin) or last / 2 <= abs(step) <= ROUGH * (end - begin):
                return float(gap - rate * step / 2)
            last = abs(step)
        raise OrbitError("the motion does not turn before the stop where it did")


class TouchFamily(Family):
    """The orbits of another family past the touch of a window."""

    def __init__(self, of: Family, window: Window):
        super().__init__(of.case, of.keys, of.unit, of.n)
        self.scale, self.window, self.path = of.scale, window, of.path

    def _new_map(self, scene: Scene) -> ReturnMap:
        return MapPastTouch(scene, self.n, self.window)


def later(scene: Any, t: float) -> Any:
    """The scene with its sources as they are at the time t [s], which becomes 0."""

    def shifted(term: Any) -> Any:
        return replace(term, phase=float(np.remainder(term.phase + term.omega * t, 2 * np.pi)))

    forces = tuple(replace(one, terms=tuple(map(shifted, one.terms))) for one in scene.forces)
    later_scene = replace(scene, forces=forces, base=tuple(map(shifted, scene.base)))
    return _formulas_later(later_scene, Fraction(t)) if scene.has_formulas else later_scene


def _formulas_later(scene: Any, t: Fraction) -> Any:
    """The scene with its formulas as they are from the time t [s] on."""

    def later_one(formula: Any) -> Any:
        return None if formula is None else begun_later(formula, t)

    def later_parts(parts: Any, *names: str) -> Any:
        return tuple(
            replace(one, **{name: later_one(getattr(one, name)) for name in names if hasattr(one, name)})
            for one in parts
        )

    frictions = tuple(
        replace(
            one,
            slips=one.slips and tuple(map(later_one, one.slips)),
            holds=one.holds and tuple(map(later_one, one.holds)),
            course=later_one(one.course),
        )
        for one in scene.frictions
    )
    return replace(
        scene,
        links=later_parts(scene.links, "force"),
        stops=later_parts(scene.stops, "force"),
        forces=later_parts(scene.forces, "formula"),
        frictions=frictions,
        base_formula=later_one(scene.base_formula),
    )


def joined(parts: list[tuple[float, Carried]], stop: int) -> Carried:
    """Motions one after another as one, each with the time at which it begins [s]; in the middle one the stop
    is left out, whose number the others have.
    """
    tables, happened = [], []
    for begin, each in parts:
        tables.append(each.table + begin * (np.arange(each.table.shape[1]) == 0))
        happened.append(each.happened)
    codes = np.insert(happened[1], 2 + stop, OPEN, axis=1)
    later_stop = np.isin(codes[:, 0], OF_STOPS) & (codes[:, 1] >= stop)
    codes[:, 1] += later_stop
    happened[1] = codes
    return replace(
        parts[-1][1],
        table=np.concatenate(tables),
        happened=np.concatenate(happened),
        uncertified=sum(each.uncertified for _, each in parts),
        margin=min(each.margin for _, each in parts),
    )


def window_of(return_map: ReturnMap, X: np.ndarray, T: float, stop: int) -> Window:
    """The window about the touch of a stop on an orbit of the full map that is nearest to grazing.

    Raises ContinuationError where there is none, or it lies on the section.
    """
    return _about(return_map, X, T, stop, touches(return_map, X, T, stop)[0])


def windows_of(return_map: ReturnMap, X: np.ndarray, T: float, stop: int) -> Iterator[Window]:
    """The windows about what is nearest to grazing a stop, the nearest first."""
    for touch in touches(return_map, X, T, stop)[:FEW]:
        try:
            yield _about(return_map, X, T, stop, touch)
        except ContinuationError:
            continue


def _about(return_map: ReturnMap, X: np.ndarray, T: float, stop: int, touch: float) -> Window:
    """The window about a touch at a time [s]. Raises ContinuationError."""
    middle, end = touch / T, return_map(X, None if return_map.section.timed else T)
    turning = frictions_between(return_map.scene, stop)
    shares = [
        t / T
        for (kind, part), t in zip(end.carried.events, end.carried.times, strict=True)
        if not (
            abs(t / T - middle) < SAME
            and (part == stop if kind in CONTACTS else kind == "reversal" and part in turning)
        )
    ]
    others = min((abs(share - middle) for share in shares), default=1.0)
    nearest = min(middle, 1 - middle, others)
    if min(middle, 1 - middle) < AT_SECTION or others < AT_EVENT:
        raise ContinuationError("the grazing comes to the section, or to another event")
    return Window(
        stop, round(middle * 2**20) / 2**20, ldexp(0.5, frexp(min(WIDEST, TOUCHING_SHARE * nearest))[1])
    )


def frictions_between(scene: Scene, stop: int) -> list[int]:
    """Numbers of the frictions that act between the ends of a stop, without a belt: the gap turns where they
    reverse.
    """
    ends = {scene.stops[stop].P, scene.stops[stop].Q}
    return [i for i, one in enumerate(scene.frictions) if {one.P, one.Q} == ends and not one.runs]


def touches(return_map: ReturnMap, X: np.ndarray, T: float, stop: int) -> list[float]:
    """Instants [s] at which an orbit nearly grazes a stop, the nearest first: turns of the gap by the rest,
    impacts by how deep the motion would go if the stop were not there. Raises ContinuationError without any.
    """
    scene = placed(return_map.scene, return_map.coordinates.state(X), T)
    step = Fraction(T / TOUCHING_SAMPLES).limit_denominator(10**9)
    sampled = replace(scene, every_num=step.numerator, every_den=step.denominator)
    blocks = [block.samples for block in open_trajectory(sampled).blocks()]
    times = np.concatenate([block["time"] for block in blocks])
    states = np.concatenate([return_map.coordinates.gathered(block) for block in blocks]).T
    start = return_map.coordinates.lifted(X)
    carried = return_map.carrier.carry(start, T, [])
    impacts = [i for i, event in enumerate(carried.events) if event == ("impact", stop)]
    gap, rate, _ = gap_of(scene, stop, times, states)
    turns = np.flatnonzero((rate[:-1] < 0) & (rate[1:] >= 0))
    struck = np.searchsorted(times, carried.times[impacts]) - 1
    near = []
    for at in np.setdiff1d(turns, struck):
        share = rate[at] / (rate[at] - rate[at + 1])
        near.append((abs(float(gap[at])), float(times[at] + share * (times[at + 1] - times[at]))))
    for i in impacts:
        t = float(carried.times[i])
        there = return_map.carrier.carry(start, t, [])
        _, rate, bend = gap_of(scene, stop, t, carried.states[i], there.rate)
        if bend > 0:
            near.append((float(rate**2 / (2 * bend)), t))
    if not near:
        raise ContinuationError("no turn before the stop is left of the grazing")
    return [t for _, t in sorted(near)]


# Where a branch ends because a rigid stop is grazed: the grazing itself, past the touch.
#
# On the side with the impact multipliers grow without bound, on the other the motion meets the stop: no step
# of the branch gets there. Past the touch the orbits go on smoothly, and the grazing is where they reach the
# stop.


STEPS = 12
EPS = 2.0**-52
DIFFERENCE = 2.0**-30  # of a scaled unknown: hops that an incomplete chatter ends with are as short as 1e-8
NEAR_END = 0.1  # scaled distance from the last orbit of the branch


def grazing_end(family: Family, node: Node) -> Special | None:
    """The grazing of a rigid stop near the last orbit of a branch; None where there is none."""
    scene = node.point.end.coordinates.scene
    for stop, _ in scene.rigid_stops:
        found = _graze(family, node, stop)
        if found is None:
            continue
        point, middle = found
        at = Node(point, node.heading, 0)
        impacting = _impacts(node.word, stop) > _impacts(at.word, stop)
        touched = node.word if impacting else _with(point, middle, stop)
        words = (node.word, at.word) if touched == node.word else (node.word, touched)
        return Special(GRAZING, at, node, at, words)
    return None


def _graze(family: Family, node: Node, stop: int) -> tuple[FamilyPoint, float] | None:
    """The nearest orbit that grazes a stop, and when [s / period]; None without any."""
    try:
        for window in windows_of(family.map(node.parameter), node.point.end.X, node.point.period, stop):
            point = _touched(TouchFamily(family, window), node)
            if point is not None:
                return point, window.middle
    except ContinuationError:
        pass
    return None


def _touched(past: TouchFamily, node: Node) -> FamilyPoint | None:
    """The orbit near a node that grazes in a window; None where there is none."""
    z, last = node.z, np.inf
    try:
        for _ in range(STEPS):
            point = past(z)
            beside = [past(z + shift).end.clearance for shift in DIFFERENCE * np.eye(len(z))]
            gradient = (np.array(beside) - point.end.clearance) / DIFFERENCE
            size = length_of(gradient) or 1.0
            matrix = np.vstack([point.jacobian(), gradient / size])
            if not np.isfinite(matrix).all():  # another stop is grazed
                return None
            missing = np.append(point.residual, point.end.clearance / size)
            step = -least_squares(matrix, missing, EPS * len(matrix))
            z = z + step
            if length_of(z - node.z) > NEAR_END:
                return None
            length = length_of(step)
            if length <= correction_CLOSE or last / 2 <= length <= correction_ROUGH:
                point = past(z)
                return point if np.isfinite(point.matrix).all() else None
            last = length
    except ContinuationError:
        pass
    return None


def _impacts(word: Word, stop: int) -> int:
    return sum(part == stop for _, part in word)


def _with(point: FamilyPoint, middle: float, stop: int) -> Word:
    """The word with the touch in its place, at a share of the period."""
    end = point.end
    turning = frictions_between(end.coordinates.scene, stop)
    reversals = [
        i
        for i, ((kind, part), t) in enumerate(zip(end.carried.events, end.carried.times, strict=True))
        if kind == "reversal" and part in turning and abs(t / end.T - middle) < SAME
    ]
    before = reversals[0] if reversals else int(np.count_nonzero(end.carried.times < middle * end.T))
    return circle((*end.events[:before], ("impact", stop), *end.events[before:]))
