"""Orbits of scenes with formulas, rotors and states against closed forms and an independent solver."""

from math import cos, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import vibsim
from tests.formula_cases import CURRENT, MACHINE, case_of
from vibsim.orbits import ReturnMap, find_orbit
from vibsim.orbits.coordinates import NoSection, case_on_orbit, section_of
from vibsim.orbits.orbit_digits import refine

VAN_DER_POL = """\
name: van-der-pol
bodies: {m: 1 kg}
links: {s: {between: [m, ground], force: "k*d + c*(d**2/x0**2 - 1)*v", k: 1 N/m, c: 1 N s/m, x0: 1 m}}
initial: {m: {x: 2 m}}
run: {t_end: 10 s, every: 50 ms}
"""
DUFFING = """\
name: duffing
bodies: {m: 1 kg}
links: {s: {between: [m, ground], force: "k*d + k3*d**3", k: 1 N/m, k3: 1 N/m^3}}
initial: {m: {x: 1 m}}
run: {t_end: 10 s, every: 50 ms}
"""
# A rotor that a turning field holds, phi = W t + delta:
# J delta'' + b delta' + a sin(delta) = T0 - b (W - w0).
SYNCHRONOUS = """\
name: synchronous
bodies: {cart: 0.9 kg}
links: {spring: {between: [cart, ground], k: 400 N/m, c: 2 N s/m}}
rotors:
  left: {on: cart, m: 0.1 kg, e: 0 m, J: 0.02 kg m^2, torque: "T0 - b*(w - w0) - a*sin(phi - W*t)",
         T0: 0.5 N m, b: 0.1 N m s/rad, w0: 2.5 Hz, a: 3 N m, W: 3 Hz}
initial: {left: {w: 3 Hz}}
run: {t_end: 2 s, every: 5 ms}
"""
DRIVEN = """\
name: driven
bodies: {m: 1 kg}
links: {s: {between: [m, ground], LAW}}
forces: {push: {on: m, FORCE}}
initial: {m: {x: 0.2 m}}
run: {t_end: 2 s, every: 10 ms}
"""


@pytest.fixture(scope="module")
def cycle():
    case = case_of(VAN_DER_POL)
    return find_orbit(case.scene(), {"x_m": -2.0, "v_m": 0.0}, case=case)


def test_the_cycle_of_van_der_pol(cycle):
    """Its period is known to many digits; its multiplier is exp of the divergence over the cycle."""
    assert cycle.period == pytest.approx(6.66328685932313, rel=1e-13)
    assert cycle.n == 1 and cycle.stable and cycle.events == ()

    def rates(t, s):
        x, v, _ = s
        return [v, (1 - x * x) * v - x, 1 - x * x]

    start = [cycle.state["x_m"], 0.0, 0.0]
    end = solve_ivp(rates, (0, cycle.period), start, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    assert end[:2] == pytest.approx(start[:2], abs=1e-10)
    assert cycle.multipliers == pytest.approx([np.exp(end[2])], rel=1e-8)


def test_a_backbone_by_elliptic_integrals():
    """x'' + x + x^3 = 0: A^2 = sqrt(1 + 4 E) - 1, T = 4 K(m) / sqrt(1 + A^2), m = A^2 / (2 (1 + A^2))."""
    branch = vibsim.continue_branch(case_of(DUFFING), energy="0.7:0.8 J")
    energies = np.array([point.orbit.parameter for point in branch.points])
    squares = np.sqrt(1 + 4 * energies) - 1
    periods = 4 * ellipk(squares / (2 * (1 + squares))) / np.sqrt(1 + squares)
    assert [point.orbit.period for point in branch.points] == pytest.approx(periods, rel=1e-12)
    assert len(energies) > 2


def test_energy_is_not_kept_by_formulas_of_other_things():
    damped = DUFFING.replace("k3*d**3", "k3*d**3 + c*v").replace("k: 1 N/m", "c: 1 N s/m, k: 1 N/m")
    with pytest.raises(vibsim.BranchError, match="does not keep its energy: the formula of s"):
        vibsim.continue_branch(case_of(damped), energy="0.7:0.8 J")


# The motor with its current: sections by turns of its rotor.


NEAR = {"x_cart": -0.002, "v_cart": 0.0102, "w_left": 59.6, "i": 0.0379}


@pytest.fixture(scope="module")
def turn():
    case = case_of(CURRENT)
    return find_orbit(case.scene(), {**NEAR, "phi_left": 0.0}, 1, 0.1053, case=case)


def rates_of_current(t, s):
    """(m + m_r) x'' = -k x - c x' + m e (w^2 cos + w' sin), (J + m e^2) w' = Kt i - b w + m e x'' sin."""
    x, v, phi, w, i = s
    mass, inertia, unbalance = 1.1, 0.001 + 0.1 * 0.02**2, 0.1 * 0.02
    sine, cosine = np.sin(phi), np.cos(phi)
    matrix = [[mass, -unbalance * sine], [-unbalance * sine, inertia]]
    loads = [-400 * x - 5 * v + unbalance * w * w * cosine, 0.2 * i - 1e-4 * w]
    a, alpha = np.linalg.solve(matrix, loads)
    return [v, a, w, alpha, (12 - 2 * i - 0.2 * w) / 0.01]


def reached(start, T):
    return solve_ivp(rates_of_current, (0, T), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def test_the_unknowns_of_a_rotor_and_a_state(turn):
    """The angle of the rotor is fixed by the section, a state has one unknown."""
    at = turn.end.coordinates
    assert at.names == ("x_cart", "v_cart", "w_left", "i") and at.units == ("m", "m/s", "rad/s", "A")
    assert set(turn.state) == {"x_cart", "v_cart", "phi_left", "w_left", "i"}
    assert turn.return_map.section.of_return == "turn of left"
    assert turn.return_map.section.place == "phi_left = 0"
    assert turn.drift_rates == {"cart": 0.0}


def test_an_orbit_by_turns_of_a_rotor_closes(turn):
    start = [turn.state[name] for name in ("x_cart", "v_cart", "phi_left", "w_left", "i")]
    end = reached(start, turn.period)
    assert end == pytest.approx(np.add(start, [0, 0, 2 * np.pi, 0, 0]), rel=1e-9, abs=1e-10)


def test_its_multipliers_are_those_of_difference_quotients(turn):
    start = np.array([turn.state[name] for name in ("x_cart", "v_cart", "phi_left", "w_left", "i")])
    rows = [0, 1, 3, 4]
    steps = 1e-4 * np.array([0.002, 0.1, 1.0, 60.0, 0.04])
    columns = []
    for k in rows:
        aside = np.eye(5)[k] * steps[k]
        ends = reached(start + aside, turn.period), reached(start - aside, turn.period)
        columns.append((ends[0] - ends[1]) / (2 * steps[k]))
    M, f = np.array(columns).T, np.array(rates_of_current(0, start))
    reduced = M[rows] - np.outer(f[rows], M[2] / f[2])
    expected = sorted(np.linalg.eigvals(reduced), key=lambda mu: (-abs(mu), mu.imag))
    assert turn.multipliers[:3] == pytest.approx(expected[:3], rel=1e-5)
    assert abs(turn.multipliers[3]) == pytest.approx(np.exp(-178.39 * turn.period), rel=0.05)


def test_a_case_starts_on_it(turn):
    """Every start value goes back into the case by its key."""
    case = case_on_orbit(case_of(CURRENT), turn.state, turn.period)
    cart, left, i = case.scene().bodies
    assert (cart.x, cart.v) == (turn.state["x_cart"], turn.state["v_cart"])
    assert (left.x, left.v, i.v) == (0.0, turn.state["w_left"], turn.state["i"])


def test_the_section_is_kept_while_it_runs():
    """Its points are at whole turns by the angle."""
    scene = case_of(CURRENT, {"run.t_end": "0.7 s"}).scene()
    blocks = list(vibsim.engine.trajectory.open_trajectory(scene, section=True).blocks())
    turns = np.concatenate([block.section["phi_left"] for block in blocks]) / (2 * np.pi)
    assert turns == pytest.approx(np.arange(1, len(turns) + 1), rel=1e-13) and len(turns) >= 4


def test_a_branch_over_a_number_of_a_formula(turn):
    """Over the voltage: each orbit closes by the independent solver, its mean speed rises with it."""
    branch = vibsim.continue_branch(turn, "states.i.U", "11.5:12.5 V")
    assert len(branch.points) > 3 and all(point.orbit.stable for point in branch.points)
    periods = [point.orbit.period for point in branch.points]
    assert periods == sorted(periods, reverse=True)
    at = min(branch.points, key=lambda point: abs(point.orbit.parameter - 12)).orbit
    assert np.interp(12, *np.array([(p.orbit.parameter, p.orbit.period) for p in branch.points]).T) == (
        pytest.approx(turn.period, rel=1e-4)
    )
    assert set(dict(zip(branch.names, at.state, strict=True))) == {"x_cart", "v_cart", "w_left", "i"}
    axes = branch.plot("branch")
    assert axes.get_ylabel() == "Mean rotor speed (Hz)" and axes.get_xlabel().endswith("(V)")


# A rotor that turns with what drives it: its angle closes up to whole turns.


def test_an_angle_is_an_unknown_up_to_whole_turns():
    case = case_of(SYNCHRONOUS)
    orbit = find_orbit(case.scene(), {"x_cart": 0.0, "v_cart": 0.0, "phi_left": 0.2, "w_left": 18.8})
    W, J, b, a = 6 * np.pi, 0.02, 0.1, 3.0
    delta = np.arcsin((0.5 - b * (W - 5 * np.pi)) / a)
    assert orbit.period == pytest.approx(1 / 3, rel=1e-15) and orbit.stable
    assert orbit.coordinates["phi_left"] == pytest.approx(delta, abs=1e-13)
    assert orbit.coordinates["w_left"] == pytest.approx(W, rel=1e-13)
    roots = [*np.roots([J, b, a * np.cos(delta)]), *np.roots([1.0, 2.0, 400.0])]
    expected = np.exp(np.array(roots) / 3)
    assert sorted(orbit.multipliers, key=lambda mu: (abs(mu), mu.imag)) == pytest.approx(
        sorted(expected, key=lambda mu: (abs(mu), mu.imag)), rel=1e-9
    )


# What has no section, and says so.


@pytest.mark.parametrize(
    ("changes", "message"),
    (
        ({"forces.push.force": "A*sin(w1*t)*t/t1"}, "reads the time otherwise than in sin, cos and mod"),
        ({"forces.push.force": "A*sin(w1*t) + A*sin(t/t1)"}, "no exact ratio"),
    ),
)
def test_formulas_without_a_period_have_no_section(changes, message):
    with pytest.raises(NoSection, match=message):
        section_of(case_of(MACHINE, changes).scene())


# Several rotors that turn freely: exciters on one frame, which synchronise.


EXCITERS = """\
name: exciters
bodies: {frame: 5 kg}
links: {spring: {between: [frame, ground], k: 5 kN/m, c: 30 N s/m}}
rotors:
  left: {on: frame, m: 0.2 kg, e: 30 mm, J: 1e-4 kg m^2, M0: 0.3 N m, Omega0: 10 Hz}
  right: {on: frame, m: 0.2 kg, e: 30 mm, J: 1e-4 kg m^2, TORQUE}
initial: {left: {w: 10 Hz}, right: {phi: 160 deg, w: START}}
run: {t_end: 6 s, every: 20 ms}
"""


OF_EXCITERS = ("x_frame", "phi_left", "phi_right", "v_frame", "w_left", "w_right")


def exciters(right, sense=1):
    """With a second motor of another no-load speed [Hz], which turns forwards or backwards."""
    torque = f"M0: {sense * 0.3} N m, Omega0: {sense * right} Hz"
    text = EXCITERS.replace("TORQUE", torque).replace("START", f"{sense * right} Hz")
    return case_of(text)


def turned(state, right, sense):
    """The state when the first rotor has made its turn, and the time [s], by equations of their own."""
    m, r = 5.4, 0.006  # of all, and unbalance [kg m]
    inertia, torque = 1e-4 + 0.2 * 0.03**2, 0.3

    def rates(_, y):
        x, p, q, v, w, u = y
        mass = np.array([[m, -r * sin(p), -r * sin(q)], [-r * sin(p), inertia, 0], [-r * sin(q), 0, inertia]])
        forces = [
            -5e3 * x - 30 * v + r * (w * w * cos(p) + u * u * cos(q)),
            torque * (1 - w / (20 * pi)),
            torque * (sense - u / (2 * pi * right)),
        ]
        return [v, w, u, *np.linalg.solve(mass, forces)]

    def whole(_, y):
        return y[1] - 2 * pi

    whole.terminal = True
    course = solve_ivp(rates, (0, 1), state, "DOP853", events=whole, rtol=1e-12, atol=1e-13)
    return course.y[:, -1], course.t[-1]


def multipliers_of(start, right, sense=1):
    """Of the map from turn to turn of the first rotor, by differences of that solver."""
    free, small = [0, 2, 3, 4, 5], 1e-5
    matrix = np.zeros((5, 5))
    for column, i in enumerate(free):
        ends = []
        for by in (small, -small):
            moved = start.copy()
            moved[i] += by
            ends.append(turned(moved, right, sense)[0][free])
        matrix[:, column] = (ends[0] - ends[1]) / (2 * small)
    return np.linalg.eigvals(matrix)


@pytest.mark.parametrize(("right", "sense"), ((10.5, 1), (10.3, -1)))
def test_exciters_on_a_frame_turn_together(right, sense):
    """A turn of the first one, and one of the other: closed, and its multipliers, by another solver."""
    found = vibsim.orbit(exciters(right, sense))
    start = np.array([found.state[name] for name in OF_EXCITERS])
    end, period = turned(start, right, sense)
    assert period == pytest.approx(found.period, rel=1e-10)
    assert end - start == pytest.approx([0, 2 * pi, 2 * pi * sense, 0, 0, 0], abs=1e-8)
    assert found.turns == {"phi_right": sense}
    theirs = multipliers_of(start, right, sense)
    for multiplier in found.multipliers:
        assert abs(theirs - multiplier).min() < 1e-5


def test_the_orbits_of_two_exciters_are_a_loop_between_the_ends_of_synchronisation():
    """Round the loop one rotor gains a turn on the other; the folds are where synchronisation is lost."""
    case = case_of(EXCITERS.replace("TORQUE", "M0: 0.3 N m, Omega0: 10 Hz").replace("START", "10 Hz"))
    branch = vibsim.continue_branch(vibsim.orbit(case), "rotors.right.Omega0", "8:13 Hz")
    assert branch.closed
    low, high = sorted(branch.specials, key=lambda one: one.parameter)
    assert low.kind == high.kind == "fold" and low.parameter < 9.01 and high.parameter > 11.31
    for fold in (low, high):
        theirs = multipliers_of(np.insert(fold.orbit.state, 1, 0.0), fold.parameter)
        assert abs(theirs - 1).min() < 1e-5


# Derivatives by numbers of formulas, and many digits.


def driven(law, force):
    return case_of(DRIVEN.replace("LAW", law).replace("FORCE", force))


LINEAR = driven("k: 4 N/m, c: 0.3 N s/m", "A: 1 N, omega: 1 Hz")
FORMULA = driven('force: "k*d + c*v", k: 4 N/m, c: 0.3 N s/m', 'force: "A*sin(w*t)", A: 1 N, w: 1 Hz')


def test_derivatives_are_those_of_the_same_law_without_a_formula():
    keys = ["links.s.k", "links.s.c"]
    state = {"x_m": 0.1, "v_m": 0.2}
    plain = vibsim.monodromy(LINEAR, state=state, T=1.3, parameters=[*keys, "forces.push.omega"])
    formula = vibsim.monodromy(FORMULA, state=state, T=1.3, parameters=[*keys, "forces.push.w"])
    assert formula.matrix == pytest.approx(plain.matrix, rel=1e-12)
    for one, other in zip(plain.by_parameter.values(), formula.by_parameter.values(), strict=True):
        assert other == pytest.approx(one, rel=1e-9)


def test_many_digits_of_an_orbit_with_a_formula():
    """The amplitude of a linear oscillator under A sin(w t), w in Hz, to 25 digits."""
    mpmath = pytest.importorskip("mpmath")
    orbit = find_orbit(FORMULA.scene(), {"x_m": -0.02, "v_m": 0.0}, case=FORMULA)
    digits = refine(orbit, 25)
    with mpmath.workdps(40):
        w = 2 * mpmath.pi
        response = 1 / (4 - w * w + 1j * w * mpmath.mpf(3) / 10)
        x, v = response.imag, (1j * w * response).imag
        assert abs(mpmath.mpf(digits.state["x_m"]) - x) < 1e-24
        assert abs(mpmath.mpf(digits.state["v_m"]) - v) < 1e-23


def test_components_of_a_state_that_is_not_shown():
    """A state in a row has a number for each column, none for what is hidden."""
    case = case_of(CURRENT)
    at = ReturnMap(case.scene()).coordinates
    assert at.components == ["x_cart", "phi_left", None, "v_cart", "w_left", "i"]
    words = "components of this scene are x_cart, phi_left, v_cart, w_left, i"
    with pytest.raises(vibsim.OrbitError, match=words):
        find_orbit(case.scene(), [0.0] * 6)


PENDULUM = """\
name: pendulum
bodies: {rod: 1 kg m^2}
links: {weight: {between: [rod, ground], force: "M*sin(d) + c*v", M: 1 N m, c: 0.5 N m s/rad}}
forces: {drive: {on: rod, A: 1.35 N m, omega: 2/3 rad/s, phase: 90 deg}}
run: {t_end: 400 s, every: 50 ms}
"""


def test_a_driven_pendulum_that_turns_over_once_in_a_period_has_an_orbit():
    """x'' + x' / 2 + sin x = 1.35 cos(2 t / 3) turns, and 1.45 in place of 1.35 has twice the period:
    G. L. Baker and J. P. Gollub, Chaotic Dynamics (1990).
    """
    orbit = vibsim.orbit(case_of(PENDULUM))
    assert (orbit.n, orbit.turns) == (1, {"x_rod": -1}) and orbit.stable
    assert np.prod(orbit.multipliers).real == pytest.approx(np.exp(-0.5 * orbit.period), rel=1e-10)

    def rates(t, y):
        return [y[1], -0.5 * y[1] - np.sin(y[0]) + 1.35 * np.cos(2 * t / 3)]

    end = solve_ivp(rates, (0, orbit.period), orbit.X, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert end - orbit.X == pytest.approx([-2 * np.pi, 0.0], abs=1e-9)
    doubled = vibsim.orbit(case_of(PENDULUM), {"forces.drive.A": "1.45 N m"})
    assert (doubled.n, abs(doubled.turns["x_rod"])) == (2, 2)


def test_a_spring_beside_the_weight_leaves_no_whole_turns():
    sprung = PENDULUM.replace("M*sin(d)", "M*sin(d) + k*d").replace("c: 0.5", "k: 0.1 N m/rad, c: 0.5")
    case = case_of(sprung.replace("1.35", "0.3"))
    assert vibsim.orbit(case).turns == {}
    assert not len(ReturnMap(case.scene(), 1).coordinates.angles)
