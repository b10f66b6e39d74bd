"""The derivative of a motion by its start and by numbers of its case, in closed form."""

from dataclasses import replace
from fractions import Fraction
from math import cos, exp, pi, sin, sqrt

import mpmath
import numpy as np
import pytest

import vibsim
from tests.engine.bundles import course, finished
from tests.engine.test_tangent_jacobian import numbers
from vibsim.cases.case import load_case_text
from vibsim.cases.quantities import decimal_text, si_unit
from vibsim.cases.schema_keys import measured_at
from vibsim.engine.truth import bare
from vibsim.orbits.coordinates import OrbitError, component_names
from vibsim.orbits.slopes import monodromy
from vibsim.physics.precision import Balls

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


# Derivatives of motions by numbers of their cases, through events, against quotients in 40 digits.


KIT = Balls(40)
SHIFT = Fraction(1, 10**14)  # what a one-sided quotient leaves out is of this size
# case, changes, start, end [s], numbers of the case, kinds of events that must be met on the way
MOTIONS = {
    "the paper's machine": (
        "I-C",
        {},
        {"x1": 0.0022, "v1": 0.08, "v2": -0.009},
        0.3,
        ("A", "omega", "F0", "c", "k1", "k2", "G", "mu", "m1", "m2", "g"),
        {"contact_begin", "contact_end", "reversal"},
    ),
    "a motor, with sticks": (
        "II-B",
        {},
        {"x1": 0.010194, "v1": -0.301757, "v2": 0.0364939, "phidot": 35.4362},
        0.11,
        ("Omega0", "J", "e", "k1", "G", "mu"),
        {"contact_begin", "reversal", "stick_begin", "stick_end"},
    ),
    "a rigid stop": (
        "gallery/impact-oscillator",
        {},
        {"x_mass": -0.04, "v_mass": 0.6},
        4.0,
        ("drive.A", "drive.omega", "drive.phase", "stops.wall.gap", "stops.wall.e", "bodies.mass"),
        {"impact"},
    ),
    "a table that shakes": (
        "gallery/ball-on-shaken-table",
        {},
        {"x_ball": 0.001, "v_ball": 0.05},
        0.05,
        ("base.a", "base.omega", "stops.table.e", "bodies.ball"),
        {"impact"},
    ),
    "a belt, friction that falls": (
        "gallery/belt-oscillator",
        {},
        {"x_block": 0.0, "v_block": -2.5},
        7.0,
        ("friction.belt.belt", "mu_s", "mu_d", "v0", "N", "links.spring.k", "links.spring.c"),
        {"stick_begin", "stick_end"},
    ),
    "formulas, a circuit and stops": (
        "gallery/energy-harvester",
        {},
        {"x_mass": 1e-4, "v_mass": 0.3, "u": 1.0},
        0.01,
        ("parameters.theta", "links.spring.c", "states.u.R", "stops.upper.k", "shaking.omega"),
        {"contact_begin", "contact_end"},
    ),
}


def quotient(case, key, components, T, base):
    """Of the motion in 40 digits beside `base`."""
    quantity, measured = case.quantity(key), measured_at(case.full_key(key))
    dimension = measured.dimension if measured else "number"
    turns = {"angle": "turn", "angular rate": "Hz"}
    unit = turns[dimension] if quantity.per_turn else si_unit(dimension).name
    value = quantity.value * (1 + SHIFT) if quantity.value else SHIFT
    beside = case.with_values({key: f"{decimal_text(value)} {unit}".strip()})
    ends = [base, finished(placed(beside, components, T), KIT)]
    assert course(ends[0]) == course(ends[1])
    shift = KIT.number(value - quantity.value) * (2 * KIT.pi if quantity.per_turn else 1)
    pairs = zip(*map(numbers, ends), strict=True)
    return np.array([float(((after - before) / shift).mid()) for before, after in pairs])


def placed(case, components, T):
    """The scene of a case in 40 digits from a start to the time T."""
    scene, n = bare(case.exact_scene(KIT.number, KIT.pi), KIT), len(case.scene().bodies)
    values = [KIT.number(value) for value in components]
    starts = zip(scene.bodies, values[:n], values[n : 2 * n], strict=True)
    motor = scene.motor and replace(scene.motor, phi=values[-2], phidot=values[-1])
    bodies = tuple(replace(body, x=x, v=v) for body, x, v in starts)
    stops = tuple(replace(stop, at_start=False) for stop in scene.stops)
    clearances = tuple(replace(one, at_start=False) for one in scene.clearances)
    of = {"bodies": bodies, "motor": motor, "stops": stops, "clearances": clearances}
    return replace(scene, **of, t_end=KIT.number(T), stop_on_violation=False, every_num=1000, every_den=1)


@pytest.mark.parametrize("label", MOTIONS)
def test_derivatives_by_numbers(label):
    name, changes, start, T, keys, kinds = MOTIONS[label]
    case = vibsim.load_case(name, changes)
    told = monodromy(case, state=start, T=T, parameters=keys)
    assert kinds <= {kind for kind, _ in told.events}
    columns = component_names(case.scene())  # None: the integral of a state, which is not shown
    shown = [i for i, column in enumerate(columns) if column is not None]
    components = [start.get(column, 0.0) for column in columns]
    base = finished(placed(case, components, T), KIT)
    for key in keys:
        exact, row = quotient(case, key, components, T, base)[shown], told.by_parameter[key]
        assert not told.error[key].any()  # exact, and no quotient
        # what rounding of the motion itself is multiplied by on its way is below 1e4 here
        np.testing.assert_allclose(row, exact, rtol=1e-10, atol=1e-11 * np.abs(exact).max(), err_msg=key)


def test_what_comes_and_goes():
    """Without friction there is no friction part, so the motion has no derivative by its coefficient."""
    case = vibsim.load_case("I-C", {"mu": "0"})
    with pytest.raises(OrbitError, match="mu is where a part comes or goes"):
        monodromy(case, state={}, T=0.1, parameters=("mu",))
