"""Certified steps: they never pass a root, and converge quadratically to a simple one."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from vibsim.engine._engine import deflated_step, first_root, safe_step

EPS = 2.0**-53
POSITIVE, ZERO, UNFINISHED = range(3)  # outcomes of `first_root`
roots_ahead = st.lists(st.integers(1, 60).map(lambda n: n / 20), min_size=1, max_size=4, unique=True)
complex_pairs = st.lists(st.tuples(st.integers(-3000, 3000), st.integers(500, 3000)), max_size=3)


def polynomial(roots, pairs=(), order=0):
    """Coefficients, lowest first, of t^order prod (r - t) prod ((t - a)^2 + b^2), positive right behind 0."""
    p = np.polynomial.Polynomial([0.0] * order + [1.0])
    for root in roots:
        p = p * np.polynomial.Polynomial([root, -1.0])
    for a, b in pairs:
        p = p * np.polynomial.Polynomial([(a * a + b * b) / 1e6, -2 * a / 1e3, 1.0])
    return p


@dataclass
class Search:
    """Grid time of the first zero found, None where there is none; doubts; the smallest turn, and when."""

    found: float | None
    doubts: int
    margin: float
    margin_time: float


def searched(p, order, t0, h, keep_margin=False):
    """The search for the first zero of p(t - t0) in the step; expands anew as a flow does."""
    start, end, doubts = t0, t0 + h, 0
    while True:
        series = p(np.polynomial.Polynomial([start - t0, 1.0])).coef.tolist()
        packed = np.array([*series, 0.0, 0.0]).tobytes()
        outcome, t, more, *margin = first_root(packed, order, start, end - start, keep_margin)
        doubts += more
        if outcome != UNFINISHED:
            return Search(t if outcome == ZERO else None, doubts, *margin)
        start, order = t, 0


def size_of(p, h):
    """sum |coefficients of p| h^n."""
    return float(np.polynomial.Polynomial(np.abs(p.coef))(h))


@settings(max_examples=50)
@given(roots_ahead, complex_pairs)
def test_safe_step_never_passes_a_root(roots, pairs):
    p, h = polynomial(roots, pairs), 3.5
    bound, first, t = size_of(p.deriv(2), h), min(roots), 0.0
    derivative = p.deriv()
    noise = 16 * EPS * size_of(p, h)  # rounding of the value by its terms
    for _ in range(200):
        value, slope = float(p(t)), float(derivative(t))
        if value <= noise:
            break
        t += safe_step(value - noise, slope, bound)
        assert t <= first * (1 + 4 * EPS)


@given(st.integers(-1000, 1000), st.integers(0, 1000), st.integers(0, 1000))
def test_safe_step_is_the_root_of_its_parabola(slope, value, bound):
    q0, q1, b = value / 7, slope / 7, bound / 7
    step = safe_step(q0, q1, b)
    assume(math.isfinite(step) and q0 > 0)
    terms = q0 + abs(q1) * step + b * step * step / 2
    assert abs(q0 + q1 * step - b * step * step / 2) <= 16 * EPS * terms
    assert step > 0


def test_safe_step_is_infinite_where_the_parabola_never_comes_down():
    assert safe_step(1.0, 0.5, 0.0) == math.inf
    assert safe_step(1.0, -0.5, 0.0) == 2.0


def test_convergence_of_order_2_at_a_simple_root():
    # f = cos t, root pi / 2, |f''| <= 1: distances d_n with d_(n+1) ~ C d_n^2; slope of log against log
    t, distances = 0.3, []
    while math.cos(t) > 1e-13:
        distances.append(math.pi / 2 - t)
        t += safe_step(math.cos(t), -math.sin(t), 1.0)
    near = np.log([d for d in distances if d < 0.5])
    assert len(near) >= 4
    order = np.polyfit(near[:-1], near[1:], 1)[0]
    assert order >= 2 - 0.2  # cos curves away near its root, which makes it 3 here
    # f = 1 - exp(t - 1): curvature in full at the root, bound e^0 = 1
    t, distances = 0.0, []
    while 1 - t > 1e-7:
        distances.append(1 - t)
        t += safe_step(-math.expm1(t - 1), -math.exp(t - 1), 2.0)
    near = np.log([d for d in distances if d < 0.5])
    assert np.polyfit(near[:-1], near[1:], 1)[0] == pytest.approx(2.0, abs=0.2)


@given(roots_ahead, st.integers(1, 3))
def test_deflated_step_never_passes_a_root(roots, order):
    p, h = polynomial(roots, order=order), 3.5
    lead, following = (float(p.deriv(n)(0.0)) for n in (order, order + 1))
    bound = size_of(p.deriv(order + 2), h)
    assert 0 < deflated_step(order, lead, following, bound) <= min(roots) * (1 + 8 * EPS)


@pytest.mark.parametrize("start", [(0.0, 0.0), (5.0, 0.0), (0.0, 0.0, 0.0)])
def test_known_zeros_and_coefficients_that_are_zero_are_divided_out(start):
    """A known zero may stand as a rounded value, 5.0 here; what is left, 3 - 3 t, is zero at 1."""
    series = np.array([*start, 3.0, -3.0, 0.0, 0.0])
    assert first_root(series.tobytes(), 1, 0.0, 3.5, False)[:3] == (ZERO, 1.0, 0)


def test_a_zero_that_is_not_known_is_met():
    """5 + 3 t^2 - 3 t^3 is zero at 1.6425."""
    outcome, t, *_ = first_root(np.array([5.0, 0.0, 3.0, -3.0, 0.0, 0.0]).tobytes(), 0, 0.0, 3.5, False)
    assert outcome == ZERO and abs(5 + 3 * t**2 - 3 * t**3) < 1e-14 and t > 1.6


@given(roots_ahead, complex_pairs, st.integers(0, 2), st.integers(0, 10**6))
@example([1.85, 1.9, 2.2, 2.4], [(0, 500), (136, 501)], 0, 0)  # rounding of coefficients moves it by 3e-12
def test_polynomial_search_finds_the_first_root(roots, pairs, order, t0):
    p, h = polynomial(roots, pairs, order), 3.5
    search = searched(p, order, float(t0), h)
    found = search.found
    assert found is not None
    q = polynomial(roots, pairs)
    total = size_of(q, h)
    first, tau = min(roots), found - t0
    slope = max(abs(float(q.deriv()(first))), 1e-6 * total)
    moved = 16 * EPS * total / slope  # by rounding of the coefficients
    assert tau <= first * (1 + 1e-12) + 2 * EPS * t0 + moved
    # taken for zero: what lies within the rounding bound 4 eps sum |b_n| h^n, or one grid step of time away
    reach = float(np.max(np.abs(q.deriv()(np.linspace(tau, first, 20)))))
    assert abs(float(q(tau))) <= 16 * EPS * total + 4 * EPS * (t0 + h) * reach
    assert search.doubts == 0 or moved > 1e-9  # where rounding hides the zero, it may be in doubt


@given(complex_pairs.filter(bool))
def test_polynomial_search_finds_no_root_where_there_is_none(pairs):
    p = polynomial([], pairs)
    total = size_of(p, 3.5)
    assume(np.min(p(np.linspace(0, 3.5, 2001))) > 1e-6 * total)
    search = searched(p, 0, 0.0, 3.5)
    assert search.found is None and search.doubts == 0


@given(st.integers(100, 3000), st.integers(-12, 0))
def test_polynomial_search_keeps_the_grazing_margin(at, exponent):
    """(t - a)^2 + b turns round at a, with the value b."""
    a, b = at / 1000, 10.0**exponent
    search = searched(np.polynomial.Polynomial([a * a + b, -2 * a, 1.0]), 0, 0.0, 3.5, keep_margin=True)
    assert search.found is None
    assert search.margin == pytest.approx(b, abs=16 * EPS * (a * a + b + 2 * a * 3.5 + 3.5**2))
    assert search.margin_time == pytest.approx(a, rel=1e-12)


@given(st.integers(2, 60))
def test_polynomial_search_stops_at_a_double_root(n):
    """(t - a)^2 touches zero: found, up to the square root of the rounding bound before it."""
    a, h = n / 20, 3.5
    search = searched(np.polynomial.Polynomial([a * a, -2 * a, 1.0]), 0, 0.0, h)
    assert search.doubts >= 1  # whether it touches or misses is beyond doubles
    if search.found is not None:  # a rounded up to no root at all is as good
        assert abs(search.found - a) <= math.sqrt(16 * EPS * (a + h) ** 2)


def test_a_rest_at_zero_has_no_root():
    outcome, _, doubts, margin, _ = first_root(np.zeros(3).tobytes(), 1, 0.0, 1.0, True)
    assert (outcome, doubts, margin) == (POSITIVE, 0, math.inf)
