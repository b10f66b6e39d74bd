"""The responses of one oscillator against 200 digits, over damping, stiffness, load frequency and time.

An error is counted in units of eps (|value| + conditioning), eps = 2^-53, where the conditioning is what one
relative unit of change in a, b, omega and t moves the response by: sin(wd t) at large t, say, cannot be
better than eps wd t, as wd itself is rounded. A response is a sum of two or three rounded products (about 6
roundings) and its branches let the terms cancel by three bits at most: 6 units stand for the sums without
cancellation (C, S), 8 for I, 16 for H, a complex product more, and 24 for its rate.
"""

import math

import mpmath
import pytest

from tests.flows.exact_responses import exact_responses, sensitivity
from vibsim.engine.flows.closed.responses import Oscillator, free_harmonic_response
from vibsim.physics.numbers import Doubles

EPS = 2.0**-53
UNITS = {"C": 6, "S": 6, "I": 8, "H": 16, "H'": 24}
UNDERFLOW = 1e-290  # below it doubles lose digits by their format

W0 = 25.956  # [rad/s], about the free mode of the paper's blocks
SHARES = (
    0.0,
    1e-9,
    1e-3,
    0.3,
    0.9,
    1 - 1e-6,
    1 - 1e-12,
    1.0,
    1 + 1e-12,
    1 + 1e-6,
    1.5,
    10.0,
    1e3,
    1e6,
)  # a / w0
SOFT = (
    (0.0, 0.0),
    (1e-3, 0.0),
    (0.7, 0.0),
    (80.0, 0.0),
    (0.0, 1e-12),
    (0.7, 1e-12),
)  # (a, b) with b = 0 or nearly
TIMES = (1e-7, 1e-4, 0.0191, 0.07, 0.31, 1.7, 12.0)
LOADS = (1e-9, 1e-3, 0.999, 1.0, 1 + 1e-9, 30.0, 1e4)  # omega over w0, or over 1 rad/s
MORE_TIMES = (1e-12, 1e-7, 1e-4, 3e-3, 0.0191, 0.03, 0.07, 0.31, 1.7, 12.0, 97.0, 1000.0)
MORE_LOADS = (1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 0.999, 1 - 1e-9, 1.0, 1 + 1e-9, 1.03, 2.0, 30.0)


def computed(a, b, omega, t):
    """C, S, I, H and H' at t as the engine has them."""
    oscillator = Oscillator(Doubles, a, b, omega)
    C, S = oscillator.release_and_impulse(t)
    hc, hs, dc, ds = oscillator.harmonic_response(t, C, S, *turned(omega, t))
    return (
        C,
        S,
        oscillator.constant_response(t, C),
        complex(hc, hs),
        complex(dc, ds),
    )


def turned(omega, t):
    """cos and sin of omega t, rounded once: the engine reduces the phase exactly."""
    with mpmath.workdps(40):
        angle = mpmath.mpf(omega) * mpmath.mpf(t)
        return float(mpmath.cos(angle)), float(mpmath.sin(angle))


def assert_accurate(a, b, omega, t):
    exact, conditioning = sensitivity(a, b, omega, t)
    values = zip(UNITS, computed(a, b, omega, t), exact, conditioning, strict=True)
    for name, got, expected, moved in values:
        allowed = UNITS[name] * EPS * (abs(expected) + moved) + UNDERFLOW
        error = abs(mpmath.mpmathify(got) - expected)
        assert error <= allowed, (
            f"{name}: a={a!r} b={b!r} omega={omega!r} t={t!r}: {float(error / allowed):.3g} x bound"
        )


@pytest.mark.parametrize("t", TIMES)
@pytest.mark.parametrize("share", SHARES)
def test_any_damping(share, t):
    for load in LOADS:
        assert_accurate(share * W0, W0 * W0, load * W0, t)


@pytest.mark.parametrize("t", TIMES)
@pytest.mark.parametrize(("a", "b"), SOFT)
def test_without_a_spring_or_nearly(a, b, t):
    for load in LOADS:
        assert_accurate(a, b, load, t)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("t", MORE_TIMES)
@pytest.mark.parametrize("rate", (0.3, W0, 400.0))
def test_any_damping_widely(rate, t):
    for share in SHARES:
        for load in MORE_LOADS:
            assert_accurate(share * rate, rate * rate, load * rate, t)


@pytest.mark.parametrize("t", (0.01, 0.5, 3.0, 40.0))
def test_resonance_without_damping_grows_secularly(t):
    # y'' + w^2 y = cos(w t): y = t sin(w t) / (2 w); load sin: (sin(w t) - w t cos(w t)) / (2 w^2).
    # b is w * w rounded, so the oscillator is eps / 2 off resonance: y moves by (w t) eps of itself.
    w = 4.0
    oscillator = Oscillator(Doubles, 0.0, w * w, w)
    C, S = oscillator.release_and_impulse(t)
    hc, hs, _, _ = oscillator.harmonic_response(t, C, S, *turned(w, t))
    bound = 16 * EPS * (t / w) * (1 + w * t)
    assert hc == pytest.approx(t * math.sin(w * t) / (2 * w), abs=bound, rel=0)
    assert hs == pytest.approx((math.sin(w * t) - w * t * math.cos(w * t)) / (2 * w * w), abs=bound, rel=0)


@pytest.mark.parametrize("omega", (1e-9, 1e-3, 1.0, 34.5))
@pytest.mark.parametrize("t", (1e-9, 1e-3, 0.0144, 0.0146, 0.5, 200.0))
def test_free_mass(omega, t):
    # (1 - cos x) / w^2 and (x - sin x) / w^2; at x = 1/2 the second cancels to 1/24 of its terms: 24 + 8.
    oscillator = Oscillator(Doubles, 0.0, 0.0, omega)
    hc, hs = free_harmonic_response_of(oscillator, omega, t)
    with mpmath.workdps(60):
        x, w = mpmath.mpf(omega) * mpmath.mpf(t), mpmath.mpf(omega)
        exact_c, exact_s = (1 - mpmath.cos(x)) / w**2, (x - mpmath.sin(x)) / w**2
        moved = EPS * abs(x * mpmath.sin(x)) / w**2
        assert abs(hc - exact_c) <= 32 * EPS * abs(exact_c) + 4 * moved + 4 * EPS / w**2 * (x > 0.5)
        assert abs(hs - exact_s) <= 32 * EPS * abs(exact_s)


def free_harmonic_response_of(oscillator, omega, t):
    return free_harmonic_response(Doubles, omega, t, *turned(omega, t), oscillator)


def test_reference_against_textbook_forms():
    # y'' + 2 a y' + b y with a = 3, b = 25: wd = 4 exactly; r^2 + 5 r + 4: a = 5/2, b = 4, roots -1, -4.
    t = 0.7
    C, S, steady, _, _ = exact_responses(3.0, 25.0, 0.0, t)
    decay = mpmath.exp(-mpmath.mpf(3) * mpmath.mpf(t))
    sine, cosine = mpmath.sin(4 * mpmath.mpf(t)), mpmath.cos(4 * mpmath.mpf(t))
    assert float(S - decay * sine / 4) == pytest.approx(0.0, abs=1e-15)
    assert float(C - decay * (cosine + 3 * sine / 4)) == pytest.approx(0.0, abs=1e-15)
    assert float(steady - (1 - C) / 25) == pytest.approx(0.0, abs=1e-16)
    _, S, _, _, _ = exact_responses(2.5, 4.0, 2.0, t)
    assert float(S) == pytest.approx((math.exp(-t) - math.exp(-4 * t)) / 3, rel=1e-15)
    # steady state of (4 - omega^2 + 5 i omega) H = exp(i omega t) once the transients are gone
    _, _, _, late, _ = exact_responses(2.5, 4.0, 2.0, 60.0)
    assert complex(late) == pytest.approx(complex(mpmath.exp(120j) / 10j), rel=1e-14)
