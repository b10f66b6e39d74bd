"""The responses of one oscillator against 200 digits, over damping, stiffness, load frequency and time.

An error is counted in units of eps (|value| + conditioning), eps = 2^-53, where the conditioning is what one
relative unit of change in a, b, omega and t moves the response by: sin(wd t) at large t, say, cannot be
better than eps wd t, as wd itself is rounded. A response is a sum of two or three rounded products (about 6
roundings) and its branches let the terms cancel by three bits at most: 6 units stand for the sums without
cancellation (C, S), 8 for I, 16 for H, a complex product more, and 24 for its rate.
"""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest

from tests.engine.runs import run, scene_of
from tests.scenes import harmonic, motor, scene
from vibsim.engine.trajectory import open_trajectory

EPS = 2.0**-53
UNITS = {"C": 6, "S": 6, "I": 8, "H": 16, "H'": 24}
UNDERFLOW = 1e-290  # below it doubles lose digits by their format

W0 = 25.956  # [rad/s], about the free mode of the paper's blocks
# a / w0, and (a, b) with b = 0 or nearly
SHARES = (0.0, 1e-9, 1e-3, 0.3, 0.9, 1 - 1e-6, 1 - 1e-12, 1.0, 1 + 1e-12, 1 + 1e-6, 1.5, 10.0, 1e3, 1e6)
SOFT = ((0.0, 0.0), (1e-3, 0.0), (0.7, 0.0), (80.0, 0.0), (0.0, 1e-12), (0.7, 1e-12))
TIMES = (1e-7, 1e-4, 0.0191, 0.07, 0.31, 1.7, 12.0)
LOADS = (1e-9, 1e-3, 0.999, 1.0, 1 + 1e-9, 30.0, 1e4)  # omega over w0, or over 1 rad/s
MORE_TIMES = (1e-12, 1e-7, 1e-4, 3e-3, 0.0191, 0.03, 0.07, 0.31, 1.7, 12.0, 97.0, 1000.0)
MORE_LOADS = (1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 0.999, 1 - 1e-9, 1.0, 1 + 1e-9, 1.03, 2.0, 30.0)


def oscillators(a, b, omega):
    """Five bodies of 1 kg, each on b [N/m] and 2 a [N s/m], which their motion shows C, S, I and H of: let go
    at 1 m, struck to 1 m/s, under 1 N, under cos(omega t) and sin(omega t) [N].
    """
    links = [f"l{i}: {{between: [b{i}, ground], k: {b} N/m, c: {2 * a} N s/m}}" for i in range(5)]
    return scene_of(f"""
bodies: {{{", ".join(f"b{i}: 1 kg" for i in range(5))}}}
links: {{{", ".join(links)}}}
forces:
  step: {{on: b2, F0: 1 N}}
  cosine: {{on: b3, A: 1 N, omega: {omega!r} rad/s, phase: 90 deg}}
  sine: {{on: b4, A: 1 N, omega: {omega!r} rad/s}}
initial: {{b0: {{x: 1 m}}, b1: {{v: 1 m/s}}}}
run: {{t_end: 10000 s, every: 10000 s, method: closed_form}}
""")


def computed(a, b, omega, times):
    """C, S, I, H and H' at ascending times as a run has them: a row each."""
    of = oscillators(a, b, omega)
    row = {name: column[0] for name, column in next(open_trajectory(of).blocks()).events.items()}
    states = open_trajectory(of, resume=row).state_at(times)
    C, S, steady, *H = (states[f"x_b{i}"] for i in range(5))
    rates = states["v_b3"], states["v_b4"]
    return zip(C, S, steady, map(complex, *H), map(complex, *rates), strict=True)


def assert_accurate(a, b, omega, times):
    for t, values in zip(times, computed(a, b, omega, times), strict=True):
        exact, conditioning = sensitivity(a, b, omega, t)
        for name, got, expected, moved in zip(UNITS, values, exact, conditioning, strict=True):
            allowed = UNITS[name] * EPS * (abs(expected) + moved) + UNDERFLOW
            error = abs(mpmath.mpmathify(got) - expected)
            assert error <= allowed, (
                f"{name}: a={a!r} b={b!r} omega={omega!r} t={t!r}: {float(error / allowed):.3g} x bound"
            )


@pytest.mark.parametrize("share", SHARES)
def test_any_damping(share):
    for load in LOADS:
        assert_accurate(share * W0, W0 * W0, load * W0, TIMES)


@pytest.mark.parametrize(("a", "b"), SOFT)
def test_without_a_spring_or_nearly(a, b):
    for load in LOADS:
        assert_accurate(a, b, load, (*TIMES, 200.0))


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("rate", (0.3, W0, 400.0))
def test_any_damping_widely(rate):
    for share in SHARES:
        for load in MORE_LOADS:
            assert_accurate(share * rate, rate * rate, load * rate, MORE_TIMES)


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


# C, S, I and H of one oscillator to some 100 digits, and how much rounded arguments move them. Divided
# differences of exp(r t) over the roots and the load's exponents, with 200 digits and points that coincide
# moved 1e-60 apart: crude, obvious, and right far beyond double precision.


DIGITS = 200
APART = mpmath.mpf(10) ** -60
NUDGE = mpmath.mpf(10) ** -30


def exact_responses(a, b, omega, t):
    """C [-], S [s], I [s^2], H [s^2, complex] and its rate H' [s] at time t.

    Of y'' + 2 a y' + b y, under a load of the frequency omega.
    """
    with mpmath.workdps(DIGITS):
        a, b, omega, t = (mpmath.mpf(value) for value in (a, b, omega, t))
        root = mpmath.sqrt(mpmath.mpc(a * a - b))
        roots = [-a + root, -a - root + APART * (1 + abs(a) + abs(root))]
        apart = APART * (1 + abs(a) + abs(root)) / 3
        S = divided_difference(roots, t)
        steady = divided_difference([*roots, apart], t)
        H = divided_difference([*roots, mpmath.mpc(apart, omega)], t)
        C = (roots[0] * mpmath.exp(roots[1] * t) - roots[1] * mpmath.exp(roots[0] * t)) / (
            roots[0] - roots[1]
        )
        return C.real, S.real, steady.real, H, S.real + mpmath.mpc(0, omega) * H


def divided_difference(points, t):
    """exp(. t)[points]."""
    values = [mpmath.exp(point * t) for point in points]
    for width in range(1, len(points)):
        values = [
            (values[i + 1] - values[i]) / (points[i + width] - points[i]) for i in range(len(values) - 1)
        ]
    return values[0]


def sensitivity(a, b, omega, t):
    """What one relative unit of change in a, b, omega and t moves C, S, I, H by, added up [units of each]."""
    with mpmath.workdps(DIGITS):
        here = exact_responses(a, b, omega, t)
        total = [mpmath.mpf(0)] * 5
        for which in range(4):
            arguments = [mpmath.mpf(value) for value in (a, b, omega, t)]
            arguments[which] *= 1 + NUDGE
            moved = exact_responses(*arguments)
            total = [sum_ + abs(q - p) / NUDGE for sum_, p, q in zip(total, here, moved, strict=True)]
        return here, total


# Every order of the Taylor series that a case may ask for runs, to the same motion.


TOLERANCE = 2.0**-20  # steps of low orders at full tolerance are a thousand times shorter


def sliding(source, order):
    """At rest on friction: a start and releases that ask for derivatives beyond a series of order 4."""
    return scene(source, N=0.02, t_end=0.8, method="taylor", order=order, tol=TOLERANCE)


@pytest.mark.parametrize("source", [harmonic(3.5, 0.0725), motor(5.5)], ids=["harmonic", "motor"])
@pytest.mark.parametrize("order", [4, 5, 6, 7, 8, 40])
def test_each_order_runs(source, order):
    case = sliding(source, order)
    truth = run(replace(case, order=20, tol=2.0**-53))
    assert "stick_end" in truth.kinds
    other = run(case)
    assert other.events["kind"].tolist() == truth.events["kind"].tolist()
    for column in ("x1", "x2"):
        size = np.abs(truth.samples[column]).max()
        assert np.abs(other.samples[column] - truth.samples[column]).max() < 1000 * TOLERANCE * size
