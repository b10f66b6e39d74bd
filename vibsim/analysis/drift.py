"""Drift rates of bodies, with a confidence interval.

The span is cut into blocks of a whole number of cycles; the mean displacements of neighbouring blocks differ
by the drift over one block and by what the motion does besides. The mean of these differences is the
drift rate, their scatter tells how well it is known, and correlation between them widens the interval (see
`block_averages.average`). So the interval holds where the displacement vibrates about a line, and where a
chaotic motion makes it wander. An interval that contains 0 says no way; only one that contains nothing else
says that there is no drift. Where the motion is on a periodic orbit, or goes to one, the drift of the orbit
is exact: its displacement in a period over the period.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from vibsim.analysis.comparison import FEWEST_BLOCKS, MOST_BLOCKS, average
from vibsim.analysis.cycles import (
    DriftVerdict,
    ImpactsVerdict,
    Span,
    cycle_ends,
    events_within,
    name_verdict,
    steady_span,
)
from vibsim.cases.problems import counted
from vibsim.physics.connections import drifting_sets, event_parts
from vibsim.physics.elementary import dot, mean, sine_cosine_of_arrays, total
from vibsim.physics.parts import EVENT_KINDS, Scene, columns_of
from vibsim.physics.rates import is_driven, masses, source_period
from vibsim.results.columns import closing_velocities, tables_of
from vibsim.results.result import Result, Window

DOUBT = 0.05  # probability that the interval misses the rate
STILL = 1e-12  # [m/s] a nanometre in a quarter of an hour: no drift
CYCLES = 12  # a block has a multiple of this, so of the periods 1, 2, 3, 4 and 6 that the motion may have
CENTRE = "centre"


@dataclass(frozen=True)
class Drift:
    """Drift rate of a body or of the centre of mass.

    Attributes
    ----------
    verdict : "forward", "backward", "none" (less than STILL) or "undecided"; by `orbit_rate` where known
    reason : in words
    span : transient left out
    of : column of the displacement of the body, such as "x2", or "centre"
    rate, half_width : [m/s]; the rate lies within +- half_width in 95 of 100 cases; None where undecided
    blocks : number of blocks that the interval rests on
    orbit_rate : of the periodic orbit that the motion is on, or goes to [m/s]; None where none is known
    """

    verdict: DriftVerdict | str
    reason: str
    span: Span
    of: str
    rate: float | None = None
    half_width: float | None = None
    blocks: int = 0
    orbit_rate: float | None = None

    def __post_init__(self) -> None:
        name_verdict(self, DriftVerdict)


def drifting(scene: Scene) -> dict[str, str]:
    """The bodies whose drift is that of everything that may drift, with the columns of their displacements:
    the last body of each set that springs join, but do not hold at the ground or the base.
    """
    names = [scene.bodies[one.reference].name for one in drifting_sets(scene)]
    return {name: columns_of(name)[0] for name in names}


def measure_drift(
    result: Result,
    window: Window | None = None,
    of: str | None = None,
    orbit_rates: Mapping[str, float] | None = None,
) -> Drift:
    """Drift rate within `window` [s], the second half of the run by default.

    of : column of the displacement of a body, "centre" for the centre of mass of everything that moves; None:
        the last one of `drifting`, x2 of two blocks
    orbit_rates : mean velocity of each body [m/s], by name, on the periodic orbit that the motion is on or
        goes to: `judge_regime(result).drift_rates`, where it knows one

    Raises ValueError where springs hold all bodies, for another `of` and a window outside the run.
    """
    free, displacements = drifting(result.case.scene()), tables_of(result.case.scene()).displacements
    if of not in (None, CENTRE, *displacements):
        raise ValueError(f"of must be one of {', '.join((*displacements, CENTRE))}, got {of!r}")
    if not free:
        raise ValueError("nothing can drift: springs hold every body")
    of = of or list(free.values())[-1]
    measured = _measured(result, steady_span(result, window), of)
    if orbit_rates is None:
        return measured
    rate = _rate_of(result.case.scene(), of, orbit_rates)
    return replace(measured, verdict=_way(rate, 0.0), orbit_rate=rate)


def _rate_of(scene: Scene, of: str, rates: Mapping[str, float]) -> float:
    """The mean velocity of a body, or of the centre of mass, from those of all bodies [m/s]."""
    values = [rates[body.name] for body in scene.line]
    if of == CENTRE:
        own = masses(scene)[: len(values)]
        return float(dot(own, np.array(values)) / total(own))
    return values[[columns_of(body.name)[0] for body in scene.line].index(of)]


def _measured(result: Result, span: Span, of: str) -> Drift:
    """The drift within a span, from its samples."""
    edges = block_edges(result, span)
    if len(edges) - 1 < FEWEST_BLOCKS:
        blocks_text = f"{counted(max(len(edges) - 1, 0), 'block')} of {CYCLES} cycles"
        return Drift("undecided", f"too short: {blocks_text}, {FEWEST_BLOCKS} are needed", span, of)
    places = np.searchsorted(result.time, edges).tolist()
    if min(b - a for a, b in pairwise(places)) < 2 * CYCLES:
        return Drift("undecided", "too few samples to a block", span, of)
    blocks = [slice(a, b) for a, b in pairwise(places)]
    begin = float(displacement(result, slice(places[0], places[0] + 1), of)[0])
    means = np.array([mean(displacement(result, rows, of) - begin) for rows in blocks])
    return drift_of_blocks(means, np.array([mean(result.time[rows]) for rows in blocks]), span, of)


def drift_of_blocks(means: np.ndarray, middles: np.ndarray, span: Span, of: str = "x2") -> Drift:
    """The drift from the mean displacements [m] of neighbouring blocks and their mean times [s]."""
    velocity = average(np.diff(means) / np.diff(middles), DOUBT)
    rate, half_width = velocity.mean, velocity.half_width
    verdict, reason = _way(rate, half_width), f"{1 - DOUBT:.0%} interval from {counted(len(means), 'block')}"
    reason += ", which contains 0" if verdict == "undecided" else ""
    return Drift(verdict, reason, span, of, rate, half_width, len(means))


def _way(rate: float, half_width: float) -> str:
    """The verdict on a rate that lies within +- half_width [m/s]."""
    if abs(rate) + half_width <= STILL:
        return "none"
    if abs(rate) <= half_width:
        return "undecided"
    return "forward" if rate > 0 else "backward"


def block_edges(result: Result, span: Span) -> np.ndarray:
    """Ends of blocks of a whole number of cycles [s]; without a source, of vibrations."""
    ends = cycle_ends(result, span.window)
    scene = result.case.scene()
    if not is_driven(scene):
        period = source_period(scene)
        ends = np.arange(span.begin, span.end, period) if np.isfinite(period) else np.empty(0)
    groups = (len(ends) - 1) // CYCLES
    step = CYCLES * max(1, groups // MOST_BLOCKS)
    return ends[::step] if groups > 0 else np.empty(0)


def displacement(result: Result, rows: slice, of: str) -> np.ndarray:
    """Displacement of a body or of the centre of mass [m], unbalanced mass included (at x + e cos phi)."""
    if of != CENTRE:
        return np.asarray(result.column(of)[rows])
    scene = result.case.scene()
    places = [np.asarray(result.column(columns_of(body.name)[0])[rows]) for body in scene.line]
    moment = sum(body.m * x for body, x in zip(scene.line, places, strict=True))
    mass = sum(body.m for body in scene.line)
    for rotor in scene.rotors:
        phi, _ = scene.bodies[rotor.column].columns
        assert phi is not None
        cosine = sine_cosine_of_arrays(np.asarray(result.column(phi)[rows]))[1]
        moment = moment + rotor.unbalance * cosine
    if scene.motor is not None:
        motor, cosine = scene.motor, sine_cosine_of_arrays(np.asarray(result.column("phi")[rows]))[1]
        moment = moment + motor.m3 * (places[motor.on] + motor.e * cosine)
        mass += motor.m3
    return np.asarray(moment / mass)


# What happens in each cycle of the source: impacts, sticks, and the word that the events spell.


# letter of each event in a word; c ... o is a contact, s ... g a stick, r a reversal; of a rigid stop i is an
# impact, t one passed on to it, h the end of a sequence, b ... e a rest
LETTERS = {"contact_begin": "c", "contact_end": "o", "reversal": "r", "stick_begin": "s", "stick_end": "g"}
LETTERS |= {"impact": "i", "transmitted": "t", "chatter": "h", "rest_begin": "b", "rest_end": "e"}
MOST_WORDS = 8  # listed


@dataclass(frozen=True)
class RateSpread:
    """Distribution of a quantity: number, mean, least, median, greatest, and their unit."""

    count: int
    mean: float
    least: float
    median: float
    greatest: float
    unit: str


@dataclass(frozen=True)
class ImpactsPerCycle:
    """Counts of impacts and of other events in the cycles of the source within a span.

    Attributes
    ----------
    verdict : "every cycle", "some cycles", "no impacts" (of a friction "no sticks") or "undecided"
    reason : in words
    cycles : whole cycles counted
    impacts, sticks : mean per cycle; None without a cycle, and of a part that has none by its kind
    impact_counts, stick_counts : number of events in a cycle -> number of such cycles
    words : the commonest words -> number of cycles, see LETTERS; "" is a cycle without events
    distinct_words : how many there are
    velocity : relative speed of the ends of the stop at impact [m/s]; None without impacts
    """

    verdict: ImpactsVerdict | str
    reason: str
    span: Span
    cycles: int = 0
    impacts: float | None = None
    sticks: float | None = None
    impact_counts: dict[int, int] | None = None
    stick_counts: dict[int, int] | None = None
    words: dict[str, int] | None = None
    distinct_words: int = 0
    velocity: RateSpread | None = None

    def __post_init__(self) -> None:
        name_verdict(self, ImpactsVerdict)


def counted_parts(scene: Scene) -> tuple[str, ...]:
    """The parts whose events are counted one by one: stops and frictions where there is a stop, and more than
    one of either; none where all events are counted together.
    """
    if len(scene.stops) <= 1 and len(scene.frictions) <= 1:
        return ()
    parts: tuple[Any, ...] = (*scene.stops, *scene.frictions)
    return tuple(part.name for part in parts)


def count_impacts(result: Result, window: Window | None = None, part: str | None = None) -> ImpactsPerCycle:
    """Impacts and stick phases per cycle within `window` [s], by default the second half of the run.

    part : the stop or friction whose events count; None: all events

    Raises ValueError for a window outside the run, and where there is no such part.
    """
    scene = result.case.scene()
    stops = [stop.name for stop in scene.stops]
    frictions = [friction.name for friction in scene.frictions]
    if part not in (None, *stops, *frictions):
        raise ValueError(f"part must be one of {', '.join((*stops, *frictions))}, got {part!r}")
    span = steady_span(result, window)
    ends = cycle_ends(result, span.window)
    speed = speeds(result, span, part)
    if len(ends) < 2:
        return ImpactsPerCycle("undecided", "no whole cycle of a source", span, velocity=speed)
    words = words_of(result, ends, part)
    impacts, sticks = ([sum(map(word.count, letters)) for word in words] for letters in ("ci", "s"))
    own, noun = (sticks, "sticks") if part in frictions else (impacts, "impacts")
    cycles, happened = len(words), sum(map(bool, own))
    verdict = f"no {noun}" if not happened else "every cycle" if happened == cycles else "some cycles"
    counts = ImpactsPerCycle(
        verdict,
        f"{noun} in {happened} of {counted(cycles, 'cycle')}",
        span,
        cycles,
        sum(impacts) / cycles,
        sum(sticks) / cycles,
        dict(sorted(Counter(impacts).items())),
        dict(sorted(Counter(sticks).items())),
        dict(Counter(words).most_common(MOST_WORDS)),
        len(set(words)),
        speed,
    )
    if part in stops:
        return replace(counts, sticks=None, stick_counts=None)
    return replace(counts, impacts=None, impact_counts=None) if part in frictions else counts


def words_of(result: Result, ends: np.ndarray, part: str | None = None) -> list[str]:
    """The word of each cycle between ascending `ends` [s]: an event at an end belongs to the next cycle.

    part : whose events count; None: those of all parts
    """
    events = events_within(result, (float(ends[0]), float(ends[-1])), "t", "kind", "part")
    if part is not None:
        own = events["part"] == event_parts(result.case.scene()).index(part)
        events = {name: column[own] for name, column in events.items()}
    letters = {EVENT_KINDS[kind]: letter for kind, letter in LETTERS.items()}
    text = "".join(letters.get(kind, " ") for kind in events["kind"].tolist())
    edges = np.searchsorted(events["t"], ends, side="left").tolist()
    return [text[a:b].replace(" ", "") for a, b in pairwise(edges)]


def happenings(result: Result, ends: np.ndarray) -> list[bytes]:
    """Kinds and parts of the events in each cycle between ascending `ends` [s], in order."""
    events = events_within(result, (float(ends[0]), float(ends[-1])), "t", "kind", "part")
    counted = np.isin(events["kind"], [EVENT_KINDS[kind] for kind in LETTERS])
    codes = np.stack([events["kind"], events["part"]], axis=1).astype("i4")[counted]
    edges = np.searchsorted(events["t"][counted], ends, side="left").tolist()
    return [codes[a:b].tobytes() for a, b in pairwise(edges)]


def speeds(result: Result, span: Span, part: str | None = None) -> RateSpread | None:
    """Relative speed |v_P - v_Q| of the ends of the stop `part`, of all stops if None, at the impacts within
    the span; None without impacts.
    """
    scene = result.case.scene()
    events = events_within(result, span.window)
    values = np.abs(closing_velocities(scene, events))
    own = np.isin(events["part"], [i for i, stop in enumerate(scene.stops) if part in (None, stop.name)])
    values = values[own & ~np.isnan(values)]
    return spread(values, f"{scene.unit_of_stops(part)}/s") if len(values) else None


def spread(values: np.ndarray, unit: str) -> RateSpread:
    """The distribution of at least one value."""
    least, median, greatest = (float(value) for value in np.quantile(values, [0, 0.5, 1]))
    return RateSpread(len(values), float(mean(values)), least, median, greatest, unit)
