"""Orbits against closed forms: pieces of free vibration, and where they end solved for in 30 digits."""

from math import atan2, cos, pi, sin, sqrt

import mpmath
import numpy as np
import pytest

import vibsim
from tests.engine.runs import scene_of
from tests.orbits.test_hard_cases import bilinear, rubbing
from vibsim.cases import load_case
from vibsim.engine.modes.parametric_rows import differences
from vibsim.orbits import find_orbit
from vibsim.orbits.coordinates import OrbitError


def slip(X, ratio, friction):
    """(duration, place of rest) of a slip of x'' + x = cos(ratio t) - friction sgn x' from rest at X > 0.

    It begins where the force that holds it is at its limit, cos = X - friction, and falls from then on.
    """
    gain = 1 / (1 - mpmath.mpf(ratio) ** 2)
    phase = mpmath.acos(X - friction)
    a, b = X - friction - gain * mpmath.cos(phase), ratio * gain * mpmath.sin(phase)

    def velocity(t):
        return -a * mpmath.sin(t) + b * mpmath.cos(t) - ratio * gain * mpmath.sin(ratio * t + phase)

    first = next(k for k in range(2, 400) if velocity(mpmath.mpf(k) / 20) > 0)
    t = mpmath.findroot(velocity, (mpmath.mpf(first - 1) / 20, mpmath.mpf(first) / 20), solver="anderson")
    rest = a * mpmath.cos(t) + b * mpmath.sin(t) + friction + gain * mpmath.cos(ratio * t + phase)
    return t, rest


@pytest.mark.parametrize(("ratio", "friction", "X"), [(0.6, 0.7, 1.35), (0.3, 0.3, 0.88), (0.7, 0.8, 1.3)])
def test_den_hartogs_motion_with_stops(ratio, friction, X):
    """It rests at X and -X once in each half period (Den Hartog 1930). What a disturbance leaves is one
    of the place of rest, whose map is the same in both halves.
    """
    with mpmath.workdps(30):
        X = mpmath.findroot(lambda x: slip(x, ratio, friction)[1] + x, X)
        duration = float(slip(X, ratio, friction)[0])
        slope = float(mpmath.diff(lambda x: slip(x, ratio, friction)[1], X))
    orbit = find_orbit(rubbing(ratio, friction), {"x_m": 0.0, "v_m": 0.8}, 1)
    times, places = orbit.end.carried.times, orbit.end.carried.states[:, 0]
    assert orbit.spelled == "susu" and orbit.stable
    np.testing.assert_allclose(places, float(X) * np.array([1, 1, -1, -1]), rtol=1e-13)
    assert times[2] - times[1] == pytest.approx(duration, rel=1e-13)
    np.testing.assert_allclose(orbit.multipliers, [slope**2, 0], rtol=1e-11, atol=0)


def bilinear_pieces(k, c, amplitude, omega):
    """Equations of an orbit of x'' + c x' + (1 or k) x = amplitude sin(omega t), k where x > 0, with one
    contact in a period: when it begins, how long it lasts, velocities at its ends.
    """

    def piece(stiffness, v, t0, t):
        """Displacement and velocity after t, from x = 0 with the velocity v at the time t0."""
        inertia, damping = stiffness - omega**2, c * omega
        size, lag = amplitude / mpmath.hypot(inertia, damping), mpmath.atan2(damping, inertia)
        forced = [size * mpmath.sin(omega * s - lag) for s in (t0, t0 + t)]
        speeds = [size * omega * mpmath.cos(omega * s - lag) for s in (t0, t0 + t)]
        a, w = c / 2, mpmath.sqrt(stiffness - c**2 / 4)
        x, s = -forced[0], (v - speeds[0] - a * forced[0]) / w
        decay, co, si = mpmath.exp(-a * t), mpmath.cos(w * t), mpmath.sin(w * t)
        return (
            decay * (x * co + s * si) + forced[1],
            decay * ((w * s - a * x) * co - (w * x + a * s) * si) + speeds[1],
        )

    def equations(t0, contact, v_in, v_out):
        x, v = piece(k, v_in, t0, contact)
        free = 2 * mpmath.pi / omega - contact
        y, u = piece(mpmath.mpf(1), v_out, t0 + contact, free)
        return x, v - v_out, y, u - v_in

    return equations


@pytest.mark.parametrize("amplitude", [1.0, 2.5])
def test_a_forced_bilinear_oscillator_without_a_gap(amplitude):
    """Two linear pieces meet at x = 0: phase, duration and speeds of the contact."""
    orbit = find_orbit(bilinear(amplitude), {"x_m": 0.1 * amplitude, "v_m": 0.1 * amplitude}, 1)
    times, states, T = orbit.end.carried.times, orbit.end.carried.states, orbit.period
    begin = [kind for kind, _ in orbit.events].index("contact_begin")
    assert len(orbit.events) == 2
    contact = (times[1 - begin] - times[begin]) % T
    speeds = states[begin, 1], states[1 - begin, 1]
    with mpmath.workdps(30):
        c, omega = mpmath.mpf(0.1), mpmath.mpf(2 * pi * 0.35)
        exact = mpmath.findroot(
            bilinear_pieces(mpmath.mpf(9), c, mpmath.mpf(amplitude), omega),
            [mpmath.mpf(float(each)) for each in (times[begin], contact, *speeds)],
        )
    np.testing.assert_allclose([times[begin], contact, *speeds], [float(e) for e in exact], rtol=1e-12)


def impacting(ratio, gap, e):
    """x'' + x = cos(ratio t), a rigid stop at x = gap (Shaw and Holmes 1983)."""
    return scene_of(f"""
bodies: {{m: 1 kg}}
links: {{spring: {{between: [m, ground], k: 1 N/m}}}}
stops: {{wall: {{between: [m, ground], gap: {gap} m, acts: compression, law: rigid, e: {e}}}}}
forces: {{drive: {{on: m, A: 1 N, omega: {ratio} rad/s, phase: 90 deg}}}}
""")


def shaw_and_holmes(ratio, gap, e, n):
    """Speed V and phase of the impact, state at t = 0, trace of the matrix, of the orbit with one impact in n
    periods: x = gain cos(ratio t) + A cos s + B sin s at s behind an impact, from gap back to gap.
    """
    T, gain = 2 * pi * n / ratio, 1 / (1 - ratio**2)
    a, b = sin(T) / (1 - cos(T)) * (1 + e), (1 - e) / ratio
    V = (-2 * a * gap + 2 * sqrt(gain**2 * a**2 - (gap**2 - gain**2) * b**2)) / (a**2 + b**2)
    phase = atan2(-b * V / 2 / gain, (gap + a * V / 2) / gain) % (2 * pi)
    A, B, s = -a * V / 2, -(1 + e) * V / 2, T - phase / ratio
    x, v = gain + A * cos(s) + B * sin(s), B * cos(s) - A * sin(s)
    trace = -2 * e * cos(T) + (1 + e) * (cos(phase) - gap) * sin(T) / V
    return V, phase, (x, v), trace


@pytest.mark.parametrize("gap", [0.0, 0.01])
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
def test_shaw_and_holmes_orbits_of_n_periods(n, gap):
    """One impact in n periods near ratio = 2 n (Shaw and Holmes 1983), from beside it."""
    ratio, e = 2 * n - 0.3, 0.8
    V, phase, (x, v), trace = shaw_and_holmes(ratio, gap, e, n)
    orbit = find_orbit(impacting(ratio, gap, e), {"x_m": x + 1e-4 * V, "v_m": v - 1e-4 * V}, n)
    assert orbit.spelled == "i" and orbit.n == n
    assert abs(orbit.end.carried.states[0, 1]) == pytest.approx(e * V, rel=1e-12)
    assert ratio * orbit.end.carried.times[0] % (2 * pi) == pytest.approx(phase, rel=1e-12)
    assert np.sum(orbit.multipliers).real == pytest.approx(trace, rel=1e-11)
    assert np.prod(orbit.multipliers).real == pytest.approx(e**2, rel=1e-11)


def impacting_times(ratio, e, n, start):
    """Times and velocities behind the impacts of an orbit of x'' + x = cos(ratio t) before a wall at
    x = 0, and the derivative of its map of (time, velocity): in 30 digits, from (times, velocities) nearby.
    """
    gain, count = 1 / (1 - ratio**2), len(start[0])

    def flight(t, v, end):
        """Displacement, velocity and acceleration at the end of a free flight from the wall."""
        x, u, s = -gain * mpmath.cos(ratio * t), v + gain * ratio * mpmath.sin(ratio * t), end - t
        c, sine = mpmath.cos(s), mpmath.sin(s)
        place = x * c + u * sine + gain * mpmath.cos(ratio * end)
        return place, u * c - x * sine - gain * ratio * mpmath.sin(ratio * end)

    def end(times, i):
        return times[i + 1] if i + 1 < count else times[0] + 2 * mpmath.pi * n / ratio

    def equations(*unknowns):
        times, speeds = unknowns[:count], unknowns[count:]
        ends = [flight(times[i], speeds[i], end(times, i)) for i in range(count)]
        blows = [-e * v - speeds[(i + 1) % count] for i, (_, v) in enumerate(ends)]
        return [x for x, _ in ends] + blows

    found = list(mpmath.findroot(equations, [*start[0], *start[1]], tol=1e-50))
    times, speeds = found[:count], found[count:]
    matrix = mpmath.eye(2)
    for i in range(count):
        t, v, stop = times[i], speeds[i], end(times, i)
        by = [
            [
                mpmath.diff(lambda *z, k=k: flight(*z)[k], (t, v, stop), order)
                for order in np.eye(3, dtype=int)
            ]
            for k in (0, 1)
        ]
        (xt, xv, xs), (ut, uv, us) = by
        later = [-xt / xs, -xv / xs]  # of the next impact
        matrix = mpmath.matrix([later, [-e * (ut + us * later[0]), -e * (uv + us * later[1])]]) * matrix
    return times, speeds, mpmath.eig(matrix, left=False, right=False)


@pytest.mark.parametrize(
    ("n", "X"),
    [
        (2, (-0.2680737344283769, 0.03198610176966447)),
        (3, (-0.5313794348393579, 0.08229179998842609)),
        (3, (-0.39938470165712825, -0.052730717157750816)),
    ],
)
def test_several_unlike_impacts_in_several_periods(n, X):
    """Peterka's regimes of p impacts in n periods, p = n: unstable ones beside those of one impact."""
    orbit = find_orbit(impacting(2.8, 0.0, 0.8), {"x_m": X[0], "v_m": X[1]}, n)
    carried = orbit.end.carried
    assert orbit.spelled == "i" * n and orbit.n == n and not orbit.stable
    with mpmath.workdps(30):
        start = [mpmath.mpf(t) for t in carried.times], [mpmath.mpf(v) for v in carried.states[:, 1]]
        times, speeds, exact = impacting_times(mpmath.mpf(2.8), mpmath.mpf(0.8), n, start)
    np.testing.assert_allclose(carried.times, np.array(times, dtype=float), rtol=1e-13)
    np.testing.assert_allclose(carried.states[:, 1], np.array(speeds, dtype=float), rtol=1e-13)
    multipliers = sorted(map(complex, exact), key=abs, reverse=True)
    np.testing.assert_allclose(orbit.multipliers, multipliers, rtol=1e-11)


# Derivatives by the amplitude of a base that rests: those of a base that is about to move.


CASE = """
bodies: {block: 1 kg}
links: {spring: {between: [block, base], k: 40 N/m, c: 0.2 N s/m}}
stops: {wall: {between: [block, base], gap: 5 mm, acts: compression, k: 2 kN/m}}
friction: {floor: {between: [block, ground], N: 0.12 N, mu: 1}%s}
forces: {drive: {on: block, A: 0.3 N, omega: 0.8 Hz}}
base: {a: 0 m, omega: 1.3 Hz, phase: 30 deg}
run: {t_end: 3 s}
"""
START, END = {"x_block": 0.004, "v_block": 0.05}, 3.0


def test_derivative_by_an_amplitude_of_zero():
    """Against motions with small amplitudes; what their quotient leaves out is of the second order."""
    still = load_case(CASE % "")
    derivative = vibsim.monodromy(still, state=START, T=END, parameters=["base.a"])
    assert {"contact_begin", "stick_begin", "stick_end"} <= {kind for kind, _ in derivative.events}

    def quotient(amplitude):
        moving = vibsim.monodromy(still.replace({"base.a": f"{amplitude} m"}), state=START, T=END)
        return np.array([moving.state[name] - derivative.state[name] for name in START]) / amplitude

    limit = 2 * quotient(1e-9) - quotient(2e-9)
    slope = np.asarray(derivative.by_parameter["base.a"])
    assert np.abs(slope - limit).max() < 1e-5 * np.abs(slope).max()


def test_body_that_holds_on_to_ground_and_base_has_none():
    """Where the base moves, one of its two holds slips, another one for each direction."""
    held = load_case(CASE % ", grip: {between: [block, base], N: 0.12 N, mu: 1}")
    with pytest.raises(OrbitError, match=r"the motion has no derivative by base\.a"):
        vibsim.monodromy(held, state=START, T=END, parameters=["base.a"])


def test_modes_of_a_base_that_rests_are_not_those_of_one_that_moves():
    still = load_case(CASE % "")
    rests, moves = still.scene(), still.replace({"base.a": "1 mm"}).scene()
    assert differences(rests, moves) is None
    assert differences(moves, rests) is None
