"""Orbits of maps whose regime is known, each (n, d)."""

import numpy as np


def iterated(step, start, count, transient=1000):
    """`count` points of an orbit after a transient."""
    point, points = start, []
    for i in range(count + transient):
        point = step(point)
        if i >= transient:
            points.append(np.atleast_1d(point))
    return np.array(points, dtype=float)


def logistic(r, count):
    """x -> r x (1 - x): period 8 at r = 3.55, period 3 at 3.83, chaotic at 3.97."""
    return iterated(lambda x: r * x * (1 - x), 0.3, count)


def henon(count):
    """The classical chaotic attractor, a = 1.4, b = 0.3; Lyapunov exponent 0.419 (Henon 1976)."""
    return iterated(lambda p: np.array([1 - 1.4 * p[0] ** 2 + p[1], 0.3 * p[0]]), np.zeros(2), count)


def circle_map(winding, coupling, count):
    """theta -> theta + winding - coupling/(2 pi) sin(2 pi theta), on the unit circle.

    Below coupling 1 it is invertible: locked in its tongues, quasi-periodic outside them.
    """
    turns = iterated(
        lambda x: x + winding - coupling / (2 * np.pi) * np.sin(2 * np.pi * x), 0.1, count
    ).ravel()
    return np.stack([np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns)], axis=1)


def torus(count):
    """A signal of two frequencies sampled with the period of one: amplitude-modulated, period irrational."""
    n = np.arange(count)
    phase = 2 * np.pi * n * (np.sqrt(5) - 2)
    return np.stack([np.cos(phase) + 0.3 * np.cos(2 * phase), np.sin(phase)], axis=1)


def spiral(count, turn, decay):
    """z -> decay e^(i turn) z into the fixed point 0."""
    n = np.arange(count)
    z = decay**n * np.exp(1j * turn * n)
    return np.stack([z.real, z.imag], axis=1)
