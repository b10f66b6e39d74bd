"""The largest Lyapunov exponent of a run: its case run again with a disturbance carried through it.

How fast the disturbance grows is taken over blocks of the span; their scatter tells how well its mean is
known. With a motor the exponent is at least 0, that of a shift in time; a periodic motion under an ideal
source has a negative one.
"""

from dataclasses import replace

import numpy as np

from vibsim.analysis.block_averages import average
from vibsim.analysis.regime.points import Exponent
from vibsim.analysis.span import steady_span
from vibsim.engine.tangent.lyapunov import lyapunov_exponents
from vibsim.results.result import Result
from vibsim.results.windows import Window

BLOCKS = 10
EPS = 2.0**-52  # the rounding of each value of the growth, relative to what it has grown by
DOUBT = 0.05  # probability that the interval misses the exponent


def largest_exponent(result: Result, window: Window | None = None, engine: str = "auto") -> Exponent | None:
    """The largest Lyapunov exponent within `window` [s], by default the second half of the run.

    None where the span is too short for intervals, where sticking or rest wiped the disturbance out, and
    where the motion has no derivative. Costs one more run on `engine`. Raises ValueError for a window outside
    the run.
    """
    span = steady_span(result, window)
    scene = replace(result.case.scene(), t_end=span.end)
    growth = lyapunov_exponents(scene, 1, span.begin, engine).growth
    return exponent_of(growth[:, 0], growth[:, 1]) if len(growth) else None


def exponent_of(times: np.ndarray, growth: np.ndarray) -> Exponent | None:
    """The exponent from the logarithm of a disturbance's growth (n) at ascending times [s] (n).

    None with fewer than two values to a block, and where the growth is not finite.
    """
    if len(times) < 2 * BLOCKS + 1 or not np.all(np.isfinite(growth)):
        return None
    edges = np.linspace(0, len(times) - 1, BLOCKS + 1).round().astype(int)
    rate = average(np.diff(growth[edges]) / np.diff(times[edges]), DOUBT)
    rounding = len(growth) * EPS * (1 + np.abs(growth).max()) / (times[-1] - times[0])
    return Exponent(rate.mean, max(rate.half_width, float(rounding)))
