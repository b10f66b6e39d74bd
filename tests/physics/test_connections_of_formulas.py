"""How time drives formulas, where they jump, what they are near the start, and their values."""

import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import quad

from vibsim.physics import rates
from vibsim.physics.connections import Pair, event_parts, paces_of, pairs_read, reads_time
from vibsim.physics.formula_values import (
    driven_rotors,
    inputs_at,
    linear_parts,
    motion_of_base,
    potential_of,
    start_inputs,
    values_of,
)
from vibsim.physics.formulas import PI, TIME, absolute, add, call, choose, div, mul, num, power, sub
from vibsim.physics.parts import (
    BASE,
    GROUND,
    ROTOR,
    STATE,
    Body,
    Force,
    Friction,
    Harmonic,
    Link,
    Rotor,
    Scene,
)

X, V = ("x", 0), ("v", 0)


def scene(*formulas, **parts):
    """A body under forces with formulas."""
    forces = tuple(Force(f"f{i}", 0, 0.0, (), formula) for i, formula in enumerate(formulas))
    bodies = parts.pop("bodies", (Body("a", 2.0, 0.3, 0.1),))
    return Scene(bodies=bodies, forces=parts.pop("forces", forces), t_end=1.0, **parts)


def hertz(f):
    """2 pi f t."""
    return mul(mul(num(2 * Fraction(f)), PI), TIME)


def wave(rate, shift=0):
    """sin(rate t + shift)."""
    return call("sin", add(rate, num(shift)))


@pytest.mark.parametrize(
    ("formulas", "cycles", "turns"),
    (
        ((wave(hertz(3)),), 3.0, 1),
        ((mul(call("cos", hertz(3)), X), wave(hertz(2))), 3.0, 3),
        ((wave(hertz(3)), wave(hertz("4.5"), 1)), 3.0, 2),
        ((absolute(wave(hertz(3)), "abs"),), 3.0, 1),
        ((wave(mul(num(2), TIME)),), 1 / math.pi, 1),
        ((("mod", TIME, num(Fraction(1, 4)), "mod(t, 0.25)"),), 4.0, 1),
        ((call("sin", add(hertz(3), X)),), 3.0, 1),  # what reads no time may stand beside it
        ((power(wave(hertz(3)), num(2)),), 3.0, 1),
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
    period = rates.common_period(scene(wave(mul(num(2), TIME))))
    exact = 1 / Fraction("3.14159265358979323846264338327950288419716939937510")
    assert abs(Fraction(period.cycles) + Fraction(period.cycles_lo) - exact) < Fraction(1, 10**32)


@pytest.mark.parametrize(
    "formulas",
    (
        (TIME,),
        (wave(mul(TIME, TIME)),),
        (mul(wave(hertz(3)), call("exp", mul(num(-1), TIME))),),
        (wave(hertz(3)), wave(mul(num(2), TIME))),  # 3 Hz and 1/pi Hz
        (choose(sub(TIME, num(1)), num(1), num(0), "where"),),
    ),
)
def test_formulas_without_a_period(formulas):
    one = scene(*formulas)
    assert rates.common_period(one) is None and reads_time(one)


def test_formulas_that_read_no_time_have_no_rate():
    assert paces_of(scene(mul(X, V))) == [] and not rates.is_driven(scene(mul(X, V)))


def test_a_harmonic_beside_a_formula_has_their_common_period():
    push = Force("push", 0, 0.0, (Harmonic(1.0, 4 * math.pi, 2.0, 0.0, 0.0),), wave(hertz(3)))
    period = rates.common_period(scene(forces=(push,)))
    assert period is not None and float(period.end(1)) == 1.0


# The parts of events.


def test_parts_whose_formulas_jump_follow_on_those_with_states():
    jump = choose(X, num(1), num(2), "where(x_a < 0, 2, 1)")
    rub = Friction("rub", 0, GROUND, 0.0, 0.0, 0.0, slips=(jump, jump), holds=(jump, jump))
    parts = {
        "links": (Link("smooth", 0, GROUND, 0.0, 0.0, X), Link("kinked", 0, GROUND, 0.0, 0.0, jump)),
        "frictions": (rub,),
        "base_formula": absolute(TIME, "abs(t)"),
    }
    assert event_parts(scene(jump, X, **parts)) == ("rub", "kinked", "f0", "base")
    assert event_parts(scene(X)) == ()


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
    x, v, _ = motion_of_base(scene(base_formula=mul(num(Fraction(1, 100)), wave(hertz(2), 1))), times)
    angle = 4 * np.pi * times + 1
    assert x == pytest.approx(0.01 * np.sin(angle), abs=1e-16)
    assert v == pytest.approx(0.04 * np.pi * np.cos(angle), abs=1e-15)
    assert inputs_at(scene(base_formula=wave(hertz(2))), 0.1, [], [])["x", BASE] == pytest.approx(
        math.sin(0.4 * math.pi)
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
    cubic = add(mul(num(40), X), add(mul(num(100), power(X, num(3))), mul(num(5), V)))
    one = scene(mul(num(-7), call("sin", X)), links=(Link("s", 0, GROUND, 0.0, 0.0, cubic),))
    spring, gravity = linear_parts(one)
    assert (spring.k, spring.c) == (pytest.approx(40 + 300 * 0.09), 5)
    assert gravity.k == pytest.approx(7 * math.cos(0.3)) and gravity.Q == GROUND
    stiffness = 67 + 7 * math.cos(0.3)
    assert rates.natural_rates(one) == [pytest.approx(math.sqrt(stiffness / 2))]
    assert rates.fastest_damping(one) == ("s", 2.5)


def test_a_link_between_two_bodies_is_a_spring_between_them():
    two = (Body("a", 1.0, 0.0, 0.0), Body("b", 4.0, 0.0, 0.0))
    d = sub(("x", 0), ("x", 1))
    for P, Q, distance in ((0, 1, d), (1, 0, sub(("x", 1), ("x", 0)))):
        one = scene(bodies=two, links=(Link("s", P, Q, 0.0, 0.0, mul(num(20), distance)),))
        assert rates.all_rates(one) == [0.0, pytest.approx(5.0)]
    assert [Pair(*pair) for pair in pairs_read(one)] == [Pair("s", 1, 0)]


def test_a_pendulum_swings_by_its_inertia():
    """Torque -m g e cos(phi), hanging at -90 degrees: rate sqrt(m g e / J)."""
    bodies = (Body("a", 1.0, 0.0, 0.0), Body("bob", 0.04, -math.pi / 2, 0.0, kind=ROTOR))
    torque = Force("bob", 1, 0.0, (), mul(num(-2), call("cos", ("x", 1))))
    one = scene(bodies=bodies, forces=(torque,), rotors=(Rotor(1, 0, 0.2),))
    assert rates.natural_rates(one) == [pytest.approx(math.sqrt(2 / 0.04))]
    assert driven_rotors(one) == [] and rates.turning_rotor(one) is None


def test_the_rotor_that_turns_a_scene():
    """The first whose torque works forwards in a turn, or reads a current; none beside a periodic source."""
    bodies = (
        Body("a", 1.0, 0.0, 0.0),
        Body("left", 0.04, 0.0, 3.0, kind=ROTOR),
        Body("i", 1.0, 0.0, 0.0, kind=STATE),
    )
    drag = mul(num(-1), ("v", 1))
    steady = Force("left", 1, 0.0, (), add(num(2), drag))
    current = Force("left", 1, 0.0, (), add(("v", 2), drag))
    for torque in (steady, current):
        one = scene(bodies=bodies, forces=(torque,), rotors=(Rotor(1, 0, 0.2),))
        assert rates.turning_rotor(one) == 1 and rates.turning_columns(one) == ("phi_left", "w_left")
        assert rates.spins(one) == [3.0]
    braked = scene(bodies=bodies, forces=(Force("left", 1, 0.0, (), drag),))
    assert rates.turning_rotor(braked) is None
    pushed = scene(bodies=bodies, forces=(steady, Force("push", 0, 0.0, (), wave(hertz(3)))))
    assert rates.turning_rotor(pushed) is None
    two = (*bodies[:2], Body("right", 0.04, 0.0, 0.0, kind=ROTOR))
    backwards = Force("left", 1, 0.0, (), num(-2))
    forwards = Force("right", 2, 0.0, (), num(1))
    assert rates.turning_rotor(scene(bodies=two, forces=(steady, forwards))) == 1
    assert rates.turning_rotor(scene(bodies=two, forces=(backwards, forwards))) == 2
    assert rates.turning_rotor(scene(bodies=two, forces=(backwards,))) == 1


def test_a_start_has_what_formulas_read():
    assert start_inputs(scene())[X] == 0.3 and start_inputs(scene())[V] == 0.1
