"""The boundary between two basins: its points by bisection, and the saddle orbit that motions on it come to.

    edge tracking     J. D. Skufca, J. A. Yorke and B. Eckhardt, Edge of chaos in a parallel shear flow,
                      Physical Review Letters 96 (2006) 174101
    straddle orbits   P. M. Battelino, C. Grebogi, E. Ott, J. A. Yorke and E. D. Yorke, Multiple coexisting
                      attractors, basin boundaries and basic sets, Physica D 32 (1988) 296-305

Two starts that end on two attractors are brought together by bisection of the segment between them, until
they are neighbours. Both are then followed from return to return of the section: between them a motion stays
on the boundary. When they have parted they are brought together again. What the motion on the boundary comes
to is the edge state; where it repeats itself, Newton's method finds the orbit. It is accepted when one of its
multipliers alone lies outside the unit circle, and the two sides of its unstable direction end apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.quantities import number
from vibsim.engine.errors import EngineError
from vibsim.orbits.coordinates import Coordinates, OrbitError
from vibsim.orbits.newton import solve
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.search import ROUGH, least
from vibsim.orbits.stability import eigenvalues, moduli, product, sides_of_circle, solved_by_pivots
from vibsim.physics.elementary import exp, log, mean
from vibsim.sweeps.basin_starts import LONGER, NOWHERE, BasinEnd, Basins, Stepping, basins_and_starts

if TYPE_CHECKING:
    from vibsim.cases import Case

# Bisection of a segment, and the motion on the boundary.


CLOSE = 1e-11  # of the size of the states: starts on the two sides are neighbours
FINE = 1e-6  # of it: a motion between two states so near is on the boundary
PARTED = 1e-4  # of it: then the two are brought together again
# of the segment: where its middle is taken, off the half, which symmetry may put on a saddle; and where else
SHARES = (0.4871, 0.382, 0.618, 0.236, 0.764)
ROUNDS = 24  # of bisection and following
LONGEST = 512  # returns that two neighbours are followed in a round
MOST_RETURNS = 8  # of an orbit on the boundary
TRIES = 3  # numbers of returns that Newton's method is tried with
NEAR = 0.05  # of the size: an orbit further from the motion on the boundary is not where it goes
JUMPS = 6  # rounds in which neighbours are far apart at the next return: the boundary is a jump of the map


class EdgeError(OrbitError):
    """A boundary between two basins on which no saddle was found: what was found, in one sentence."""


@dataclass(frozen=True, eq=False)
class BoundaryPair:
    """Two states on the two sides of a boundary, and the attractors on which they end."""

    a: np.ndarray
    b: np.ndarray
    ends: tuple[int, int]


@dataclass(frozen=True, eq=False)
class UnstableRest:
    """A state of rest on a boundary.

    state : by name of the column; rates : growth rates of disturbances [1/s], the largest first
    components : the same state in a row
    """

    state: dict[str, float]
    rates: tuple[float, ...]
    components: np.ndarray


@dataclass(frozen=True, eq=False)
class BasinEdge:
    """The saddle, or the states, on the boundary between two basins.

    case : theirs
    orbit : the saddle orbit, or None; rest : the unstable state of rest, where it is that
    between : the attractors that were asked for; sides : those on which the two sides of the saddle end
    pair : neighbours on the boundary of which the search began, by name of the column
    rounds : of bisection and following; runs : starts that were run to their ends

    >>> import vibsim
    >>> clear, strikes = {"x_tip": 0.0, "v_tip": 0.0}, {"x_tip": 0.0, "v_tip": 0.4}
    >>> found = vibsim.edge("gallery/cantilever", clear, strikes)
    >>> sorted(end.orbit.spelled for end in found.sides)
    ['', 'be']
    """

    case: Case
    orbit: Orbit | None
    rest: UnstableRest | None
    between: tuple[BasinEnd, BasinEnd]
    sides: tuple[BasinEnd, BasinEnd]
    pair: tuple[dict[str, float], dict[str, float]]
    rounds: int
    runs: int


def edge_between(basins: Basins, start_a: Mapping[str, float], start_b: Mapping[str, float]) -> BasinEdge:
    """The saddle on the boundary between the basins of two starts, states by name of the column.

    Raises EdgeError where the starts end on one attractor or on none, and where motions on the boundary come
    to no orbit; OrbitError, EngineError.
    """
    stepping = Stepping(basins.scene)
    a, b = stepping.of_state(start_a), stepping.of_state(start_b)
    ends = _two_ends(basins, (start_a, start_b))
    return _Tracking(basins, stepping, BoundaryPair(a, stepping.near(b, a), ends)).edge()


def _two_ends(basins: Basins, starts: tuple[Mapping[str, float], Mapping[str, float]]) -> tuple[int, int]:
    one, other = (basins.end_of(start) for start in starts)
    for name, end, start in zip(("first", "second"), (one, other), starts, strict=True):
        stop = basins.inside(start)
        if stop is not None:
            raise EdgeError(f"the {name} start lies inside the rigid stop {stop}, where nothing can be")
        if end == NOWHERE:
            raise EdgeError(
                f"on which attractor the {name} start ends is not decided within "
                f"{LONGER[-1] * basins.scene.t_end:.6g} s; give the case a longer end (run.t_end), or "
                "another start"
            )
    if one == other:
        raise EdgeError(
            f"both starts end on the same attractor, {basins.ends[one].words}; give two that end apart"
        )
    return one, other


def neighbours_between(basins: Basins, stepping: Stepping, pair: BoundaryPair, apart: float) -> BoundaryPair:
    """The pair brought together by bisection until its states are `apart` [m/s, as weighed].

    Where the middle ends on a third attractor, other places of the segment are tried, then the third is taken
    for the second one. Where everything in between is undecided, the pair is returned as near as it is.
    """
    while stepping.size(pair.b - pair.a) > apart:
        nearer = _halved(basins, stepping, pair)
        if nearer is None:
            return pair
        pair = nearer
    return pair


def _halved(basins: Basins, stepping: Stepping, pair: BoundaryPair) -> BoundaryPair | None:
    a, b, (of_a, of_b) = pair.a, pair.b, pair.ends
    third = None
    for share in SHARES:
        middle = a + share * (b - a)
        if np.array_equal(middle, a) or np.array_equal(middle, b):
            return None
        end = basins.end_of(stepping.by_column(middle))
        if end == of_a:
            return BoundaryPair(middle, b, pair.ends)
        if end == of_b:
            return BoundaryPair(a, middle, pair.ends)
        if end != NOWHERE and third is None:
            third = BoundaryPair(a, middle, (of_a, end))
    return third


@dataclass(eq=False)
class _Track:
    """A motion on the boundary, followed between two neighbours that part from it.

    states : at its returns; gaps : distances of the neighbours there [m/s]; pair : the neighbours at the end
    """

    states: list[np.ndarray]
    gaps: list[float]
    pair: BoundaryPair

    def on_boundary(self, gap: float) -> list[np.ndarray]:
        """The states up to the last at which the neighbours are no further than `gap` from each other."""
        last = max((i for i, each in enumerate(self.gaps) if each <= gap), default=0)
        return self.states[: last + 1]

    @property
    def growth(self) -> float:
        """Mean of ln of the factor by which neighbours part from one return to the next."""
        steps = len(self.gaps) - 1
        return log(self.gaps[-1] / self.gaps[0]) / steps if steps and min(self.gaps) > 0 else nan


class _Tracking:
    """The search for the saddle of one boundary."""

    def __init__(self, basins: Basins, stepping: Stepping, pair: BoundaryPair) -> None:
        self.basins, self.stepping, self.asked = basins, stepping, pair.ends
        self.pair = pair
        self.scale = max(stepping.size(pair.a), stepping.size(pair.b))
        self.growths: list[float] = []
        self.steps = self.jumps = 0
        self.elsewhere: BasinEdge | None = None  # a saddle whose sides are not the two asked for

    def edge(self) -> BasinEdge:
        """The saddle. Raises EdgeError."""
        first: BoundaryPair | None = None
        past: list[np.ndarray] = []
        for rounds in range(1, ROUNDS + 1):
            self.pair = self._together()
            first = first or self.pair
            track = self._followed()
            past = [*past, *track.on_boundary(FINE * self.scale)][-LONGEST:]
            found = self._saddle(past, first, rounds)
            if found is not None:
                return found
            self.pair = track.pair
            if self.jumps >= JUMPS and self.jumps == rounds:
                raise self._jumping(first)
        if self.elsewhere is not None:
            return self.elsewhere
        raise self._wandering()

    def _together(self) -> BoundaryPair:
        pair = neighbours_between(self.basins, self.stepping, self.pair, CLOSE * self.scale)
        if self.stepping.size(pair.b - pair.a) > PARTED * self.scale:
            raise EdgeError(
                f"where starts between {self._names(pair.ends)} end is not decided within "
                f"{LONGER[-1] * self.basins.scene.t_end:.6g} s; give the case a longer end (run.t_end)"
            )
        return pair

    def _names(self, ends: tuple[int, int]) -> str:
        return " and ".join(f"those that end on {self.basins.ends[end].words}" for end in ends)

    def _followed(self) -> _Track:
        """The motion between the neighbours until they have parted."""
        stepping, a, b = self.stepping, self.pair.a, self.pair.b
        states, gaps = [(a + b) / 2], [stepping.size(b - a)]
        while gaps[-1] < PARTED * self.scale and len(states) <= LONGEST:
            self.basins.ask()
            try:
                a = stepping.after(a)
                b = stepping.near(stepping.after(b), a)
            except EngineError:
                break  # one of them runs away
            states.append((a + b) / 2)
            gaps.append(stepping.size(b - a))
        self.steps += len(states) - 1
        self.jumps += len(states) == 2
        self.scale = max(stepping.size(states[0]), stepping.size(states[-1]), self.scale / 2)
        track = _Track(states, gaps, BoundaryPair(a, b, self.pair.ends))
        if isfinite(track.growth):
            self.growths.append(track.growth)
        return track

    # What the motion on the boundary comes to.

    def _saddle(self, past: list[np.ndarray], first: BoundaryPair, rounds: int) -> BasinEdge | None:
        """The saddle near which the motion on the boundary is, where there is one."""
        rest = _unstable_rest(self.stepping, past[-1], self.scale) if self.stepping.free else None
        orbits: Iterator[Orbit | UnstableRest] = iter([rest]) if rest else self._orbits(past)
        for saddle in orbits:
            sides = self._sides(saddle)
            if sides is None:
                continue
            ends = self.basins.ends
            edge = BasinEdge(
                self.basins.case,
                saddle if isinstance(saddle, Orbit) else None,
                saddle if isinstance(saddle, UnstableRest) else None,
                (ends[self.asked[0]], ends[self.asked[1]]),
                (ends[sides[0]], ends[sides[1]]),
                (self.stepping.by_column(first.a), self.stepping.by_column(first.b)),
                rounds,
                self.basins.runs,
            )
            if set(sides) == set(self.asked) or set(sides) == set(self.pair.ends):
                return edge
            self.elsewhere = self.elsewhere or edge
        return None

    def _orbits(self, past: list[np.ndarray]) -> Iterator[Orbit]:
        """Orbits with one unstable direction near the motion on the boundary, by the likeliest numbers of
        returns after which it comes near itself.
        """
        times, points = self._points(past)
        at, over = self.stepping.at, self.stepping.map
        for n in _likely(at, points)[:TRIES]:
            T = float(times[-1] - times[-1 - n]) if times is not None else None
            try:
                orbit = least(Orbit(over.of(n), solve(over.of(n), points[-1], T, ROUGH), self.basins.case))
            except (OrbitError, EngineError):
                continue
            outside = sides_of_circle(orbit.multipliers)[2]
            near = _distance(orbit, points[-1]) <= NEAR * max(at.size(orbit.X), self.scale)
            if outside == 1 and orbit.multipliers[0].real > 1 and near:
                yield orbit

    def _points(self, past: list[np.ndarray]) -> tuple[np.ndarray | None, np.ndarray]:
        """Times [s] of returns where they are not known beforehand, and unknowns (k, m) there."""
        if self.stepping.free:
            return self.stepping.turns(past[-1])
        return None, self.stepping.at.of(np.array(past))

    def _sides(self, saddle: Orbit | UnstableRest) -> tuple[int, int] | None:
        """The attractors on which the two sides of the unstable direction end; None where that is one."""
        if isinstance(saddle, Orbit):
            state = self.stepping.at.lifted(saddle.X)
            matrix = saddle.end.derivative * saddle.end.coordinates.ratios
            away = np.zeros(len(state))
            away[self.stepping.at.free] = _unstable(matrix)
        else:
            state = saddle.components
            away = _unstable_of_rest(self.stepping, state)
        return self._ends_beside(state, away)

    def _ends_beside(self, state: np.ndarray, away: np.ndarray) -> tuple[int, int] | None:
        for share in (1e-3, 1e-5):
            change = self.stepping.changed(share * max(self.stepping.size(state), self.scale) * away)
            one, other = (self.basins.end_of(self.stepping.by_column(state + s * change)) for s in (1, -1))
            if NOWHERE not in (one, other) and one != other:
                return one, other
        return None

    # Why there is no saddle.

    def _jumping(self, first: BoundaryPair) -> EdgeError:
        section = self.stepping.map.section
        later = "a moment later" if self.stepping.free else f"at the next {section.of_return}"
        return EdgeError(
            f"the boundary between {self._names(self.asked)} has no saddle orbit: neighbours on its two "
            f"sides, {number(CLOSE, 1)} of their size apart, are far from each other "
            f"{later}{self._differ(first)}"
        )

    def _differ(self, pair: BoundaryPair) -> str:
        """In which events the motions of two neighbours differ, in words."""
        if self.stepping.free:
            return ""
        at, over = self.stepping.at, self.stepping.map
        one, other = (over.plain(at.of(state)).events for state in (pair.a, pair.b))
        if one == other:
            return "; a formula jumps there"
        more = next((event for event in (*one, *other) if one.count(event) != other.count(event)), None)
        return f", as one of them has an event more ({more[0].replace('_', ' ')})" if more else ""

    def _wandering(self) -> EdgeError:
        of = "moment" if self.stepping.free else self.stepping.map.section.of_return
        factor = exp(float(mean(np.array(self.growths)))) if self.growths else nan
        return EdgeError(
            f"no saddle orbit between {self._names(self.asked)}: motions on the boundary, followed for "
            f"{self.steps} returns, come to no orbit of up to {MOST_RETURNS} returns whose two sides end "
            f"apart. Neighbours there part by a factor {number(factor, 3)} in each {of}; so what lies on "
            "the boundary is longer, or does not repeat itself (a chaotic saddle)"
        )


def _likely(at: Coordinates, points: np.ndarray) -> list[int]:
    """Numbers of returns after which the last of some points (k, m) come near themselves, the nearest first,
    a smaller one before its multiples that are about as near.
    """
    longest = min(MOST_RETURNS, len(points) - 1)
    gaps = {n: at.size(points[-1] - points[-1 - n]) for n in range(1, longest + 1)}
    least_gap = min(gaps.values(), default=inf)
    return sorted(gaps, key=lambda n: (gaps[n] > 4 * least_gap, n if gaps[n] <= 4 * least_gap else gaps[n]))


def _distance(orbit: Orbit, X: np.ndarray) -> float:
    """Distance of X from the nearest point of an orbit [m/s, as weighed]."""
    at = orbit.end.coordinates
    return min(at.size(at.in_turn_of(point.copy(), X) - X) for point in orbit.points)


def _unstable(matrix: np.ndarray) -> np.ndarray:
    """The direction that grows most under a weighed matrix (m, m), its largest entry 1: columns of powers."""
    power = np.array(matrix)
    for _ in range(12):
        power = product(power, power)
        power = power / np.abs(power).max()
    column = power[:, int(np.argmax(np.abs(power).max(axis=0)))]
    return np.asarray(column / np.abs(column).max())


# States of rest where nothing drives the scene.


RESTS = 1e-3  # of the size: a motion that changes no more over a stretch may come to rest
REST_STEPS = 20  # of Newton's method


def rest_near(stepping: Stepping, state: np.ndarray, scale: float, still: float = RESTS) -> np.ndarray | None:
    """The components of the state of rest near a state that hardly moves, stable or not, by Newton's method;
    None where there is none.

    scale : size of the motion [m/s, as weighed]; still : share of it that the state may move over a stretch
    """
    try:
        if stepping.size(stepping.after(state) - state) > still * scale:
            return None
        for _ in range(REST_STEPS):
            image, matrix = stretched(stepping, state)
            keep = stepping.moving
            change, pivots = solved_by_pivots(np.eye(len(keep)) - matrix, (image - state)[keep])
            if not pivots:
                return None
            state = state.copy()
            state[keep] += change
            if stepping.size(image - state) <= CLOSE * scale:
                return state
    except (EngineError, ValueError):
        return None
    return None


def _unstable_rest(stepping: Stepping, state: np.ndarray, scale: float) -> UnstableRest | None:
    """The state of rest with one unstable direction near a state that hardly moves."""
    rest = rest_near(stepping, state, scale)
    if rest is None:
        return None
    multipliers = np.array(eigenvalues(stretched(stepping, rest)[1]))
    rates = sorted((log(size) / stepping.stretch for size in moduli(multipliers).tolist()), reverse=True)
    if sum(rate > 0 for rate in rates) != 1:
        return None
    return UnstableRest(stepping.by_column(rest), tuple(rates), rest)


def stretched(stepping: Stepping, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The state after a stretch, and its derivative by the components that are not shifts (k, k)."""
    keep = stepping.moving
    carried = stepping.map.carrier.carry(state, stepping.stretch)
    matrix = np.array([stepping.plain(row) for row in carried.vectors]).T
    return stepping.plain(carried.state), np.ascontiguousarray(matrix[np.ix_(keep, keep)])


def _unstable_of_rest(stepping: Stepping, state: np.ndarray) -> np.ndarray:
    keep = stepping.moving
    matrix = stretched(stepping, state)[1]
    weights = stepping.weighed(np.ones(len(state)))[keep]
    away = np.zeros(len(state))
    away[keep] = _unstable(matrix * (weights[:, None] / weights))
    return away


# From a case or a sweep and two names of attractors to the saddle between them: what `vibsim edge` does.


def edge(
    source: Any,
    one: Any,
    other: Any,
    overrides: Mapping[str, Any] | None = None,
    ask: Callable[[], None] = lambda: None,
) -> BasinEdge:
    """The saddle on the boundary between the basins of two attractors.

    Parameters
    ----------
    source : a sweep with attractors or its file; or a case, as of `vibsim.load_case`
    one, other : of a sweep numbers of attractors, "2m" of the mirror image of number 2; else starts: a state
        by name of the column, an `Orbit`, a run or stored orbit or its file, or a case; runs and cases stand
        for their initial states
    overrides : values by key that replace those of the case

    Returns a `BasinEdge`. Raises EdgeError (an OrbitError) where no saddle was found, PlanError for
    attractors that are not there, OrbitError, CaseError, EngineError.

    >>> import vibsim
    >>> clear, strikes = {"x_tip": 0.0, "v_tip": 0.0}, {"x_tip": 0.0, "v_tip": 0.4}
    >>> saddle = vibsim.edge("gallery/cantilever", clear, strikes).orbit
    >>> saddle.spelled, saddle.multipliers.real.round(4).tolist()
    ('be', [2.1087, 0.3199])
    """
    basins, starts = basins_and_starts(source, (one, other), overrides, ask)
    return edge_between(basins, *starts)
