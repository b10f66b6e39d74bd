"""The stroboscopic section of a run: its exact state at the end of every cycle, made comparable.

Drift is left out: a point has y = x_P - x_Q and u = v_P - v_Q of every pair of ends that links and stops
join; the velocity of one body of each set that they join to each other, but not to ground or base; the speed
of the rotor, and with a rotor cosine and sine of the phases of forces and base, which its turns do not fix.
Of two blocks that is (y, u, v2, w). Of further rotors it has speeds, cosines and sines of angles, of states
their values, each by its own amplitude. Lengths are divided by the amplitude of y in the span, speeds of
bodies by that of u, the speed of the rotor by its mean; a body that goes through whole turns has cosine and
sine of its angle for y. So a distance of 1e-3 between points is a thousandth
of the vibration. What moves less than the share LEAST of the largest vibration is measured by that.

The 0-1 test for chaos of such points has K near 1 for a chaotic series, near 0 for a regular one: Gottwald
and Melbourne, "On the implementation of the 0-1 test for chaos", SIAM J. Appl. Dyn. Syst. 8 (2009) 129: the
modified mean square displacement, the correlation method, and the median over many frequencies c.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import isnan, pi

import numpy as np

from vibsim.analysis.cycles import ROWS, TURN, RegimeVerdict, Span, cycle_ends, events_within, name_verdict
from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.physics.connections import body_sets, felt_angles, force_pairs, whole_turn_angles
from vibsim.physics.elementary import dot, mean, sine_cosine_of_arrays, total
from vibsim.physics.parts import GROUND, Scene, columns_of
from vibsim.physics.rates import turning_columns
from vibsim.results.columns import PairMotion, states_at
from vibsim.results.result import Result, pieces, rows_within

FREQUENCIES = 100
LOWEST, HIGHEST = np.pi / 5, 4 * np.pi / 5  # of c; nearer to 0 and pi lie resonances of every series
SHARE = 10  # displacements over up to 1/10 of the series
GOLDEN = (np.sqrt(5) - 1) / 2


def zero_one(series: np.ndarray) -> float:
    """K of a series (n) sampled so far apart that neighbours are not alike; nan for a constant one.

    For each c the path p + iq = sum of phi_j exp(i c j) is formed, then its mean square displacement M over n
    steps, then D = M less the oscillating part (mean phi)^2 (1 - cos nc)/(1 - cos c). D grows with n where
    the path diffuses, as under chaos, and stays bounded else: K is the correlation of D with n.
    """
    series = np.asarray(series, dtype=float)
    spread = float(np.ptp(series))
    if not spread:
        return float("nan")
    series = (series - series.min()) / spread
    steps = np.arange(1, max(2, len(series) // SHARE) + 1)
    c = frequencies()[:, np.newaxis]
    sine, cosine = sine_cosine_of_arrays(c * np.arange(1, len(series) + 1))
    p, q = np.cumsum(series * cosine, axis=1), np.cumsum(series * sine, axis=1)
    oscillating = mean(series) ** 2 * (1 - cosine[:, steps - 1]) / (1 - cosine[:, :1])
    return float(np.median(correlations(steps, square_displacements(p, q, steps) - oscillating)))


def frequencies() -> np.ndarray:
    """Values of c that fill the range evenly and are no fractions of pi."""
    places = (0.5 + GOLDEN * np.arange(FREQUENCIES)) % 1.0
    return np.asarray(LOWEST + (HIGHEST - LOWEST) * places)


def square_displacements(p: np.ndarray, q: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Mean of (p[j + n] - p[j])^2 + (q[j + n] - q[j])^2 over the first j, for the n of `steps` (m).

    p, q (k, count); result (k, m), the same j for all n. (b - a)^2 = b^2 + a^2 - 2 a b: sums, and Fourier
    transforms for the products.
    """
    count = p.shape[1]
    starts = count - int(steps[-1])
    products = _lagged_products(p, starts, steps) + _lagged_products(q, starts, steps)
    sums = np.cumsum(p * p + q * q, axis=1)
    later = sums[:, steps + starts - 1] - sums[:, steps - 1]
    return np.asarray((later + sums[:, starts - 1 : starts] - 2 * products) / starts)


def _lagged_products(x: np.ndarray, starts: int, steps: np.ndarray) -> np.ndarray:
    """Sums of x[j] x[j + n] over the first `starts` j, for the n of `steps`: (k, m).

    Complex numbers are multiplied in parts: numpy's own products round differently on processors with FMA.
    """
    length = 2 ** (x.shape[1] + starts).bit_length()
    first, whole = np.fft.rfft(x[:, :starts], length), np.fft.rfft(x, length)
    spectrum = np.empty_like(whole)
    spectrum.real = first.real * whole.real + first.imag * whole.imag
    spectrum.imag = first.real * whole.imag - first.imag * whole.real
    return np.fft.irfft(spectrum, length)[:, steps]


def correlations(steps: np.ndarray, displacements: np.ndarray) -> np.ndarray:
    """Correlation coefficient with the steps (m) of each row (k, m); 0 where nothing moves."""
    a = steps - mean(steps)
    b = displacements - mean(displacements)[:, np.newaxis]
    size = np.sqrt(dot(a, a) * dot(b, b))
    return np.asarray(np.divide(dot(b, a), size, out=np.zeros(len(b)), where=size > 0))


# Does a section repeat itself after k points, since when, and is it still on its way there?


TOLERANCE = 1e-3  # of the vibration, within which points are the same
EXACT = 1e-8  # closer than this, no trend can be asked of rounding errors
LONGEST = 64  # period looked for
REPEATS, LEAST_POINTS = 5, 40  # how often a period must have been seen, and for how many points
ALL = 200  # so many points that all repeat themselves need no trend
SHRINKS = 0.7  # ratio of later to earlier steps of a motion that settles
MOSTLY = 0.9  # of the steps: chance brings some points of any motion close together
NEAR = 0.03  # steps of a motion that may be said to approach a period


@dataclass(frozen=True)
class Recurrence:
    """A section that repeats itself, or comes closer to it.

    Attributes
    ----------
    period : points after which it does
    onset : position of the first point from which on it does, within TOLERANCE
    step : distance of points a period apart that 9 in 10 keep within, over the last quarter
    trend : that distance over the one in the first quarter
    steady : whether it falls from each quarter to the next
    """

    period: int
    onset: int
    step: float
    trend: float
    steady: bool


def find_period(points: np.ndarray) -> Recurrence | None:
    """The shortest period of the points (n, d) that has lasted up to the last of them; None: there is none.

    From the onset on, all points a multiple of the period apart lie within TOLERANCE of the last of them,
    and they come closer to each other, or lie within EXACT: a slow drift along a curve is no period.
    And no shorter period is being approached: a spiral into a fixed point comes near itself after some turns.
    """
    for period in _periods(points):
        onset = onset_of(points, period)
        if len(points) - onset < max(LEAST_POINTS, REPEATS * period):
            continue
        return_distance = recurrence(points, period, onset)
        exact = distance_to_last(points[onset:], period).max() <= EXACT
        if exact or (onset == 0 and len(points) >= ALL):
            return return_distance
        if return_distance.trend <= SHRINKS:
            shorter = approached_period(points[onset:])
            return return_distance if shorter is None or shorter.period >= period else None
    return None


def approached_period(points: np.ndarray) -> Recurrence | None:
    """The shortest period of which the points come closer to being; None: of none."""
    for period in _periods(points):
        return_distance = recurrence(points, period, 0)
        if return_distance.step <= NEAR and return_distance.trend <= SHRINKS and return_distance.steady:
            return return_distance
    return None


def _periods(points: np.ndarray) -> range:
    return range(1, min(LONGEST, len(points) // REPEATS) + 1)


def distance_to_last(points: np.ndarray, period: int) -> np.ndarray:
    """Greatest difference of each point (n) from the last one that is a multiple of the period after it."""
    last = points[len(points) - period :]
    place = (np.arange(len(points)) - len(points)) % period
    return np.asarray(np.abs(points - last[place]).max(axis=1))


def onset_of(points: np.ndarray, period: int) -> int:
    """Position from which on all points lie within TOLERANCE of the last one of their place."""
    apart = np.flatnonzero(~(distance_to_last(points, period) <= TOLERANCE))
    return int(apart[-1]) + 1 if len(apart) else 0


def recurrence(points: np.ndarray, period: int, onset: int) -> Recurrence:
    """Distances of points a period apart from the onset on, and whether they shrink."""
    stretch = points[onset:]
    steps = np.abs(stretch[period:] - stretch[:-period]).max(axis=1)
    quarters = [float(np.quantile(part, MOSTLY)) for part in np.array_split(steps, 4) if len(part)]
    steady = all(later < earlier for earlier, later in pairwise(quarters))
    before, after = quarters[0], quarters[-1]
    return Recurrence(period, onset, after, after / before if before else 1.0, steady)


# Does the next point of a section follow from the last one?
#
# Of a deterministic motion, points that lie close are followed by points that lie close; of noise, by any.
# The measure is the error of predicting each point by what followed the nearest neighbour of the one before
# it, relative to the error of guessing.


APART = 5  # points between neighbours, at least: those next to each other in time say nothing
MOST_FOLLOWED = 2000  # points looked at, the last ones
PIECE = 500  # points whose distances are worked out at a time


def prediction_error(points: np.ndarray) -> float:
    """Median error of prediction over the median distance of any two points: near 0, or 1 for noise.

    points : (n, d); nan where there are too few, or all are the same
    """
    points = points[-MOST_FOLLOWED:]
    count = len(points) - 1
    if count < 4 * APART:
        return float("nan")
    following = points[1:]
    neighbours = np.concatenate([_nearest(points[:-1], start) for start in range(0, count, PIECE)])
    errors = _lengths(following - following[neighbours])
    shuffled = np.roll(following, count // 2, axis=0)
    guess = float(np.median(_lengths(following - shuffled)))
    return float(np.median(errors)) / guess if guess else float("nan")


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Euclidean lengths of vectors (n, d)."""
    return np.asarray(np.sqrt(total(vectors * vectors)))


def _nearest(points: np.ndarray, start: int) -> np.ndarray:
    """Positions of the nearest neighbours of a piece of the points."""
    piece = points[start : start + PIECE]
    squares = sum(np.subtract.outer(piece[:, i], points[:, i]) ** 2 for i in range(points.shape[1]))
    places = np.arange(start, start + len(piece))
    squares[np.abs(places[:, np.newaxis] - np.arange(len(points))[np.newaxis, :]) < APART] = np.inf
    return np.asarray(np.argmin(squares, axis=1))


# The section itself.


MOST = 5000  # points, the last ones of the span
NEWTON_STEPS = 2  # from an error of 1e-4 rad, which the line between two samples leaves
LEAST = 1e-3  # amplitude relative to the largest of its unit: ten times what a point may stray

Table = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class SectionPoints:
    """Points (n, d) at ascending `times` [s], without unit.

    states : the same by name of the column, SI, and `time`; sizes : by which their coordinates were divided
    """

    times: np.ndarray
    points: np.ndarray
    states: dict[str, np.ndarray] = field(default_factory=dict)
    sizes: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.times)


class SectionCoordinates:
    """The coordinates of the motion of a scene without its drift.

    They are the relative motions of pairs of ends, (y, u) each, and the velocities of what moves as a whole.
    """

    def __init__(self, scene: Scene):
        pairs = force_pairs(scene)
        free = [one for one in body_sets(scene, pairs) if not one.held]
        self._scene = scene
        self._motions = [PairMotion(scene, pair) for pair in pairs]
        self._free = [columns_of(scene.bodies[one.reference].name)[1] for one in free]
        self._turning = turning_columns(scene)
        shown = [body.columns for body in scene.bodies[len(scene.line) :] if body.columns != self._turning]
        self._others = [v for _, v in shown]
        felt = {scene.bodies[i].columns for i in felt_angles(scene)}
        self._angles = [x for x, v in shown if x is not None and (x, v) in felt]
        turning = set(whole_turn_angles(scene))
        self._turns = [i for i, pair in enumerate(pairs) if pair.P in turning and pair.Q == GROUND]
        self._pairs_of_free = [
            [i for i, pair in enumerate(pairs) if {pair.P, pair.Q} & set(one.bodies)] for one in free
        ]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Columns of states that they need."""
        columns = [name for motion in self._motions for name in motion.columns]
        return tuple(dict.fromkeys([*columns, *self._free, *self._others]))

    def of(self, states: Table) -> np.ndarray:
        """y [m] of every pair, u [m/s] of every pair, v [m/s] of what moves as a whole, speeds [rad/s] of
        further rotors and states: shape (d, n).

        states : columns by name, among them `time`
        """
        motions = [motion(states, "time") for motion in self._motions]
        rows = [motion[1] for motion in motions] + [motion[2] for motion in motions]
        rows += [np.asarray(states[name]) for name in (*self._free, *self._others)]
        return np.stack(rows) if rows else np.empty((0, len(states["time"])))

    def sizes(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """By what each of `of` is divided, from its extremes (d): see above."""
        amplitude = (high - low) / 2
        count, others = len(self._motions), len(self._others)
        lengths, speeds, whole = amplitude[:count], amplitude[count : 2 * count], amplitude[2 * count :]
        largest = np.maximum(np.abs(low), np.abs(high))[len(amplitude) - others :]
        own_sizes = np.maximum(whole[len(whole) - others :], LEAST * largest)
        whole = whole[: len(whole) - others]
        own = [
            max(speeds[pairs]) if pairs else one
            for pairs, one in zip(self._pairs_of_free, whole, strict=True)
        ]
        speeds = np.concatenate([speeds, own])
        sizes = np.concatenate(
            [*(np.maximum(part, LEAST * part.max(initial=0.0)) for part in (lengths, speeds)), own_sizes]
        )
        sizes[~(sizes > 0)] = 1.0
        return sizes

    def points(self, states: Table, sizes: np.ndarray) -> np.ndarray:
        """Points (n, d) of the states by name, each (n)."""
        rows = self.of(states)
        columns = [row / size for row, size in zip(rows, sizes, strict=True)]
        for i in self._turns:
            if sizes[i] > pi:  # more than a turn from end to end
                sine, columns[i] = sine_cosine_of_arrays(rows[i])
                columns.append(sine)
        for phi in self._angles:
            columns += reversed(sine_cosine_of_arrays(np.asarray(states[phi])))
        if self._turning is not None:
            speed = states[self._turning[1]]
            columns += [speed / (mean(speed) or 1.0), *self._phases(states["time"])]
        return np.stack(columns, axis=1)

    def _phases(self, time: np.ndarray) -> Iterator[np.ndarray]:
        """Cosine and sine of the phase of every frequency of forces and base."""
        terms = [term for term in self._scene.harmonics if term.amplitude]
        for cycles in dict.fromkeys(term.cycles for term in terms):
            sine, cosine = sine_cosine_of_arrays(TURN * np.fmod(cycles * time, 1.0))
            yield cosine
            yield sine


def section_of(result: Result, span: Span) -> SectionPoints:
    """The section of a run within the span; empty without a source."""
    times = cycle_ends(result, span.window)[-MOST:]
    if not len(times):
        return SectionPoints(times, np.empty((0, 0)))
    times, states = _turned(result, span, times)
    coordinates = SectionCoordinates(result.case.scene())
    sizes = coordinates.sizes(*extremes(result, span, coordinates))
    states = {**states, "time": times}
    return SectionPoints(times, coordinates.points(states, sizes), states, sizes)


def extremes(result: Result, span: Span, coordinates: SectionCoordinates) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest of each coordinate among the samples of the span; 0 without samples."""
    rows = rows_within(result.column("time"), span.window)
    turns = []
    for piece in pieces(rows, ROWS):
        values = coordinates.of(
            {name: np.asarray(result.column(name)[piece]) for name in ("time", *coordinates.names)}
        )
        turns.append((values.min(axis=1), values.max(axis=1)))
    if not turns:
        nothing = np.zeros(len(coordinates.of({name: np.empty(0) for name in ("time", *coordinates.names)})))
        return nothing, nothing
    low, high = (np.array(part) for part in zip(*turns, strict=True))
    return low.min(axis=0), high.max(axis=0)


def _turned(result: Result, span: Span, times: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Exact ends of the cycles and the states there."""
    scene = result.case.scene()
    window = float(times[0]) - 1.0, float(times[-1]) + 1.0
    events = events_within(result, window, before=1)
    states = states_at(scene, events, times, result.t_reached)
    turning = turning_columns(scene)
    for _ in range(0 if turning is None else NEWTON_STEPS):
        phi, w = (states[name] for name in turning or ())
        apart = phi - TURN * np.round(phi / TURN)
        step = np.divide(apart, w, out=np.zeros_like(apart), where=w > 0)
        times = np.clip(times - step, span.begin, span.end)
        states = states_at(scene, events, times, result.t_reached)
    return times, states


# The verdict on a stroboscopic section, and the evidence for it.
#
#     periodic         the points repeat themselves, up to the last one
#     transient        they come closer to repeating themselves and are not there yet; or disturbances die out
#     quasi-periodic   they lie on a curve, never repeat themselves, and the 0-1 test finds them regular
#     chaotic          each follows from the one before, and the 0-1 test finds them chaotic
#     undecided        with the reason
#
# A largest Lyapunov exponent, where it is given, has its say: a positive one where the 0-1 test finds no
# chaos is evidence against evidence, and so is another where it does. What is judged is a deterministic
# motion: noise is told apart only where it hides how points follow.


REGULAR, CHAOTIC = 0.1, 0.9  # |K| of the 0-1 test below, K above
FEWEST = 200  # points that the 0-1 test needs: with fewer, K of a regular motion strays up to 0.5
FOLLOWS = 0.3  # prediction error of a deterministic motion, at most; that of noise is 1
MOST_BANDS = 16  # of a chaotic motion that are looked for
CURVE = 10.0  # prediction error times number of points on a curve, at most


@dataclass(frozen=True)
class Exponent:
    """Largest Lyapunov exponent of a motion and the half width of its interval [1/s]."""

    value: float
    half_width: float

    @property
    def sign(self) -> int:
        """1 or -1 where the interval leaves no doubt, else 0."""
        return int(np.sign(self.value)) if abs(self.value) > self.half_width else 0


@dataclass(frozen=True)
class JudgedPoints:
    """A verdict on points and its evidence; what was not worked out is None.

    Attributes
    ----------
    verdict, reason : see above
    period : after which they repeat themselves, or come closer to doing so
    onset : position of the point from which on they do
    step : distance of points a period apart, at the end, relative to the vibration
    chaos_number : K of the 0-1 test
    prediction : error of predicting points from their neighbours, relative to guessing
    multipliers, exponents : of the orbit that a periodic motion is on, or goes to: (real, imaginary) of each
        Floquet multiplier, and the Lyapunov exponents [1/s] that follow from them, None where sticking took
        the direction
    drift_rates : mean velocity of each body on that orbit [m/s], by name
    """

    verdict: RegimeVerdict | str
    reason: str
    period: int | None = None
    onset: int | None = None
    step: float | None = None
    chaos_number: float | None = None
    prediction: float | None = None
    multipliers: tuple[tuple[float, float], ...] | None = None
    exponents: tuple[float | None, ...] | None = None
    drift_rates: dict[str, float] | None = None

    def __post_init__(self) -> None:
        name_verdict(self, RegimeVerdict)


def judge_points(points: np.ndarray, exponent: Exponent | None = None) -> JudgedPoints:
    """The regime of points (n, d), each coordinate scaled to the size of the vibration."""
    if len(points) < LEAST_POINTS:
        return JudgedPoints("undecided", f"too few cycles: {len(points)}, and {LEAST_POINTS} are needed")
    repeated = find_period(points)
    if repeated is not None:
        lasted = len(points) - repeated.onset
        reason = f"the section repeats itself within {number(TOLERANCE, 6)}, over {counted(lasted, 'cycle')}"
        return JudgedPoints("periodic", reason, repeated.period, repeated.onset, repeated.step)
    near = approached_period(points)
    if near is not None:
        before, now = number(near.step / near.trend, 2), number(near.step, 2)
        reason = f"points a period apart come closer, from {before} to {now}"
        return JudgedPoints("transient", reason, near.period, step=near.step)
    if len(points) < FEWEST:
        reason = f"no period up to {min(LONGEST, len(points) // 5)}, and {len(points)} cycles are too few"
        return JudgedPoints("undecided", f"{reason} to recognise chaos, {FEWEST} are needed")
    return _irregular(points, exponent)


def _irregular(points: np.ndarray, exponent: Exponent | None) -> JudgedPoints:
    """The verdict on points that neither repeat themselves nor come closer to it."""
    k = float(np.nanmedian([zero_one(column) for column in points.T if np.ptp(column) > EXACT]))
    prediction = prediction_error(points)
    if isnan(prediction):
        return JudgedPoints(
            "undecided", "too many points are the same to see how they follow", chaos_number=k
        )
    sign = exponent.sign if exponent else None
    verdict, reason = _weighed(k, prediction, len(points), sign)
    if verdict == "undecided" and prediction <= FOLLOWS and sign in (1, None):
        bands = bands_of(points)
        if bands > 1:
            k, prediction = _within_bands(points, bands)
            if k >= CHAOTIC and prediction <= FOLLOWS:
                verdict, known = "chaotic", ", exponent positive" if sign else ""
                reason = f"{bands} bands, gone through in turn, 0-1 test K = {k:.2f} in each or more{known}"
    return JudgedPoints(verdict, reason, chaos_number=k, prediction=prediction)


def bands_of(points: np.ndarray) -> int:
    """Number of bands that points (n, d) go through in turn: the most, up to MOST_BANDS of FEWEST points
    each, that lie apart from each other by one of the coordinates; 1 where they do not.
    """
    for count in range(min(MOST_BANDS, len(points) // FEWEST), 1, -1):
        lows, highs = (
            np.array([side(points[i::count], axis=0) for i in range(count)]) for side in (np.min, np.max)
        )
        order = np.argsort(lows, axis=0)
        lows, highs = (np.take_along_axis(each, order, axis=0) for each in (lows, highs))
        if (highs[:-1] < lows[1:]).all(axis=0).any():
            return count
    return 1


def _within_bands(points: np.ndarray, count: int) -> tuple[float, float]:
    """The least K of the 0-1 test in one of the bands, each seen by itself, and the greatest prediction
    error.

    Which band comes next is no chaos, but the greater part of the motion: over all points it hides what is.
    """
    bands = [points[i::count] for i in range(count)]
    numbers = [
        np.nanmedian([zero_one(column) for column in band.T if np.ptp(column) > EXACT]) for band in bands
    ]
    return float(min(numbers)), float(max(prediction_error(band) for band in bands))


def _weighed(k: float, prediction: float, count: int, sign: int | None) -> tuple[str, str]:
    """Verdict and reason from K, the prediction error, and the sign of the exponent (None: not known)."""
    test = f"0-1 test K = {k:.2f}"
    known = {None: "", 1: ", exponent positive", 0: ", exponent near 0", -1: ", exponent negative"}[sign]
    if prediction > FOLLOWS:
        return (
            "undecided",
            f"points do not follow from neighbours (error {prediction:.2f}): noise, or too few",
        )
    if k >= CHAOTIC and sign in (1, None):
        return "chaotic", test + known
    if sign == -1 and k < CHAOTIC:
        return "transient", f"exponent negative, so it settles; no period up to {LONGEST} is near yet"
    if abs(k) <= REGULAR and sign != 1:
        if prediction * min(count, MOST_FOLLOWED) <= CURVE:
            return "quasi-periodic", f"{test}, points on a curve" + known
        return "undecided", f"{test}, but the points lie on no curve"
    if k >= CHAOTIC or (sign == 1 and abs(k) <= REGULAR):
        return "undecided", f"{test}{known}: the one speaks against the other"
    return "undecided", f"{test}{known}: between regular and chaotic"
