"""Certified first root of an event function that is a polynomial over one step."""

from math import inf

from vibsim.events.first_root import safe_step

MARCH_LIMIT = 10000


class PolynomialSearch:
    """Finds first roots and keeps the smallest value that the gap function turned round at without
    crossing.
    """

    def __init__(self, kit):
        self.kit = kit
        self.margin, self.margin_time = inf, kit.number(0)
        self.uncertified = 0

    def first_root(self, coefficients, known, t0, h, keep_margin):
        """Grid time of the first zero in (t0, t0 + h] of the polynomial in t - t0, or None.

        coefficients: lowest first; positive at the start but for a zero there of order `known`, which is
        divided out together with any further coefficient that is exactly zero. keep_margin: look for a
        grazing minimum where there is no root.
        """
        order = known
        while order < len(coefficients) and coefficients[order] == 0:
            order += 1
        if order == len(coefficients):
            return None
        series = coefficients[order:]
        total, fall, curvature, turn = self._bounds(series, h)
        noise = 4 * self.kit.eps * total
        root = None
        if series[0] - noise - fall <= 0:
            root = self._march(series, noise, curvature, t0, h)
        if root is None and keep_margin and turn:
            self._graze(coefficients, t0, h)
        return root

    def _bounds(self, series, h):
        """sum |b_n| h^n, the largest possible fall below b_0, a bound of |f''|, and whether f can turn
        upwards within h.
        """
        zero = self.kit.number(0)
        total, fall, curvature, power = abs(series[0]), zero, zero, h
        for n in range(1, len(series)):
            term = abs(series[n]) * power
            total = total + term
            if n > 1:
                curvature = curvature + n * (n - 1) * term
                fall = fall + term
            elif series[1] < 0:
                fall = fall + term
            power = power * h
        turn = len(series) > 1 and series[1] < 0 and curvature > abs(series[1]) * h
        return total, fall, curvature / (h * h), turn

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

    def _graze(self, series, t0, h):
        """Minimum of a rootless gap function within the step, by secant and three Newton steps on its
        slope.
        """
        first = series[1]
        _, last = self._value_and_slope(series, h)
        if not first < 0 <= last:
            return
        tau = h * (first / (first - last))
        slopes = [n * series[n] for n in range(1, len(series))]
        for _ in range(3):
            slope, curvature = self._value_and_slope(slopes, tau)
            if curvature <= 0:
                break
            tau = tau - slope / curvature
            tau = 0 * h if tau < 0 else h if tau > h else tau
        value, _ = self._value_and_slope(series, tau)
        value = value if value > 0 else 0 * h
        if value < self.margin:
            self.margin, self.margin_time = value, t0 + tau
