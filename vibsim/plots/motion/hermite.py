"""Cubic Hermite interpolation between samples of a function and its derivative."""

from __future__ import annotations

import numpy as np

NEWTON_STEPS = 6  # quadratic from an error below the interval: 1 -> 2^-64 of it


def hermite(
    t: np.ndarray, f: np.ndarray, slope: np.ndarray, left: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Value and derivative (n) at the instants `at` (n), in the intervals that begin with samples `left`."""
    h = t[left + 1] - t[left]
    return _cubic((at - t[left]) / h, h, f[left], f[left + 1], slope[left], slope[left + 1])


def _cubic(
    s: np.ndarray, h: np.ndarray, f0: np.ndarray, f1: np.ndarray, d0: np.ndarray, d1: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Value and time derivative at s in [0, 1] of intervals of length h, end values f, slopes d."""
    a, b = h * d0 - (f1 - f0), (f1 - f0) - h * d1
    value = (1 - s) * f0 + s * f1 + s * (1 - s) * ((1 - s) * a + s * b)
    derivative = f1 - f0 + (1 - 2 * s) * ((1 - s) * a + s * b) + s * (1 - s) * (b - a)
    return value, derivative / h


def root_time(
    t0: np.ndarray,
    t1: np.ndarray,
    f0: np.ndarray,
    f1: np.ndarray,
    d0: np.ndarray,
    d1: np.ndarray,
    target: np.ndarray,
) -> np.ndarray:
    """Instants (n) at which the interpolant passes `target`, between f0 and f1: Newton, kept inside."""
    h = t1 - t0
    s = np.clip((target - f0) / (f1 - f0), 0.0, 1.0)
    for _ in range(NEWTON_STEPS):
        value, derivative = _cubic(s, h, f0, f1, d0, d1)
        steep = np.where(derivative == 0, 1.0, derivative)
        s = np.clip(s - np.where(derivative == 0, 0.0, (value - target) / (steep * h)), 0.0, 1.0)
    return np.asarray(t0 + s * h)
