import numpy as np

from vibsim.plots.traces import hermite, root_time


def cubic(t):
    return 2 * t**3 - t**2 + 4 * t - 1, 6 * t**2 - 2 * t + 4


def test_cubics_are_reproduced():
    t = np.array([0.0, 0.3, 1.0, 2.5])
    f, slope = cubic(t)
    at = np.array([0.1, 0.3, 0.9, 2.4])
    value, derivative = hermite(t, f, slope, np.array([0, 1, 1, 2]), at)
    np.testing.assert_allclose(value, cubic(at)[0], rtol=1e-13)
    np.testing.assert_allclose(derivative, cubic(at)[1], rtol=1e-12)


def test_root_of_a_cubic():
    f, slope = cubic(np.array([0.0, 2.0]))
    target = cubic(np.array([0.7]))[0]
    ends = [np.array([value]) for value in (0.0, 2.0, f[0], f[1], slope[0], slope[1])]
    np.testing.assert_allclose(root_time(*ends, target), [0.7], rtol=1e-12)


def test_root_stays_inside_where_the_slope_vanishes():
    zero = np.array([0.0])
    root = root_time(zero, zero + 1, zero, zero + 1, zero, zero, zero)
    assert 0 <= root[0] <= 1
