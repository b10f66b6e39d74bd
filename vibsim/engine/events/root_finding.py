"""Certified first root of an event function that is a polynomial over one step."""

from collections.abc import Callable, Sequence
from math import inf
from typing import Generic

from vibsim.engine.events.records import Certificate, crosses
from vibsim.physics.numbers import Kit, N, abs, sizes_at

BEYOND = 64  # roundings: a start by so much away from zero is proved to be on its side
SHORTER = 16  # times, where a step is too long to prove that
SHORTEST = 64  # units in the last place of the time, of such a step
MARCH_LIMIT = 1000  # a march longer than this goes on from a new expansion, whose bounds are tighter
LONG_MARCH = 64  # steps from which on bounds reach less far, and are the tighter for it
NARROWER = 4  # reach of such bounds, in ways marched so far
POLISHING = 5  # Newton steps behind the first: each doubles the right digits
PIECES = 8  # a step spans less than two radians of the fastest motion: one minimum at most


class PolynomialSearch(Generic[N]):
    """Finds first roots, and watches how close the gap function comes without one."""

    def __init__(self, kit: Kit[N]) -> None:
        self.kit = kit
        self.certificate: Certificate[N] = Certificate(kit)
        self.settled = kit.power_of_two(kit.exponent(kit.eps) / 3)

    def first_root(
        self, coefficients: Sequence[N], known: int, t0: N, h: N, keep_margin: bool, sharp: bool = False
    ) -> tuple[N | None, bool]:
        """How far the polynomial in t - t0 is known to be positive: (grid time, whether it is zero there).

        coefficients: lowest first; positive at the start but for a zero there of order `known`, which is
        divided out together with any further coefficient that is exactly zero. h: length of the step [s].
        The time is None where it is positive on the whole step. keep_margin: look for a grazing minimum
        before the root or the end of the step; sharp: go to the zero by more than one Newton step where that
        is not as near as the grid of time allows.
        """
        order = leading_order(coefficients, known)
        if order == len(coefficients):
            return None, False
        series = coefficients[order:]
        total, fall, curvature, swing, truncation = self._bounds(series, h)
        error = 4 * self.kit.eps * total + truncation
        end: N | None = None
        zero = False
        if series[0] - error - fall <= 0:
            end, zero = self._march(series, error, curvature, t0, h, sharp)
        close = keep_margin and series[0] - fall < self.certificate.margin
        if close and self._may_turn(series, order, total, swing, h):
            self._watch_turns(coefficients, t0, h if end is None else end - t0)
        return end, zero

    def nearer(self, coefficients: Sequence[N], t0: N, h: N, size: N) -> N:
        """The step h [s], or a shorter one where rounding over all of h would hide on which side of zero the
        function begins, though its value there tells.

        size: sum of the magnitudes that coefficient 0 is made of
        """
        start, least = coefficients[0], SHORTEST * (self.kit.next_after(t0, inf) - t0)
        if not start > BEYOND * self.kit.eps * size:
            return h
        while h > least and start <= BEYOND * self.kit.eps * sizes_at(coefficients, h):
            h = h / SHORTER
        return h

    def value_and_slope(self, coefficients: Sequence[N], known: int, tau: N) -> tuple[N, N]:
        """Value and slope at tau of the polynomial without its known zeros (see `first_root`)."""
        order = leading_order(coefficients[:-1], known)
        return self._value_and_slope(coefficients[order:], tau)

    def near_zero(self, coefficients: Sequence[N], known: int, tau: N, size: N) -> tuple[N, N, N] | None:
        """(value, slope, rounding bound) at tau of the polynomial without its known zeros (see `first_root`);
        None where it rests at zero.

        size: sum of the magnitudes that its coefficient 0 is made of, where it is not known to be zero.
        """
        order = leading_order(coefficients, known)
        if order == len(coefficients):
            return None
        value, slope = self._value_and_slope(coefficients[order:], tau)
        noise = self._noise(coefficients[order:], tau)
        return value, slope, noise + 4 * self.kit.eps * size if order == 0 else noise

    def _bounds(self, series: Sequence[N], h: N) -> tuple[N, N, N, N, N]:
        """sum |b_n| h^n, the largest possible fall below b_0, a bound of |f''|, sum n |b_n| h^n, and a bound
        of what follows the last term.

        The last two terms bound what follows them as long as terms fall to less than 0.7 of the one before;
        the step control lets them fall to tol^(1/order), 0.16 by default.
        """
        zero = self.kit.number(0)
        total, fall, curvature, swing, power = abs(series[0]), zero, zero, zero, h
        before = term = zero
        for n in range(1, len(series)):
            before, term = term, abs(series[n]) * power
            total = total + term
            swing = swing + n * term
            if n > 1:
                curvature = curvature + n * (n - 1) * term
                fall = fall + term
            elif series[1] < 0:
                fall = fall + term
            power = power * h
        return total, fall, curvature / (h * h), swing, before + term

    @staticmethod
    def _may_turn(series: Sequence[N], order: int, total: N, swing: N, h: N) -> bool:
        """Whether f = t^order sum b_n t^n may have a minimum within h; not where it is plainly monotonic."""
        if order > 0:
            return order * series[0] <= swing + order * (total - series[0])
        return len(series) > 1 and 2 * abs(series[1]) * h <= swing

    def _march(
        self, series: Sequence[N], error: N, bound: N, t0: N, h: N, sharp: bool
    ) -> tuple[N | None, bool]:
        """March by safe steps from t0; as `first_root`.

        The function is proved positive where the polynomial stays above `error`. Where it falls below, and is
        sure to cross zero, one Newton step leads there. Otherwise the stretch is in doubt, and the march goes
        on to where the value is zero but for its rounding.
        """
        zero = self.kit.number(0)
        t, stall, near = t0, self.kit.number(1), False
        floor = noise = error
        for count in range(MARCH_LIMIT):
            tau = t - t0
            if tau > h:
                return None, False
            value, slope = self._value_and_slope(series, tau)
            if value <= error and not near:
                if crosses(slope, bound, 2 * error):
                    zero = self._zero(series, tau, value, slope, bound, t0, sharp)
                    return (self.kit.exact(t0 + zero), True) if zero <= h else (None, False)
                near = True
                self.certificate.doubt(t0)
            if near:
                floor = noise = self._noise(series, tau)
            if value < -noise or (value <= noise and slope <= 0):
                return t, True
            room = value - floor if value > floor else zero
            step = safe_step(self.kit, room, slope, bound)
            if step > h:
                return None, False
            if count >= LONG_MARCH:
                step = self._nearer_step(series, tau, room, slope, step, h)
            ahead = self.kit.exact(t0 + (tau + step))
            if ahead <= t:
                if slope < 0:
                    sure = sharp and crosses(slope, bound, 2 * error)
                    return self.kit.exact(t0 + self._zero(series, tau, value, slope, bound, t0, sure)), True
                self.certificate.doubt(t0)
                ahead = t + (self.kit.next_after(t, inf) - t) * stall
                stall = stall * 2
            else:
                stall = self.kit.number(1)
            t = ahead
        return t, False

    def _nearer_step(self, series: Sequence[N], tau: N, room: N, slope: N, step: N, h: N) -> N:
        """The safe step from tau by a bound of |f''| that reaches a few times as far as the march has come,
        or `step`, that by the bound of all h, whichever is longer.
        """
        reach = NARROWER * (tau if tau > step else step)
        if reach >= h:
            return step
        bound = self.kit.number(0)
        for n in range(len(series) - 1, 1, -1):
            bound = bound * reach + n * (n - 1) * abs(series[n])
        nearer, room_ahead = safe_step(self.kit, room, slope, bound), reach - tau
        nearer = nearer if nearer < room_ahead else room_ahead
        return nearer if nearer > step else step

    def _zero(self, series: Sequence[N], tau: N, value: N, slope: N, bound: N, t0: N, sharp: bool) -> N:
        """The zero ahead of a function that is sure to cross it: one Newton step from tau, and if it shall be
        sharp more where the error of that, by the bound of |f''|, is above the grid of time.
        """
        zero, unit = self._newton(tau, value, slope), self.kit.next_after(t0, inf) - t0
        for _ in range(POLISHING if sharp else 0):
            step = value / slope
            if bound * (step * step) <= -(2 * slope) * unit:
                break
            value, slope = self._value_and_slope(series, zero)
            if slope >= 0:
                break
            zero = self._newton(zero, value, slope)
        return zero

    @staticmethod
    def _newton(tau: N, value: N, slope: N) -> N:
        """The zero that a Newton step from tau leads to, not before the start of the step."""
        zero = tau - value / slope
        return zero if zero > 0 else 0 * tau

    def _noise(self, series: Sequence[N], tau: N) -> N:
        """Rounding bound of the value at tau."""
        return 4 * self.kit.eps * sizes_at(series, tau)

    @staticmethod
    def _value_and_slope(series: Sequence[N], tau: N) -> tuple[N, N]:
        """f and f' by Horner's rule."""
        value, slope = series[-1], series[-1] * 0
        for coefficient in reversed(series[:-1]):
            slope = slope * tau + value
            value = value * tau + coefficient
        return value, slope

    def _watch_turns(self, series: Sequence[N], t0: N, stop: N) -> None:
        """Keep the smallest minimum of the gap function within a step: slopes at PIECES points tell where."""
        slopes = [n * series[n] for n in range(1, len(series))]
        low, falling = 0 * stop, next((slope for slope in slopes if slope != 0), slopes[0])
        for i in range(1, PIECES + 1):
            high = stop * i / PIECES
            rising, _ = self._value_and_slope(slopes, high)
            if falling < 0 <= rising:
                self._turn_between(series, slopes, t0, low, high)
            low, falling = high, rising

    def _turn_between(self, series: Sequence[N], slopes: Sequence[N], t0: N, low: N, high: N) -> None:
        def slope_at(tau: N) -> tuple[N, N]:
            return self._value_and_slope(slopes, tau)

        tau, turn, depth = turning_point(slope_at, low, high, (high - low) * self.settled)
        value, _ = self._value_and_slope(series, tau)
        self.certificate.keep_turn(value - depth, t0 + turn)


# Certified first roots: steps that no root can hide in.
#
# If f > 0 at a point and |f''| <= B on the window ahead, then f stays positive for as long as its lower
# parabola q0 + q1 t - B t^2 / 2 does. Marching by that step never jumps over a root or a tangency and
# converges quadratically to a simple root. A zero known to be at the start of a window (the event that opened
# it) is divided out first.


TINY = 2.0**-960  # squares below it have lost digits to underflow
FACTORIALS = (1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800)


def safe_step(kit: Kit[N], q0: N, q1: N, bound: N) -> N:
    """Length of the stretch on which q0 + q1 t - bound t^2 / 2 is certainly positive.

    q0 >= 0: value; q1: slope; bound >= 0 on the absolute second derivative, all at the start of the stretch.
    For q1 < 0 the cancellation-free form is used. Infinite where the parabola never comes down. The step does
    not depend on the unit of f, so one that keeps squares from underflow is chosen where they would.
    """
    square = q1 * q1 + 2 * bound * q0
    if square < TINY:
        unit = max(q0, abs(q1), bound)
        if unit == 0:
            return kit.inf
        q0, q1, bound = q0 / unit, q1 / unit, bound / unit
        square = q1 * q1 + 2 * bound * q0
    root = kit.sqrt(square)
    if q1 < 0:
        return 2 * q0 / (root - q1)
    if bound == 0:
        return kit.inf
    return (q1 + root) / bound


def deflated_step(kit: Kit[N], order: int, leading: N, following: N, bound: N) -> N:
    """The safe step behind a zero of the given order at t = 0, from f / t^order.

    leading, following: derivatives of f at 0 of that order and of the next; bound: on the absolute
    derivative of order + 2. With f / t^m = int_0^1 (1 - s)^(m-1) / (m-1)! f^(m)(s t) ds, the second
    derivative of the quotient is at most 2 bound / (m + 2)!.
    """
    return safe_step(
        kit,
        leading / FACTORIALS[order],
        following / FACTORIALS[order + 1],
        2 * bound / FACTORIALS[order + 2],
    )


def leading_order(derivatives: Sequence[N], known: int) -> int:
    """Order of the first derivative that is not zero, the first `known` of them being zero by the event that
    led here.

    Returns len(derivatives) where all are zero: the function rests at zero.
    """
    order = min(known, len(derivatives))
    while order < len(derivatives) and derivatives[order] == 0:
        order += 1
    return order


# The minimum of a function between two points, by safeguarded Newton steps on its slope.


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
