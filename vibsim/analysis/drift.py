"""How fast bodies drift, with a confidence interval.

The span is cut into blocks of a whole number of cycles; the mean displacements of neighbouring blocks differ
by the drift over one block and by what the motion does besides. The mean of these differences is the
drift rate, their scatter tells how well it is known, and correlation between them widens the interval (see
`block_averages.average`). So the interval holds where the displacement vibrates about a line, and where a
chaotic motion makes it wander. An interval that contains 0 says no way; only one that contains nothing else
says that there is no drift. Where the motion is on a periodic orbit, or goes to one, the drift of the orbit
is exact: its displacement in a period over the period.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vibsim.analysis.block_averages import FEWEST_BLOCKS, MOST_BLOCKS, average
from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.span import Span, steady_span
from vibsim.analysis.verdicts import DriftVerdict, name_verdict
from vibsim.physics.arithmetic.sines import sine_cosine
from vibsim.physics.arithmetic.sums import dot, mean, total
from vibsim.physics.body_sets import drifting_sets
from vibsim.physics.parts import Scene, columns_of
from vibsim.physics.rates import is_driven, masses, source_period
from vibsim.results.columns import tables_of
from vibsim.results.result import Result
from vibsim.results.windows import Window

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
    values = [rates[body.name] for body in scene.bodies]
    if of == CENTRE:
        return float(dot(masses(scene), np.array(values)) / total(masses(scene)))
    return values[[columns_of(body.name)[0] for body in scene.bodies].index(of)]


def _measured(result: Result, span: Span, of: str) -> Drift:
    """The drift within a span, from its samples."""
    edges = block_edges(result, span)
    if len(edges) - 1 < FEWEST_BLOCKS:
        reason = f"too short: {max(len(edges) - 1, 0)} blocks of {CYCLES} cycles, {FEWEST_BLOCKS} are needed"
        return Drift("undecided", reason, span, of)
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
    verdict, reason = _way(rate, half_width), f"{1 - DOUBT:.0%} interval from {len(means)} blocks"
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
    places = [np.asarray(result.column(columns_of(body.name)[0])[rows]) for body in scene.bodies]
    moment = sum(body.m * x for body, x in zip(scene.bodies, places, strict=True))
    mass = sum(body.m for body in scene.bodies)
    if scene.motor is not None:
        motor, cosine = scene.motor, sine_cosine(np.asarray(result.column("phi")[rows]))[1]
        moment = moment + motor.m3 * (places[motor.on] + motor.e * cosine)
        mass += motor.m3
    return np.asarray(moment / mass)
