"""The minimum of a function between two points, by safeguarded Newton steps on its slope."""

from collections.abc import Callable

from vibsim.physics.arithmetic.numbers import Kit, N, abs

TURNING = 60


def extreme_of_slope(kit: Kit[N], length: N, before: N, bend: N, after: N, unbend: N) -> N:
    """Where a slope has its extreme within `length`, from its cubic: values before and after, derivatives
    bend and unbend of opposite signs there.
    """
    mean = (after - before) / length
    b, a = 6 * mean - 4 * bend - 2 * unbend, 3 * (bend + unbend) - 6 * mean
    root = kit.sqrt(b * b - 4 * a * bend)
    return length * (2 * bend / (root - b if bend > 0 else -root - b))


def turning_point(slope_at: Callable[[N], tuple[N, N]], low: N, high: N, settled: N) -> tuple[N, N, N]:
    """Where a function with a falling slope at `low` and a rising one at `high` turns round.

    slope_at(t) -> (slope, curvature); settled: length of a step behind which the next one is round-off.
    Returns (point evaluated last, place of the minimum by one more Newton step, its depth below the value at
    the point evaluated last).
    """
    ahead = low + (high - low) / 2
    for _ in range(TURNING):
        t = ahead
        slope, curvature = slope_at(t)
        low, high = (t, high) if slope < 0 else (low, t)
        ahead = t - slope / curvature if curvature > 0 else low
        if curvature > 0 and abs(ahead - t) < settled:
            break
        if not low < ahead < high:
            ahead = low + (high - low) / 2
    depth = slope * slope / (2 * curvature) if curvature > 0 else 0 * slope
    return t, ahead, depth
