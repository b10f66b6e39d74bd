"""The derivative of a motion by its start and by numbers of its case, in closed form."""

from math import cos, exp, pi, sin, sqrt

import mpmath
import numpy as np
import pytest

import vibsim
from vibsim.cases.case import load_case_text
from vibsim.orbits.coordinates import OrbitError

TEXT = """
name: linear
bodies: {mass: 2 kg}
links: {spring: {between: [mass, ground], k: 50 N/m, c: 0.8 N s/m}}
forces: {drive: {on: mass, A: 0.3 N, omega: 90 deg/s}}
run: {t_end: 10 s, every: 10 ms}
"""


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "linear.yaml"
    path.write_text(TEXT)
    return vibsim.load_case(str(path))


def displacement(t, m, k, c, A, W, x, v):
    """x(t) of m x'' + c x' + k x = A sin W t, from x and v at 0."""
    a, w = c / (2 * m), sqrt(k / m - (c / (2 * m)) ** 2)
    D = (k - m * W * W) ** 2 + (c * W) ** 2
    p, q = A * (k - m * W * W) / D, -A * c * W / D  # p sin + q cos
    B = x - q
    C = (v + a * B - p * W) / w
    return exp(-a * t) * (B * cos(w * t) + C * sin(w * t)) + p * sin(W * t) + q * cos(W * t)


def slope(f, value, h=1e-4):
    """Of fourth order."""
    return (8 * (f(value + h) - f(value - h)) - f(value + 2 * h) + f(value - 2 * h)) / (12 * h)


def test_a_linear_oscillator(case):
    values = {"m": 2.0, "k": 50.0, "c": 0.8, "A": 0.3, "W": pi / 2, "x": 0.01, "v": -0.2}
    T, keys = 1.7, {"bodies.mass": "m", "links.spring.k": "k", "links.spring.c": "c", "omega": "W"}
    told = vibsim.monodromy(case, state={"x_mass": 0.01, "v_mass": -0.2}, T=T, parameters=tuple(keys))
    assert told.columns == ("x_mass", "v_mass") and told.events == ()
    assert told.state["x_mass"] == pytest.approx(displacement(T, **values), abs=1e-14)
    for j, name in enumerate("xv"):
        exact = slope(lambda value, name=name: displacement(T, **values | {name: value}), values[name])
        assert told.matrix[0, j] == pytest.approx(exact, abs=1e-10)
    for key, name in keys.items():
        exact = slope(lambda value, name=name: displacement(T, **values | {name: value}), values[name])
        assert told.by_parameter[key][0] == pytest.approx(exact, abs=1e-10), key
        assert abs(told.by_parameter[key][0] - exact) < max(told.error[key][0], 1e-10)


def test_the_papers_machine_through_impacts():
    """Sensitivities of a period by the matrix of the orbit beside it: dX/dp = (I - P')^-1 dP/dp."""
    case = vibsim.load_case("I-C")
    orbit, step = vibsim.orbit(case), 1e-4
    told = vibsim.monodromy(case, state=orbit.state, T=orbit.period, parameters=("A",))
    np.testing.assert_allclose(orbit.end.coordinates.of(told.matrix.T[[0, 2, 3]]).T, orbit.end.derivative)
    predicted = np.linalg.solve(
        np.eye(3) - orbit.end.derivative, orbit.end.coordinates.of(told.by_parameter["A"])
    )
    beside = [vibsim.orbit(case, {"A": f"{0.135 + sign * step!r} N"}, start=orbit).X for sign in (1, -1)]
    np.testing.assert_allclose((beside[0] - beside[1]) / (2 * step), predicted, rtol=1e-4)


def test_what_has_no_derivative(case):
    with pytest.raises(OrbitError, match="no column x1; the components of this scene are x_mass, v_mass"):
        vibsim.monodromy(case, state={"x1": 0.0}, T=1.0)
    with pytest.raises(OrbitError, match=r"floor\.gap is 0, which leaves open"):  # it comes to rest
        vibsim.monodromy(
            "gallery/bouncing-ball", state={"x_ball": 0.1}, T=2.0, parameters=("stops.floor.gap",)
        )
    rising = vibsim.load_case("gallery/bouncing-ball", {"forces.weight.F0": "2 N"})
    with pytest.raises(OrbitError, match="at 1 s the motion grazes a rigid stop"):  # 1 - 2 t + t^2
        vibsim.monodromy(rising, state={"x_ball": 1.0, "v_ball": -2.0 - 1e-14}, T=1.5)
    assert vibsim.monodromy(rising, state={"x_ball": 1.0, "v_ball": -2.1}, T=1.5).events == (("impact", 0),)


def test_where_a_ball_comes_to_rest_there_are_quotients():
    """It lies still then, whatever it weighed less; the estimate of the error says that they are no more."""
    told = vibsim.monodromy("gallery/bouncing-ball", state={"x_ball": 0.1}, T=2.0, parameters=("weight.F0",))
    assert "rest_begin" in {kind for kind, _ in told.events}
    assert told.by_parameter["weight.F0"] == pytest.approx(0, abs=1e-12)


OMEGA = mpmath.mpf(3) / 10


def released(t, A=1, w=OMEGA, k=1, m=1):
    """x(t) of the chattering oscillator released from its wall at w t = 5 pi/2: m x'' + k x = A cos(w t)."""
    own, amplitude, begin = mpmath.sqrt(mpmath.mpf(k) / m), A / (k - m * w**2), 5 * mpmath.pi / 2 / w
    return amplitude * (mpmath.cos(w * t) + w / own * mpmath.sin(own * (t - begin)))


def test_behind_a_chatter_and_a_rest_errors_are_told():
    """The motion has forgotten all in front of its release, restitution too; 154 impacts came before."""
    keys = {
        "A": ("A", 1),
        "omega": ("w", mpmath.mpf("0.3")),
        "links.spring.k": ("k", 1),
        "bodies.mass": ("m", 1),
    }
    told = vibsim.monodromy(
        "gallery/chattering-oscillator", state={"x_mass": -1.0}, T=28.0, parameters=(*keys, "stops.wall.e")
    )
    assert told.events[-1] == ("rest_end", 0) and not told.matrix.any()
    with mpmath.workdps(40):
        for key, (name, value) in keys.items():

            def end(number, t, name=name):
                return released(t, **{name: number})

            exact = [float(mpmath.diff(end, (value, mpmath.mpf(28)), (1, order))) for order in (0, 1)]
            error = np.abs(told.by_parameter[key] - exact)
            assert (error <= told.error[key]).all() and (told.error[key] <= 1e-7 * np.abs(exact)).all(), key
    assert (np.abs(told.by_parameter["stops.wall.e"]) <= told.error["stops.wall.e"]).all()


CHATTERING = """
bodies: {a: 1 kg, b: 2 kg}
links: {la: {between: [a, ground], k: 50 N/m, c: 0.8 N s/m}, lb: {between: [b, ground], k: 50 N/m}}
stops:
  sa: {between: [a, ground], gap: 1 mm, acts: extension, law: rigid, e: 1}
  sb: {between: [b, ground], gap: 1 mm, acts: extension, law: rigid, e: 0.3}
forces: {da: {on: a, A: 3 N, omega: 2 Hz}, db: {on: b, A: 3 N, omega: 0.5 Hz, F0: -4 N}}
run: {t_end: 10 s, every: 10 ms}
"""
ALONE = """
bodies: {a: 1 kg}
links: {la: {between: [a, ground], k: 50 N/m, c: 0.8 N s/m}}
stops: {sa: {between: [a, ground], gap: 1 mm, acts: extension, law: rigid, e: 1}}
forces: {da: {on: a, A: 3 N, omega: 2 Hz}}
run: {t_end: 10 s, every: 10 ms}
"""


@pytest.mark.parametrize("e", ["1", "0.9"])
def test_a_number_where_its_range_ends(e):
    """b comes to rest by infinitely many impacts, so derivatives are quotients, one-sided at e = 1. Nothing
    of a depends on b, and without b they are carried along, exact to rounding.
    """
    key, start = "stops.sa.e", {"v_a": -0.1}
    told = vibsim.monodromy(
        load_case_text(CHATTERING, overrides={key: e}), state=start, T=1.7, parameters=(key,)
    )
    assert ("rest_begin", 1) in told.events and told.events.count(("impact", 0)) > 2
    alone = vibsim.monodromy(load_case_text(ALONE, overrides={key: e}), state=start, T=1.7, parameters=(key,))
    assert not alone.error[key].any()
    error = np.abs(told.by_parameter[key][[0, 2]] - alone.by_parameter[key])
    assert np.all(error <= told.error[key][[0, 2]]) and error.max() < 1e-9


def test_a_number_without_unit_at_0():
    """A body pressed on a wall: with a small e it hops for a time in proportion to e, which is long over at
    the end. So it rests there as with e = 0.
    """
    text = ALONE.replace("A: 3 N, omega: 2 Hz", "F0: -4 N")
    told = vibsim.monodromy(
        load_case_text(text, overrides={"stops.sa.e": "0"}), state={}, T=1.0, parameters=("stops.sa.e",)
    )
    assert told.events == (("impact", 0), ("rest_begin", 0))
    assert np.all(np.abs(told.by_parameter["stops.sa.e"]) <= told.error["stops.sa.e"])
    assert 0 < told.error["stops.sa.e"].max() < 1e-10
