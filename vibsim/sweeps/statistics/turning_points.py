"""Extreme values between rows: where a velocity changes sign, the polynomial through both rows is evaluated.

Displacements: the quintic that has displacement, velocity and acceleration of both rows; it is off by at
most h^6/46080 max|x^(6)|, that is (w h)^6/46080 of a vibration at w rad/s. Speeds, of which only the first
derivative is known: the cubic, off by at most h^4/384 max|f^(4)|.
"""

import numpy as np

NEWTON_STEPS = 4  # from a secant start; the error of the root enters the extreme squared
NEARLY = 0.2


def turn_of_quintic(h, x, v, a):
    """Extreme of the quintic inside each interval.

    Parameters
    ----------
    h : lengths of the intervals (n) [s]
    x, v, a : pairs (left, right) of arrays (n); v changes sign inside

    Returns the extreme displacements (n).
    """
    return quintic(h, x, v, a, _root_of_cubic(h, v, a))


def quintic(h, x, v, a, s):
    """The quintics of n intervals at the places s in [0, 1], (n) or (m, n)."""
    d0, d1, c0, c1 = h * v[0], h * v[1], h * h * a[0], h * h * a[1]
    rise = x[1] - x[0]
    p3 = 10 * rise - 6 * d0 - 4 * d1 - 1.5 * c0 + 0.5 * c1
    p4 = -15 * rise + 8 * d0 + 7 * d1 + 1.5 * c0 - c1
    p5 = 6 * rise - 3 * (d0 + d1) - 0.5 * (c0 - c1)
    return x[0] + s * (d0 + s * (0.5 * c0 + s * (p3 + s * (p4 + s * p5))))


def may_turn_twice(h, x, v):
    """Whether the velocity comes near 0 inside an interval though it has one sign at both ends.

    h (n); x, v: pairs of arrays (q, n). Judged by the cubic's velocity half-way; errs on the side of yes.
    """
    with np.errstate(divide="ignore", invalid="ignore"):  # at intervals of no length
        halfway = 1.5 * ((x[1] - x[0]) / h) - 0.25 * (v[0] + v[1])
        near = (halfway * v[0] < NEARLY * v[0] * v[0]) & (halfway * v[1] < NEARLY * v[1] * v[1])
    return near & (v[0] * v[1] > 0) & (h > 0)


def turn_of_cubic(h, f, d):
    """Extreme of the cubic inside each interval; f, d: pairs (left, right) of values and derivatives (n)."""
    d0, d1, rise = h * d[0], h * d[1], f[1] - f[0]
    a, b = d0 + d1 - 2 * rise, 3 * rise - 2 * d0 - d1
    s = d0 / (d0 - d1)
    for _ in range(NEWTON_STEPS):
        slope = 2 * b + 6 * a * s
        s = np.clip(s - _quotient(d0 + s * (2 * b + 3 * a * s), slope), 0.0, 1.0)
    return f[0] + s * (d0 + s * (b + s * a))


def _root_of_cubic(h, f, d):
    """Place s in [0, 1] of the zero of the cubic with values f and derivatives d, f changing sign."""
    d0, d1, rise = h * d[0], h * d[1], f[1] - f[0]
    a, b = d0 + d1 - 2 * rise, 3 * rise - 2 * d0 - d1
    s = f[0] / (f[0] - f[1])
    for _ in range(NEWTON_STEPS):
        slope = d0 + s * (2 * b + 3 * a * s)
        s = np.clip(s - _quotient(f[0] + s * (d0 + s * (b + s * a)), slope), 0.0, 1.0)
    return s


def _quotient(top, bottom):
    """top / bottom, 0 where the bottom vanishes."""
    return np.divide(top, bottom, out=np.zeros_like(top), where=bottom != 0)
