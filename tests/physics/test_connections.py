"""What formulas, rotors and states have to do with which bodies hang together."""

from fractions import Fraction

import pytest

from vibsim.physics.connections import (
    body_sets,
    drifting_sets,
    felt_angles,
    felt_pairs,
    force_pairs,
    joined_pairs,
    pairs_of,
)
from vibsim.physics.formulas import call, div, mul, num, sub
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    GROUND,
    ROTOR,
    STATE,
    Body,
    Force,
    Friction,
    Link,
    Rotor,
    Scene,
    Stop,
)

A, B = ("x", 0), ("x", 1)
APART = sub(A, B)


def scene(**parts):
    """Two bodies, two rotors of which the second alone has an unbalance, and a state."""
    bodies = (
        Body("a", 1.0, 0.0, 0.0),
        Body("b", 2.0, 0.0, 0.0),
        Body("free", 0.1, 0.0, 5.0, kind=ROTOR),
        Body("heavy", 0.1, 0.0, 5.0, kind=ROTOR),
        Body("i", 1.0, 0.0, 0.5, kind=STATE),
    )
    return Scene(bodies=bodies, rotors=(Rotor(2, 0, 0.0), Rotor(3, 1, 0.02)), t_end=1.0, **parts)


def force(formula, on=0, name="push"):
    return Force(name, on, 0.0, (), formula)


def held(one):
    return [(each.bodies, each.held) for each in body_sets(one, [*one.links, *one.stops])]


def test_rotors_and_states_are_in_no_set_and_no_pair():
    one = scene(links=(Link("spring", 0, GROUND, 4.0, 0.0),))
    assert [(pair.name, pair.P, pair.Q) for pair in pairs_of(one)] == [
        ("spring", 0, GROUND),
        ("b", 1, GROUND),
    ]
    assert held(one) == [((0,), True), ((1,), False)]
    assert [each.bodies for each in drifting_sets(one)] == [(1,)]
    assert [body.name for body in one.line] == ["a", "b"]


@pytest.mark.parametrize(
    ("formula", "sets"),
    (
        (mul(num(3), A), [((0,), True), ((1,), False)]),  # feels where a is
        (call("sin", APART), [((0, 1), False)]),  # feels how far a and b are apart
        (mul(APART, B), [((0, 1), True)]),
        (sub(A, ("x", BASE)), [((0,), True), ((1,), False)]),
        (mul(("v", 0), ("v", 4)), [((0,), False), ((1,), False)]),  # velocities and states feel no place
        (call("sin", ("x", 3)), [((0,), False), ((1,), False)]),  # nor does the angle of a rotor
    ),
)
def test_a_formula_joins_what_it_reads_the_difference_of(formula, sets):
    one = scene(forces=(force(formula),))
    assert held(one) == sets
    assert [each.bodies for each in drifting_sets(one)] == [bodies for bodies, is_held in sets if not is_held]


def test_a_link_with_a_formula_of_its_distance_is_a_spring_one_of_its_rate_is_none():
    cubic = mul(num(Fraction(1, 2)), mul(APART, mul(APART, APART)))
    spring = scene(links=(Link("s", 0, 1, 0.0, 0.0, cubic),))
    damper = scene(links=(Link("s", 0, 1, 0.0, 0.0, sub(("v", 0), ("v", 1))),))
    assert [each.bodies for each in drifting_sets(spring)] == [(0, 1)]
    assert [each.bodies for each in drifting_sets(damper)] == [(0,), (1,)]


def test_a_stop_with_a_formula_holds_nothing_by_its_own_depth():
    depth = sub(sub(B, A), num(Fraction(1, 1000)))
    own = Stop("wall", 0, 1, 0.001, COMPRESSION, 0.0, 0.0, force=mul(num(100), depth))
    assert felt_pairs(scene(stops=(own,))) == ()
    other = Stop("wall", 0, 1, 0.001, COMPRESSION, 0.0, 0.0, force=mul(depth, A))
    assert [(pair.P, pair.Q) for pair in felt_pairs(scene(stops=(other,)))] == [(0, GROUND)]


def test_a_load_of_friction_that_feels_a_place_is_felt():
    rub = Friction("rub", 0, GROUND, 0.0, 0.0, 0.0, slips=(B, B), holds=(B, B))
    assert ("rub", 1, GROUND) in felt_pairs(scene(frictions=(rub,)))


def test_force_pairs_have_what_formulas_read_too():
    one = scene(links=(Link("spring", 0, GROUND, 4.0, 0.0),), forces=(force(APART),))
    assert [(pair.P, pair.Q) for pair in joined_pairs(one)] == [(0, GROUND)]
    assert [(pair.P, pair.Q) for pair in force_pairs(one)] == [(0, GROUND), (0, 1)]


def test_angles_are_felt_by_an_unbalance_or_a_formula():
    assert felt_angles(scene()) == [3]
    assert felt_angles(scene(forces=(force(call("cos", ("x", 2)), 2, "free"),))) == [2, 3]
    assert felt_angles(scene(forces=(force(div(("v", 2), num(3)), 2, "free"),))) == [3]


def test_without_formulas_nothing_is_read():
    plain = Scene(bodies=(Body("a", 1.0, 0.0, 0.0),), links=(Link("s", 0, GROUND, 1.0, 0.0),), t_end=1.0)
    assert not plain.has_formulas and felt_pairs(plain) == () and felt_angles(plain) == []
    assert plain.line is plain.bodies
