"""Certified first root of an event function that is a polynomial over one step."""

from math import inf

from vibsim.events.first_root import safe_step

MARCH_LIMIT = 10000
PIECES = 8  # a step spans less than two radians of the fastest motion: one minimum at most
TURNING = 60


class PolynomialSearch:
    """Finds first roots and keeps the smallest value that the gap function turned round at without
    crossing.
    """

    def __init__(self, kit):
        self.kit = kit
        self.margin, self.margin_time = inf, kit.number(0)
        self.uncertified = 0
        self.settled = kit.power_of_two(kit.exponent(kit.eps) / 3)

    def first_root(self, coefficients, known, t0, h, keep_margin):
        """Grid time of the first zero in (t0, t0 + h] of the polynomial in t - t0, or None.

        coefficients: lowest first; positive at the start but for a zero there of order `known`, which is
        divided out together with any further coefficient that is exactly zero. keep_margin: look for a
        grazing minimum before the root or the end of the step.
        """
        order = known
        while order < len(coefficients) and coefficients[order] == 0:
            order += 1
        if order == len(coefficients):
            return None
        series = coefficients[order:]
        total, fall, curvature, swing = self._bounds(series, h)
        noise = 4 * self.kit.eps * total
        root = None
        if series[0] - noise - fall <= 0:
            root = self._march(series, noise, curvature, t0, h)
        if keep_margin and series[0] - fall < self.margin and self._may_turn(series, order, total, swing, h):
            self._watch_turns(coefficients, t0, h if root is None else root - t0)
        return root

    def _bounds(self, series, h):
        """sum |b_n| h^n, the largest possible fall below b_0, a bound of |f''|, and sum n |b_n| h^n."""
        zero = self.kit.number(0)
        total, fall, curvature, swing, power = abs(series[0]), zero, zero, zero, h
        for n in range(1, len(series)):
            term = abs(series[n]) * power
            total = total + term
            swing = swing + n * term
            if n > 1:
                curvature = curvature + n * (n - 1) * term
                fall = fall + term
            elif series[1] < 0:
                fall = fall + term
            power = power * h
        return total, fall, curvature / (h * h), swing

    @staticmethod
    def _may_turn(series, order, total, swing, h):
        """Whether f = t^order sum b_n t^n may have a minimum within h; not where it is plainly monotonic."""
        if order > 0:
            return order * series[0] <= swing + order * (total - series[0])
        return len(series) > 1 and 2 * abs(series[1]) * h <= swing

    def _march(self, series, noise, bound, t0, h):
        """March by safe steps from t0 to the first zero; None where t0 + h comes first."""
        zero = self.kit.number(0)
        t, stall = t0, self.kit.number(1)
        for _ in range(MARCH_LIMIT):
            tau = t - t0
            if tau > h:
                return None
            value, slope = self._value_and_slope(series, tau)
            if value < -noise or (value <= noise and slope <= 0):
                return t
            room = value - noise if value > noise else zero
            step = safe_step(self.kit, room, slope, bound)
            if step > h:
                return None
            ahead = self.kit.exact(t0 + (tau + step))
            if ahead <= t:
                if slope < 0:
                    return t
                self.uncertified += 1
                ahead = t + (self.kit.next_after(t, inf) - t) * stall
                stall = stall * 2
            else:
                stall = self.kit.number(1)
            t = ahead
        self.uncertified += 1
        return None

    @staticmethod
    def _value_and_slope(series, tau):
        """f and f' by Horner's rule."""
        value, slope = series[-1], series[-1] * 0
        for coefficient in reversed(series[:-1]):
            slope = slope * tau + value
            value = value * tau + coefficient
        return value, slope

    def _watch_turns(self, series, t0, stop):
        """Keep the smallest minimum of the gap function within a step: slopes at PIECES points tell where."""
        slopes = [n * series[n] for n in range(1, len(series))]
        low, falling = 0 * stop, slopes[0]
        for i in range(1, PIECES + 1):
            high = stop * i / PIECES
            rising, _ = self._value_and_slope(slopes, high)
            if falling < 0 <= rising:
                self._turn_between(series, slopes, t0, low, high)
            low, falling = high, rising

    def _turn_between(self, series, slopes, t0, low, high):
        """Keep the minimum between two points, by safeguarded Newton steps on the slope."""
        tau, settled = low + (high - low) / 2, (high - low) * self.settled
        for _ in range(TURNING):
            slope, curvature = self._value_and_slope(slopes, tau)
            low, high = (tau, high) if slope < 0 else (low, tau)
            ahead = tau - slope / curvature if curvature > 0 else low
            if curvature > 0 and abs(ahead - tau) < settled:
                break
            if not low < ahead < high:
                ahead = low + (high - low) / 2
            tau = ahead
        value, _ = self._value_and_slope(series, tau)
        if curvature > 0:
            value = value - slope * slope / (2 * curvature)
        value = value if value > 0 else 0 * tau
        if value < self.margin:
            self.margin, self.margin_time = value, t0 + ahead
