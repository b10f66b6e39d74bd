"""Two runs compared, with a defined verdict.

    identical            the same samples and events, bit for bit
    agree                displacements within the tolerance over the whole common span
    agree_until          within the tolerance up to `agree_until`; the rest is too short for statistics
    agree_in_statistics  within the tolerance up to `agree_until`, and beyond it no statistic differs clearly
    differ               a statistic differs clearly beyond `agree_until`, or they differ from the start

Chaotic runs part, however well they are computed: their statistics are what can be right to the end.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import hypot, inf
from typing import Any

import numpy as np

from vibsim.analysis.block_averages import Average, averages, block_values, blocks_of, unit_of
from vibsim.analysis.verdicts import ComparisonVerdict, name_verdict
from vibsim.physics.rates import source_period
from vibsim.results.columns import tables_of
from vibsim.results.recording.cadence import instants_per_sample, sampled_finer
from vibsim.results.result import Result
from vibsim.results.windows import pieces

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
class Difference:
    """What two runs do not share: a case value, engine, method, version; "-" where a run has none."""

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
    differences: list[Difference]
    statistics: list[ComparedStatistic]
    statistics_from: float | None = None

    def __post_init__(self) -> None:
        name_verdict(self, ComparisonVerdict)


def compare(a: Result, b: Result, tolerance: float) -> Comparison:
    """Compare two trajectories; displacements agree when they are within `tolerance` [m].

    Raises ValueError where the runs have no instant in common.
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


def differing(a: Result, b: Result) -> Iterator[Difference]:
    """Case values, engine, method, digits and version that are not the same."""
    ours, theirs = _facts(a), _facts(b)
    for key in dict.fromkeys([*ours, *theirs]):
        (shown_a, exact_a), (shown_b, exact_b) = ours.get(key, ("-", None)), theirs.get(key, ("-", None))
        if exact_a != exact_b:
            yield Difference(key, shown_a, shown_b)


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
    """Names of the displacements of the bodies of a run."""
    return tables_of(result.case.scene()).displacements


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
    return [ComparedStatistic(name, unit_of(name), ours[name], theirs[name]) for name in common]
