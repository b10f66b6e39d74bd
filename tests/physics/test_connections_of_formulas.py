"""How time drives formulas, where they jump, what they are near the start, and their values."""

import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import quad

from tests.engine.runs import scene_of
from vibsim.physics import rates
from vibsim.physics.connections import event_parts, paces_of, pairs_read, reads_time
from vibsim.physics.formula_values import (
    driven_rotors,
    inputs_at,
    linear_parts,
    motion_of_base,
    potential_of,
    start_inputs,
    values_of,
)
from vibsim.physics.formulas import absolute, add, call, div, mul, num, power, sub
from vibsim.physics.parts import BASE, GROUND, Link

X, V = ("x", 0), ("v", 0)
NUMBERS = "{F: 1 N, L: 1 m, two: 2 Hz, three: 3 Hz, more: 4.5 Hz, pace: 2 rad/s, T: 0.25 s, I: 1 A}"


def scene(*formulas, more="", bodies="a: 2 kg", changes=None):
    """A body under forces with formulas."""
    forces = "".join(f'\n  f{i}: {{on: a, force: "{formula}"}}' for i, formula in enumerate(formulas))
    return scene_of(
        f"""
parameters: {NUMBERS}
bodies: {{{bodies}}}
initial: {{a: {{x: 0.3 m, v: 0.1 m/s}}}}
{"forces:" if formulas else ""}{forces}
{more}
run: {{t_end: 1 s}}
""",
        changes,
    )


@pytest.mark.parametrize(
    ("formulas", "cycles", "turns"),
    (
        (("F*x_a/L*sin(three*t)",), 3.0, 1),
        (("F*cos(three*t)*x_a/L*sin(two*t)",), 2.0, 2),
        (("F*x_a/L*sin(three*t)", "F*x_a/L*sin(more*t + 1)"), 3.0, 2),
        (("F*abs(sin(three*t))",), 3.0, 1),
        (("F*x_a/L*sin(pace*t)",), 1 / math.pi, 1),
        (("F*mod(t, T)/T",), 4.0, 1),
        (("F*sin(three*t + x_a/L)",), 3.0, 1),  # what reads no time may stand beside it
        (("F*sin(three*t)**2",), 3.0, 1),
    ),
)
def test_the_period_of_formulas_of_time(formulas, cycles, turns):
    period = rates.common_period(scene(*formulas))
    assert period is not None and period.cycles == cycles and period.turns == turns
    assert rates.source_period(scene(*formulas)) == pytest.approx(turns / cycles, rel=1e-15)
    assert rates.is_driven(scene(*formulas))
    assert min(rates.source_rates(scene(*formulas))) > 0


def test_a_period_in_turns_of_pi_is_right_to_thirty_digits():
    """1/pi Hz as a double-double against 50 digits."""
    period = rates.common_period(scene("F*x_a/L*sin(pace*t)"))
    exact = 1 / Fraction("3.14159265358979323846264338327950288419716939937510")
    assert abs(Fraction(period.cycles) + Fraction(period.cycles_lo) - exact) < Fraction(1, 10**32)


@pytest.mark.parametrize(
    "formulas",
    (
        ("F*t/T",),
        ("F*sin((pace*t)**2)",),
        ("F*sin(three*t)*exp(-t/T)",),
        ("F*x_a/L*sin(three*t)", "F*x_a/L*sin(pace*t)"),  # 3 Hz and 1/pi Hz
        ("F*where(t > 4*T, 1, 0)",),
    ),
)
def test_formulas_without_a_period(formulas):
    one = scene(*formulas)
    assert rates.common_period(one) is None and reads_time(one)


def test_formulas_that_read_no_time_have_no_rate():
    still = scene("F*x_a*v_a*T/L**2")
    assert paces_of(still) == [] and not rates.is_driven(still)


def test_a_harmonic_beside_a_formula_has_their_common_period():
    beside = "\n  push: {on: a, A: 1 N, omega: 2 Hz}"
    period = rates.common_period(scene("F*x_a/L*sin(three*t)", more=beside))
    assert period is not None and float(period.end(1)) == 1.0


# The parts of events.


def test_parts_whose_formulas_jump_follow_on_those_with_states():
    jump = "F*where(x_a < 0, 2, 1)"
    parts = f"""
links:
  smooth: {{between: [a, base], force: "F*d/L"}}
  kinked: {{between: [a, ground], force: "{jump}"}}
friction: {{rub: {{between: [a, ground], N: "{jump}", mu: 1}}}}
base: {{x: "L*abs(t/T)"}}
"""
    assert event_parts(scene(jump, "F*x_a/L", more=parts)) == ("rub", "kinked", "f0", "base")
    assert event_parts(scene("F*x_a/L")) == ()


# Values.


def test_values_agree_with_the_mathematical_library():
    at = {X: np.array([0.3, -0.7]), V: np.array([1.5, 2.5])}
    checks = {
        "sin": math.sin, "cos": math.cos, "exp": math.exp, "sinh": math.sinh, "cosh": math.cosh,
        "tanh": math.tanh, "atan": math.atan, "asin": math.asin, "acos": math.acos, "tan": math.tan,
    }  # fmt: skip
    for name, function in checks.items():
        assert values_of(call(name, X), at) == pytest.approx([function(0.3), function(-0.7)], rel=1e-15)
    assert values_of(call("log", V), at) == pytest.approx([math.log(1.5), math.log(2.5)], rel=1e-15)
    assert values_of(power(V, num(Fraction(3, 2))), at) == pytest.approx([1.5**1.5, 2.5**1.5], rel=1e-15)
    assert values_of(div(X, V), at).tolist() == [0.3 / 1.5, -0.7 / 2.5]
    assert values_of(absolute(X, "abs"), at).tolist() == [0.3, 0.7]
    assert values_of(("mod", X, num(Fraction(1, 2)), "mod"), at) == pytest.approx([0.3, 0.3])
    assert np.isnan(values_of(call("log", X), at)[1])


def test_a_table_keeps_its_end_values():
    knots = (Fraction(0), Fraction(1), Fraction(3))
    pieces = ((Fraction(1), Fraction(2)), (Fraction(3), Fraction(0), Fraction(-1)))
    table = ("table", X, knots, pieces, "table")
    assert values_of(table, {X: np.array([-1.0, 0.5, 1.0, 2.0, 3.0, 9.0])}).tolist() == [1, 2, 3, 2, -1, -1]


def test_a_base_and_its_velocity():
    times = np.linspace(0, 1, 7)
    base = 'links: {s: {between: [a, base], k: 1 N/m}}\nbase: {x: "0.01*L*sin(two*t + 1)"}'
    x, v, _ = motion_of_base(scene(more=base), times)
    angle = 4 * np.pi * times + 1
    assert x == pytest.approx(0.01 * np.sin(angle), abs=1e-16)
    assert v == pytest.approx(0.04 * np.pi * np.cos(angle), abs=1e-15)
    assert inputs_at(scene(more=base), 0.1, [], [])["x", BASE] == pytest.approx(
        0.01 * math.sin(0.4 * math.pi + 1)
    )


def test_the_energy_of_a_link_is_the_integral_of_its_force():
    """sinh and a cube, from either end of the link, against adaptive quadrature."""
    for P, Q in ((0, GROUND), (GROUND, 0), (0, 1)):
        ends = [num(0) if end == GROUND else ("x", end) for end in (P, Q)]
        d = sub(*ends)
        link = Link("s", P, Q, 0.0, 0.0, add(call("sinh", mul(num(3), d)), power(d, num(3))))
        for distance in (0.7, -1.3):
            exact, _ = quad(lambda y: math.sinh(3 * y) + y**3, 0, distance, epsabs=1e-13)
            assert potential_of(link, distance) == pytest.approx(exact, rel=1e-12)


# What formulas are near the start.


def test_springs_and_dampers_near_the_start():
    """k x + k3 x^3 at x = 0.3: k + 3 k3 x^2; sin has slope cos."""
    link = 'links: {s: {between: [a, ground], force: "F*(40*d/L + 100*(d/L)**3 + 20*v*T/L)"}}'
    one = scene("-7*F*sin(x_a/L)", more=link)
    spring, gravity = linear_parts(one)
    assert (spring.k, spring.c) == (pytest.approx(40 + 300 * 0.09), 5)
    assert gravity.k == pytest.approx(7 * math.cos(0.3)) and gravity.Q == GROUND
    stiffness = 67 + 7 * math.cos(0.3)
    assert rates.natural_rates(one) == [pytest.approx(math.sqrt(stiffness / 2))]
    assert rates.fastest_damping(one) == ("s", 2.5)


def test_a_link_between_two_bodies_is_a_spring_between_them():
    for ends in ("[a, b]", "[b, a]"):
        link = f'links: {{s: {{between: {ends}, force: "20*F*sin(d/L)"}}}}'
        one = scene(bodies="a: 1 kg, b: 4 kg", more=link, changes={"initial.a.x": 0})
        assert rates.all_rates(one) == [0.0, pytest.approx(5.0)]
        assert [(name, {P, Q}) for name, P, Q in pairs_read(one)] == [("s", {0, 1})]


def test_a_pendulum_swings_by_its_inertia():
    """Torque -m g e cos(phi), hanging at -90 degrees: rate sqrt(m g e / J)."""
    bob = 'rotors: {bob: {on: a, m: 0.1 kg, e: 0.2 m, J: 0.036 kg m^2, torque: "-2*F*L*cos(phi)"}}'
    one = scene(more=bob, changes={"initial.bob.phi": "-90 deg"})
    assert rates.natural_rates(one) == [pytest.approx(math.sqrt(2 / 0.04))]
    assert driven_rotors(one) == [] and rates.turning_rotor(one) is None


def turned(left, right=None, formulas=()):
    """A body with one or two rotors under such torques, and a current."""
    torques = {"left": left} | ({"right": right} if right else {})
    rotor = "on: a, m: 0.1 kg, e: 0.2 m, J: 0.036 kg m^2"
    rotors = [f'{name}: {{{rotor}, torque: "{torque}"}}' for name, torque in torques.items()]
    more = f'rotors: {{{", ".join(rotors)}}}\nstates: {{i: {{rate: "0*I/T", start: 0 A}}}}'
    return scene(*formulas, more=more, changes={"initial.left.w": "3 rad/s"})


def test_the_rotor_that_turns_a_scene():
    """The first whose torque works forwards in a turn, or reads a current; none beside a periodic source."""
    steady, current, braked = (turned(f"F*L*({torque} - w*T)") for torque in ("2", "i/I", "0"))
    for one in (steady, current):
        assert rates.turning_rotor(one) == 1 and rates.turning_columns(one) == ("phi_left", "w_left")
        assert rates.spins(one) == [3.0]
    assert rates.turning_rotor(braked) is None
    forwards, backwards = "2*F*L", "-2*F*L"
    assert rates.turning_rotor(turned(forwards, formulas=("F*x_a/L*sin(three*t)",))) is None
    assert rates.turning_rotor(turned(forwards, forwards)) == 1
    assert rates.turning_rotor(turned(backwards, forwards)) == 2
    assert rates.turning_rotor(turned(backwards)) == 1


def test_a_start_has_what_formulas_read():
    assert start_inputs(scene())[X] == 0.3 and start_inputs(scene())[V] == 0.1
