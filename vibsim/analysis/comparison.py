"""Two runs compared, with a defined verdict.

    identical            the same samples and events, bit for bit
    agree                displacements within the tolerance over the whole common span
    agree_until          within the tolerance up to `agree_until`; the rest is too short for statistics
    agree_in_statistics  within the tolerance up to `agree_until`, and beyond it no statistic differs clearly
    differ               a statistic differs clearly beyond `agree_until`, or they differ from the start

Chaotic runs part, however well they are computed: their statistics are what can be right to the end.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import hypot, inf, pi, sqrt
from typing import Any

import numpy as np

from vibsim.analysis.cycles import ComparisonVerdict, name_verdict
from vibsim.engine.blocks_ahead import instants_per_sample, sampled_finer
from vibsim.physics.connections import drifting_sets, pairs_of
from vibsim.physics.elementary import dot, mean
from vibsim.physics.parts import ROTOR, STATE, Scene, columns_of
from vibsim.physics.rates import source_period
from vibsim.results.columns import IMPACT_CODES, PairMotion, tables_of
from vibsim.results.result import Result, pieces, rows_within

# What a long motion does on the average, with confidence intervals from block averages.
#
# The span is cut into blocks of equal length, each of several periods of the source. The averages of the
# blocks scatter about the average of the whole; where they are long enough to be nearly independent, their
# scatter tells how well it is known. What correlation is left between neighbours widens the interval.


MOST_BLOCKS, FEWEST_BLOCKS = 20, 8
PERIODS = 5  # in a block, at least
FEWEST_SAMPLES = 20  # in a block, four to a period, for statistics of samples
FEWEST_INDEPENDENT = 3.0  # even of blocks that all drift one way: Student's distribution of 2 degrees
MEAN = "mean "  # before the name of a state
OF = " of "  # before the name of the part or body where there are several
UNITS = {
    "motor speed": "Hz",
    "rotor speed": "Hz",
    "impact rate": "1/s",
}

Span = tuple[float, float]


@dataclass(frozen=True)
class Average:
    """Mean of a statistic over a span, and the half width of its confidence interval, in its unit."""

    mean: float
    half_width: float


def blocks_of(span: Span, period: float) -> list[Span]:
    """The span [s] in blocks of equal length, several periods [s] each; none where it is too short."""
    length = span[1] - span[0]
    count = min(MOST_BLOCKS, int(length / (PERIODS * period)))
    if count < FEWEST_BLOCKS:
        return []
    edges = np.linspace(*span, count + 1).tolist()
    return list(pairwise(edges))


def unit_of(statistic: str, scene: Scene) -> str:
    """The unit of a statistic of `block_values`; angles are in rad."""
    if statistic.startswith(MEAN):
        return dict(scene.state_units).get(statistic.removeprefix(MEAN), "")
    kind, _, name = statistic.partition(OF)
    if kind == "amplitude":
        pair = next(pair for pair in pairs_of(scene) if name in ("", pair.name))
        return scene.unit_between(pair.P, pair.Q)
    if kind == "drift rate":
        moving = [scene.bodies[one.reference] for one in drifting_sets(scene)]
        return f"{scene.unit_of(next(body for body in moving if name in ('', body.name)))}/s"
    return UNITS[kind]


def block_values(result: Result, blocks: list[Span]) -> dict[str, np.ndarray]:
    """Statistics of every block by name, those that the scene has and that its samples are enough for.

    amplitude of each relative motion (`pairs_of`), drift rate of each set of bodies that may drift, motor
    speed, speed of each rotor, mean of each state, impact rate of each stop; of several the part or body is
    named: "impact rate of wall".
    """
    time, event_time = result.time, result.events["t"]
    rows = [rows_within(time, block) for block in blocks]
    enough = min(part.stop - part.start for part in rows) >= FEWEST_SAMPLES
    averages = [
        (_of_samples(result, part, time) if enough else {}) | _of_events(result, event_time, block)
        for part, block in zip(rows, blocks, strict=True)
    ]
    return {name: np.array([values[name] for values in averages]) for name in averages[0]}


def averages(values: Mapping[str, np.ndarray], doubt: float) -> dict[str, Average]:
    """Mean of each statistic; its interval misses the true mean with probability `doubt`."""
    return {name: average(blocks, doubt) for name, blocks in values.items()}


def average(blocks: np.ndarray, doubt: float) -> Average:
    """Mean of block averages (1-D), its interval by Student's distribution.

    Of n blocks whose neighbours have the correlation r, n (1 - r)/(1 + r) count as independent.
    """
    from scipy.special import stdtrit

    count, middle = len(blocks), float(mean(blocks))
    apart = blocks - middle
    squares = float(dot(apart, apart))
    variance = squares / (count - 1)
    neighbours = float(dot(apart[1:], apart[:-1])) / squares if squares else 0.0
    correlation = max(neighbours, 0.0)
    independent = max(FEWEST_INDEPENDENT, count * (1 - correlation) / (1 + correlation))
    return Average(middle, float(stdtrit(independent - 1, 1 - doubt / 2)) * sqrt(variance / independent))


def _of_samples(result: Result, rows: slice, time: np.ndarray) -> dict[str, float]:
    """Amplitude (sqrt(2) rms of x_P - x_Q about its mean), drift rate, speeds of motor and rotors, states."""
    scene = result.case.scene()
    clock = time[rows]
    averages: dict[str, float] = {}
    pairs = pairs_of(scene)
    for pair in pairs:
        motion = PairMotion(scene, pair)
        columns = {name: np.asarray(result.column(name)[rows]) for name in motion.columns}
        y = motion({"time": clock, **columns}, "time")[1]
        apart = y - mean(y)
        averages[_named("amplitude", pair, pairs)] = sqrt(2 * float(mean(apart * apart)))
    moving = [scene.bodies[one.reference] for one in drifting_sets(scene)]
    for body in moving:
        x = result.column(columns_of(body.name)[0])[rows]
        averages[_named("drift rate", body, moving)] = float(x[-1] - x[0]) / float(clock[-1] - clock[0])
    if scene.has_motor:
        averages["motor speed"] = float(mean(result.column("phidot")[rows])) / (2 * pi)
    rotors = [body for body in scene.bodies if body.kind == ROTOR]
    for body in rotors:
        speed = result.column(body.columns[1])[rows]
        averages[_named("rotor speed", body, rotors)] = float(mean(speed)) / (2 * pi)
    for body in scene.bodies:
        if body.kind == STATE:
            averages[f"{MEAN}{body.name}"] = float(mean(result.column(body.columns[1])[rows]))
    return averages


def _of_events(result: Result, times: np.ndarray, block: Span) -> dict[str, float]:
    """Impacts per second at each stop."""
    stops = result.case.scene().stops
    if not stops:
        return {}
    rows = rows_within(times, block)
    part = result.events["part"][rows]
    part = part[np.isin(result.events["kind"][rows], IMPACT_CODES)]
    length = block[1] - block[0]
    return {
        _named("impact rate", stop, stops): np.count_nonzero(part == number) / length
        for number, stop in enumerate(stops)
    }


def _named(statistic: str, one: Any, among: Sequence[Any]) -> str:
    """The name of a statistic, with that of its part or body where there are several."""
    return statistic if len(among) == 1 else f"{statistic}{OF}{one.name}"


DOUBT = 0.01  # probability that runs of the same statistics are told apart by any of them
RESOLUTION = 1e-9  # relative difference of two means that rounding can make
TRANSIENT = 0.5  # share of what lies beyond the agreement that is left out of the statistics, as in sweeps
ROWS = 1 << 20  # compared at a time
RESTARTED = 1 << 12  # the same, of instants that are not stored
WORDS = {
    "identical": "identical",
    "agree": "agree",
    "agree_until": "agree for a time",
    "agree_in_statistics": "agree in statistics",
    "differ": "differ",
}

Table = Mapping[str, np.ndarray]
Distances = tuple[np.ndarray, np.ndarray]  # times [s] and distances [m]


@dataclass(frozen=True)
class RunDifference:
    """One item in which two runs differ: a case value, engine, method, version; "-" where a run has none."""

    key: str
    a: str
    b: str


@dataclass(frozen=True)
class ComparedStatistic:
    """One statistic of both runs beyond the time up to which they agree."""

    name: str
    unit: str
    a: Average
    b: Average

    @property
    def differs(self) -> bool:
        """Whether the means are further apart than their intervals allow, or are no numbers."""
        rounding = RESOLUTION * max(abs(self.a.mean), abs(self.b.mean))
        allowed = hypot(self.a.half_width, self.b.half_width) + rounding
        return not abs(self.a.mean - self.b.mean) <= allowed < inf


@dataclass(frozen=True)
class Comparison:
    """The verdict on two runs and what it rests on.

    Attributes
    ----------
    verdict : one of WORDS
    tolerance : within which displacements agree [m]
    agree_until : last instant looked at within it [s], a common sample or one between samples that are far
        apart; None where the first is not
    span : end of what both runs have [s]
    differences : of case, engine and method
    statistics : of the later half of what lies beyond agree_until; empty where that is too short, or nothing
    statistics_from : where that half begins [s]
    """

    verdict: ComparisonVerdict | str
    tolerance: float
    agree_until: float | None
    span: float
    differences: list[RunDifference]
    statistics: list[ComparedStatistic]
    statistics_from: float | None = None

    def __post_init__(self) -> None:
        name_verdict(self, ComparisonVerdict)


def compare(a: Result, b: Result, tolerance: float) -> Comparison:
    """Compare two trajectories; displacements agree when they are within `tolerance` [m].

    Raises ValueError where the runs have no instant or no displacement in common.
    """
    differences = list(differing(a, b))
    if identical(a, b):
        return Comparison("identical", tolerance, a.t_reached, a.t_reached, differences, [])
    span = min(a.t_reached, b.t_reached)
    until, parted = agreement(a, b, tolerance)
    if not parted:
        return Comparison("agree", tolerance, until, span, differences, [])
    start = (until or 0.0) + TRANSIENT * (span - (until or 0.0))
    statistics = compared_statistics(a, b, start, span)
    return Comparison(_verdict(until, statistics), tolerance, until, span, differences, statistics, start)


def _verdict(until: float | None, statistics: list[ComparedStatistic]) -> str:
    if any(statistic.differs for statistic in statistics):
        return "differ"
    if statistics:
        return "agree_in_statistics"
    return "agree_until" if until else "differ"


def differing(a: Result, b: Result) -> Iterator[RunDifference]:
    """Case values, engine, method, digits and version that are not the same."""
    ours, theirs = _facts(a), _facts(b)
    for key in dict.fromkeys([*ours, *theirs]):
        (shown_a, exact_a), (shown_b, exact_b) = ours.get(key, ("-", None)), theirs.get(key, ("-", None))
        if exact_a != exact_b:
            yield RunDifference(key, shown_a, shown_b)


def _facts(result: Result) -> dict[str, tuple[str, Any]]:
    """Key -> text and exact value of everything that makes a run what it is."""
    values = {key: value for key, value in result.case.values.items() if key not in ("name", "title")}
    facts = {key: (str(value), _exact(value)) for key, value in values.items()}
    attrs = {key: result.attrs.get(key) for key in ("engine", "method", "digits", "vibsim_version")}
    return facts | {key: (str(value), value) for key, value in attrs.items() if value is not None}


def _exact(value: Any) -> Any:
    return (value.value, value.per_turn) if hasattr(value, "per_turn") else value


def identical(a: Result, b: Result) -> bool:
    """Whether all samples and events are the same bit for bit; the judgement of their error is left aside."""
    names = [[name for name in result if name != "error_estimate"] for result in (a, b)]
    if names[0] != names[1] or len(a) != len(b) or set(a.events) != set(b.events):
        return False
    return all(_same(a.column(name), b.column(name)) for name in names[0]) and all(
        _same(a.event_column(name), b.event_column(name)) for name in a.events
    )


def _same(ours: Any, theirs: Any) -> bool:
    if len(ours) != len(theirs):
        return False
    return all(ours[rows].tobytes() == theirs[rows].tobytes() for rows in pieces(slice(0, len(ours)), ROWS))


def agreement(a: Result, b: Result, tolerance: float) -> tuple[float | None, bool]:
    """Last instant [s] up to which the displacements agree, None: not at the first; whether they then part.

    Raises ValueError where the runs have no instant in common.
    """
    last = None
    for time, distance in _distances(a, b):
        beyond = np.flatnonzero(~(distance <= tolerance))
        if len(beyond):
            return (float(time[beyond[0] - 1]) if beyond[0] else last), True
        last = float(time[-1])
    if last is None:
        raise ValueError("the two runs have no instant in common")
    return last, False


def _distances(a: Result, b: Result) -> Iterator[Distances]:
    """Common instants [s] and the largest |dx| of any body there [m], in pieces.

    They are the samples of the run that has fewer; where those are too far apart to judge by, others between.
    """
    coarse, fine = (a, b) if len(a) <= len(b) else (b, a)
    times = coarse.time[coarse.time <= fine.t_reached]
    if not len(times):
        return
    names = list(dict.fromkeys(name for run in (a, b) for name in displacements(run)))
    if not set(displacements(a)) & set(displacements(b)):
        of_each = " and ".join(", ".join(displacements(run)) for run in (a, b))
        raise ValueError(f"the two runs have no displacement in common: {of_each}")
    count = instants_per_sample(coarse.case.scene())
    if count > 1:
        yield from _between_samples(coarse, fine, names, count)
        return
    indices = np.searchsorted(fine.time, times)
    stored = np.array_equal(fine.time[np.minimum(indices, len(fine) - 1)], times)
    for rows in pieces(slice(0, len(times)), ROWS):
        ours = {name: coarse.column(name)[rows] for name in names if name in coarse}
        theirs = _picked(fine, names, indices[rows]) if stored else fine.at(times[rows])
        yield times[rows], _apart(ours, theirs, names)


def displacements(result: Result) -> tuple[str, ...]:
    """Names of the displacements of the bodies of a run; of its rotors and states where it has no body."""
    return tables_of(result.case.scene()).deciding


def _between_samples(a: Result, b: Result, names: list[str], count: int) -> Iterator[Distances]:
    """The same at `count` instants to each sample of `a`, both runs restarted from their events."""
    scene = replace(sampled_finer(a.case.scene(), count), t_end=min(a.t_reached, b.t_reached))
    total = scene.sample_count
    for first in range(0, total, RESTARTED):
        times = np.array([scene.sample_time(i) for i in range(first, min(first + RESTARTED, total))])
        yield times, _apart(a.at(times), b.at(times), names)


def _apart(ours: Table, theirs: Table, names: list[str]) -> np.ndarray:
    """The largest |dx| [m]; a body missing from a run counts as at 0."""
    still = np.zeros(len(next(iter(ours.values()))))
    return np.asarray(
        np.max([np.abs(ours.get(name, still) - theirs.get(name, still)) for name in names], axis=0)
    )


def _picked(result: Result, names: list[str], rows: np.ndarray) -> dict[str, np.ndarray]:
    """Columns at ascending rows."""
    span = slice(int(rows[0]), int(rows[-1]) + 1)
    return {name: result.column(name)[span][rows - rows[0]] for name in names if name in result}


def compared_statistics(a: Result, b: Result, start: float, end: float) -> list[ComparedStatistic]:
    """Statistics that both runs have, over [start, end] [s]; none where that is too short."""
    period = max(source_period(run.case.scene()) for run in (a, b))
    blocks = blocks_of((start, end), period)
    if not blocks:
        return []
    with np.errstate(over="ignore", invalid="ignore"):  # a mean that is no number differs from any
        values = [block_values(result, blocks) for result in (a, b)]
        common = [name for name in values[0] if name in values[1]]
        ours, theirs = (averages(samples, DOUBT / len(common)) for samples in values)
    return [
        ComparedStatistic(name, unit_of(name, a.case.scene()), ours[name], theirs[name]) for name in common
    ]
