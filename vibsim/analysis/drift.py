"""How fast the blocks drift, with a confidence interval.

The span is cut into blocks of a whole number of cycles; the mean displacements of neighbouring blocks differ
by the drift over one block and by what the motion does besides. The mean of these differences is the
drift rate, their scatter tells how well it is known, and correlation between them widens the interval (see
`block_averages.average`). So the interval holds where the displacement vibrates about a line, and where a
chaotic motion makes it wander.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vibsim.analysis.block_averages import FEWEST_BLOCKS, MOST_BLOCKS, average, period_of
from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.span import Span, steady_span
from vibsim.physics.sines import sine_cosine
from vibsim.physics.sums import mean
from vibsim.results.result import Result
from vibsim.results.windows import Window

DOUBT = 0.05  # probability that the interval misses the rate
STILL = 1e-12  # [m/s] a nanometre in a quarter of an hour: no drift
CYCLES = 12  # a block has a multiple of this, so of the periods 1, 2, 3, 4 and 6 that the motion may have
OF = ("x2", "centre")


@dataclass(frozen=True)
class Drift:
    """Drift rate of block 2 or the centre of mass.

    Attributes
    ----------
    verdict : "forward", "backward", "none" (the interval holds 0) or "undecided"
    reason : in words
    span : transient left out
    of : "x2" or "centre"
    rate, half_width : [m/s]; the rate lies within +- half_width in 95 of 100 cases; None where undecided
    blocks : number of blocks that the interval rests on
    """

    verdict: str
    reason: str
    span: Span
    of: str
    rate: float | None = None
    half_width: float | None = None
    blocks: int = 0


def measure_drift(result: Result, window: Window | None = None, of: str = "x2") -> Drift:
    """Drift rate within `window` [s], the second half of the run by default.

    of : "x2", or "centre" for the centre of mass of everything that moves

    Raises ValueError where block 2 is fixed, and for a window outside the run.
    """
    if of not in OF:
        raise ValueError(f"of must be one of {', '.join(OF)}, got {of!r}")
    if not result.case.two_blocks().has_block2:
        raise ValueError("nothing can drift: block 2 is fixed")
    span = steady_span(result, window)
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
    found = average(np.diff(means) / np.diff(middles), DOUBT)
    rate, half_width = found.mean, found.half_width
    verdict = "none" if abs(rate) <= max(half_width, STILL) else "forward" if rate > 0 else "backward"
    reason = f"{1 - DOUBT:.0%} interval from {len(means)} blocks"
    return Drift(verdict, reason, span, of, rate, half_width, len(means))


def block_edges(result: Result, span: Span) -> np.ndarray:
    """Ends of blocks of a whole number of cycles [s]; without a source, of vibrations."""
    ends = cycle_ends(result, span.window)
    if result.case.two_blocks().source == "none":
        period = period_of(result.case.two_blocks())
        ends = np.arange(span.begin, span.end, period) if np.isfinite(period) else np.empty(0)
    groups = (len(ends) - 1) // CYCLES
    step = CYCLES * max(1, groups // MOST_BLOCKS)
    return ends[::step] if groups > 0 else np.empty(0)


def displacement(result: Result, rows: slice, of: str) -> np.ndarray:
    """Displacement of block 2 or of the centre of mass [m], unbalanced mass included (at x1 + e cos phi)."""
    x2 = np.asarray(result.column("x2")[rows])
    if of == "x2":
        return x2
    scene = result.case.two_blocks()
    x1 = np.asarray(result.column("x1")[rows])
    moment, mass = scene.m1 * x1 + scene.m2 * x2, scene.m1 + scene.m2
    if scene.has_motor:
        cosine = sine_cosine(np.asarray(result.column("phi")[rows]))[1]
        moment = moment + scene.m3 * (x1 + scene.e * cosine)
        mass += scene.m3
    return moment / mass
