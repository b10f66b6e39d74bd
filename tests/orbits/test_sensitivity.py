"""The derivative of a motion by its start and by numbers of its case, in closed form."""

from math import cos, exp, pi, sin, sqrt

import mpmath
import numpy as np
import pytest

import vibsim
from vibsim.cases.case import load_case_text
from vibsim.orbits.coordinates import OrbitError
from vibsim.orbits.slopes import monodromy
from vibsim.physics.precision import MultiprecisionMissing

TEXT = """
name: linear
bodies: {mass: 2 kg}
links: {spring: {between: [mass, ground], k: 50 N/m, c: 0.8 N s/m}}
forces: {drive: {on: mass, A: 0.3 N, omega: 90 deg/s}}
run: {t_end: 10 s, every: 10 ms}
"""


@pytest.fixture
def case():
    return vibsim.load_case(TEXT)


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
    by_amplitude = orbit.end.coordinates.of(told.by_parameter["A"])
    predicted = np.linalg.solve(np.eye(3) - orbit.end.derivative, by_amplitude)
    beside = [vibsim.orbit(case, {"A": f"{0.135 + sign * step!r} N"}, start=orbit).X for sign in (1, -1)]
    np.testing.assert_allclose((beside[0] - beside[1]) / (2 * step), predicted, rtol=1e-4)


def test_what_has_no_derivative(case):
    with pytest.raises(OrbitError, match="no column x1; the components of this scene are x_mass, v_mass"):
        vibsim.monodromy(case, state={"x1": 0.0}, T=1.0)
    rising = vibsim.load_case("gallery/bouncing-ball", {"forces.weight.F0": "2 N"})
    with pytest.raises(OrbitError, match="at 1 s the motion grazes a rigid stop"):  # 1 - 2 t + t^2
        vibsim.monodromy(rising, state={"x_ball": 1.0, "v_ball": -2.0 - 1e-14}, T=1.5)
    assert vibsim.monodromy(rising, state={"x_ball": 1.0, "v_ball": -2.1}, T=1.5).events == (("impact", 0),)


@pytest.fixture
def without_library(monkeypatch):
    """An installation without numbers of many digits."""

    def missing(digits):
        raise MultiprecisionMissing(digits)

    monkeypatch.setattr("vibsim.orbits.slopes.number_kit", missing)


def dropped(*keys):
    case = vibsim.load_case("gallery/bouncing-ball", {"stops.floor.e": "0.3"})
    return vibsim.monodromy(case, state={"x_ball": 0.1}, T=1.0, parameters=keys)


def test_a_ball_that_has_come_to_rest():
    """It lies on the floor, whatever it weighs; a gap lets it lie lower."""
    told = dropped("weight.F0", "floor.gap", "stops.floor.e")
    assert "rest_begin" in {kind for kind, _ in told.events}
    assert [row.tolist() for row in told.by_parameter.values()] == [[0, 0], [-1, 0], [0, 0]]
    assert not any(row.any() for row in told.error.values())


def test_without_a_library_a_number_of_0_has_none(without_library):
    with pytest.raises(OrbitError, match=r"floor\.gap is 0, which leaves open"):
        dropped("floor.gap")


OMEGA = mpmath.mpf(3) / 10


def released(t, A=1, w=OMEGA, k=1, m=1):
    """x(t) of the chattering oscillator released from its wall at w t = 5 pi/2: m x'' + k x = A cos(w t)."""
    own, amplitude, begin = mpmath.sqrt(mpmath.mpf(k) / m), A / (k - m * w**2), 5 * mpmath.pi / 2 / w
    return amplitude * (mpmath.cos(w * t) + w / own * mpmath.sin(own * (t - begin)))


RELEASED = {"A": ("A", 1), "omega": ("w", OMEGA), "links.spring.k": ("k", 1), "bodies.mass": ("m", 1)}


def by_number_of_released(key):
    """The derivative by a number of x and v at 28 s."""
    name, value = RELEASED[key]

    def end(number, t):
        return released(t, **{name: number})

    with mpmath.workdps(40):
        return [float(mpmath.diff(end, (value, mpmath.mpf(28)), (1, order))) for order in (0, 1)]


def behind_a_chatter(e, *keys):
    """The motion has forgotten all in front of its release, restitution too."""
    case, e_key = vibsim.load_case("gallery/chattering-oscillator", {"stops.wall.e": e}), "stops.wall.e"
    told = vibsim.monodromy(case, state={"x_mass": -1.0}, T=28.0, parameters=(*keys, e_key))
    assert told.events[-1] == ("rest_end", 0) and not told.matrix.any()
    return told


def test_behind_a_chatter_and_a_rest():
    told = behind_a_chatter("0.1", "omega")
    np.testing.assert_allclose(told.by_parameter["omega"], by_number_of_released("omega"), rtol=4e-15)
    assert not told.by_parameter["stops.wall.e"].any()


def test_without_a_library_errors_are_told(without_library):
    """154 impacts came before the release."""
    told = behind_a_chatter("0.8", *RELEASED)
    for key in RELEASED:
        exact = by_number_of_released(key)
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


def by_restitution(text, e, start, T):
    """The derivative of the motion of a scene by e of its first stop, as (events, derivative, error)."""
    case = load_case_text(text, overrides={"stops.sa.e": e})
    told = vibsim.monodromy(case, state=start, T=T, parameters=("stops.sa.e",))
    return told.events, told.by_parameter["stops.sa.e"], told.error["stops.sa.e"]


@pytest.mark.parametrize("e", ["1", "0.9"])
def test_a_number_where_its_range_ends(e, request):
    """Motions are on one side at e = 1, in doubles as in many digits. b comes to rest by infinitely many
    impacts; nothing of a depends on it.
    """
    _, exact, doubt = by_restitution(ALONE, e, {"v_a": -0.1}, 1.7)
    assert not doubt.any()
    request.getfixturevalue("without_library")
    events, found, doubt = by_restitution(CHATTERING, e, {"v_a": -0.1}, 1.7)
    assert ("rest_begin", 1) in events and events.count(("impact", 0)) > 2
    error = np.abs(found[[0, 2]] - exact)
    assert np.all(error <= doubt[[0, 2]]) and error.max() < 1e-9


def test_a_number_without_unit_at_0(without_library):
    """A body pressed on a wall: with a small e it hops for a time in proportion to e, which is long over at
    the end. So it rests there as with e = 0.
    """
    text = ALONE.replace("A: 3 N, omega: 2 Hz", "F0: -4 N")
    events, found, doubt = by_restitution(text, "0", {}, 1.0)
    assert events == (("impact", 0), ("rest_begin", 0))
    assert np.all(np.abs(found) <= doubt) and 0 < doubt.max() < 1e-10


# Derivatives of motions by numbers of their cases, through events, against those that a Taylor flow carried
# along, with the saltation of each event, dt = -dh/h' (vibsim before 29 November 2026).


# case, start, end [s], numbers of the case with the largest component, kinds of events on the way
MOTIONS = {
    "the paper's machine": (
        "I-C",
        {"x1": 0.0022, "v1": 0.08, "v2": -0.009},
        0.3,
        "A 0.1786984348822 omega 0.005008567967229 F0 0.4496452014418 c -0.03145773201831 "
        "k1 -0.001228096013429 k2 -2.02326762615e-06 G 62.55206371831 mu -0.9879650669853 "
        "m1 0.7424741918995 m2 0.008877569822708 g -0.0001007099966346",
        {"contact_begin", "contact_end", "reversal"},
    ),
    "a motor, with sticks": (
        "II-B",
        {"x1": 0.010194, "v1": -0.301757, "v2": 0.0364939, "phidot": 35.4362},
        0.11,
        "Omega0 0.01196329707903 J -336.200384871 e 36.79023698443 k1 -0.009979925802575 "
        "G 573.0576522397 mu -0.6710107032521",
        {"contact_begin", "reversal", "stick_begin", "stick_end"},
    ),
    "a rigid stop": (
        "gallery/impact-oscillator",
        {"x_mass": -0.04, "v_mass": 0.6},
        4.0,
        "drive.A -0.3238617573429 drive.omega -1.802350184602 drive.phase -0.5071197337495 "
        "stops.wall.gap -8.112961075761 stops.wall.e -0.5663935570581 bodies.mass -2.287836957615",
        {"impact"},
    ),
    "a table that shakes": (
        "gallery/ball-on-shaken-table",
        {"x_ball": 0.001, "v_ball": 0.05},
        0.05,
        "base.a -655.4425010979 base.omega 0.002062755529313 stops.table.e 1.212568803228 "
        "bodies.ball 49.82428062711",
        {"impact"},
    ),
    "a belt, friction that falls": (
        "gallery/belt-oscillator",
        {"x_block": 0.0, "v_block": -2.5},
        7.0,
        "friction.belt.belt -1.584551685733 mu_s -0.7803407427695 mu_d 0.9073360401312 "
        "v0 -0.2310113390817 N 0.4554016924792 links.spring.k -4.727211033685 "
        "links.spring.c 3.540313121853",
        {"stick_begin", "stick_end"},
    ),
    "formulas, a circuit and stops": (
        "gallery/energy-harvester",
        {"x_mass": 1e-4, "v_mass": 0.3, "u": 1.0},
        0.01,
        "parameters.theta -1908.645035403 links.spring.c -14.44463741224 "
        "states.u.R -0.0001321320215468 stops.upper.k 0.0003666685372466 "
        "shaking.omega -0.000741583537342",
        {"contact_begin", "contact_end"},
    ),
}


@pytest.mark.parametrize("label", MOTIONS)
def test_derivatives_by_numbers(label):
    name, start, T, text, kinds = MOTIONS[label]
    words = text.split()
    expected = dict(zip(words[::2], map(float, words[1::2]), strict=True))
    told = monodromy(vibsim.load_case(name), state=start, T=T, parameters=tuple(expected))
    assert kinds <= {kind for kind, _ in told.events}
    for key, value in expected.items():
        assert max(told.by_parameter[key], key=abs) == pytest.approx(value, rel=1e-11), key
        assert not told.error[key].any()  # exact, and no quotient


TANGENT = """
bodies: {a: 1 kg}
friction: {guide: {between: [a, ground], N: 1 N, mu: 0.5}}
forces: {drive: {on: a, F0: 0.5 N, A: -1 N, omega: 1 rad/s, phase: 90 deg}}
run: {t_end: 10 s, every: 10 ms}
"""


def test_a_motion_that_is_tangent_to_an_event():
    """v = 1 - sin t touches 0 without coming to it: with a little less force the body sticks for a while."""
    case, by = load_case_text(TANGENT), ("drive.F0",)
    assert monodromy(case, state={"v_a": 1.0}, T=1.5, parameters=by).by_parameter["drive.F0"][1] == 1.5
    with pytest.raises(OrbitError, match=r"no derivative by drive\.F0: it changes with a little more of it"):
        monodromy(case, state={"v_a": 1.0}, T=3.0, parameters=by)


def test_what_comes_and_goes():
    """Without friction there is no friction part, so the motion has no derivative by its coefficient."""
    case = vibsim.load_case("I-C", {"mu": "0"})
    with pytest.raises(OrbitError, match="mu is where a part comes or goes"):
        monodromy(case, state={}, T=0.1, parameters=("mu",))
