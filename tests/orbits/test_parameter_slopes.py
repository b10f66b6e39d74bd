"""Derivatives of motions by numbers of their cases, through events, against quotients in 40 digits."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import vibsim
from tests.engine.bundles import course, finished
from tests.engine.test_tangent_jacobian import numbers
from vibsim.cases.quantities import decimal_text, si_unit
from vibsim.cases.schema_keys import measured_at
from vibsim.engine.truth import bare
from vibsim.orbits.coordinates import OrbitError
from vibsim.orbits.slopes import monodromy
from vibsim.physics.precision import Balls

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
    components = [start.get(column, 0.0) for column in told.columns]
    base = finished(placed(case, components, T), KIT)
    for key in keys:
        exact, row = quotient(case, key, components, T, base), told.by_parameter[key]
        error = told.error[key]
        assert bool(error.any()) == case.scene().has_formulas  # else exact, and no quotient
        if error.any():
            assert (abs(row - exact) <= 3 * error).all() and error.max() < 1e-7 * np.abs(exact).max()
            continue
        # what rounding of the motion itself is multiplied by on its way is below 1e4 here
        np.testing.assert_allclose(row, exact, rtol=1e-10, atol=1e-11 * np.abs(exact).max(), err_msg=key)


def test_what_comes_and_goes():
    """Without friction there is no friction part, so the motion has no derivative by its coefficient."""
    case = vibsim.load_case("I-C", {"mu": "0"})
    with pytest.raises(OrbitError, match="mu is where a part comes or goes"):
        monodromy(case, state={}, T=0.1, parameters=("mu",))
