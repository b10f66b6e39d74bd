"""What formulas, rotors and states have to do with which bodies hang together."""

import pytest

from tests.engine.runs import scene_of
from vibsim.physics.connections import (
    body_sets,
    drifting_sets,
    felt_angles,
    felt_pairs,
    force_pairs,
    joined_pairs,
    pairs_of,
)
from vibsim.physics.parts import GROUND

# Two bodies, two rotors of which the second alone has an unbalance, and a state.
BODIES = """
bodies: {a: 1 kg, b: 2 kg}
rotors:
  free: {on: a, m: 0.1 kg, e: 0 m, J: 0.1 kg m^2TORQUE}
  heavy: {on: b, m: 0.1 kg, e: 0.02 m, J: 0.1 kg m^2}
states: {i: {rate: "i/(1 s)", start: 0.5 A}}
initial: {free: {w: 5 rad/s}, heavy: {w: 5 rad/s}}
run: {t_end: 1 s}
"""
SPRING = "links: {spring: {between: [a, ground], k: 4 N/m}}"


def scene(parts="", torque=None):
    return scene_of(BODIES.replace("TORQUE", f', torque: "{torque}"' if torque else "") + parts)


def pushed(force):
    return f'forces: {{push: {{on: a, force: "{force}"}}}}'


SHAKEN = 'links: {l: {between: [a, base], force: "3 N/m*d"}}\nbase: {a: 1 mm, omega: 1 Hz}'


def held(one):
    return [(each.bodies, each.held) for each in body_sets(one, [*one.links, *one.stops])]


def test_rotors_and_states_are_in_no_set_and_no_pair():
    one = scene(SPRING)
    assert [(pair.name, pair.P, pair.Q) for pair in pairs_of(one)] == [
        ("spring", 0, GROUND),
        ("b", 1, GROUND),
    ]
    assert held(one) == [((0,), True), ((1,), False)]
    assert [each.bodies for each in drifting_sets(one)] == [(1,)]
    assert [body.name for body in one.line] == ["a", "b"]


@pytest.mark.parametrize(
    ("parts", "sets"),
    (
        (pushed("3 N/m*x_a"), [((0,), True), ((1,), False)]),  # feels where a is
        (pushed("3 N*sin((x_a - x_b)/(1 m))"), [((0, 1), False)]),  # feels how far a and b are apart
        (pushed("3 N/m^2*(x_a - x_b)*x_b"), [((0, 1), True)]),
        (SHAKEN, [((0,), True), ((1,), False)]),
        (pushed("3 N s/m/A*v_a*i"), [((0,), False), ((1,), False)]),  # velocities and states feel no place
        (pushed("3 N*sin(phi_heavy)"), [((0,), False), ((1,), False)]),  # nor does the angle of a rotor
    ),
)
def test_a_formula_joins_what_it_reads_the_difference_of(parts, sets):
    one = scene(parts)
    assert held(one) == sets
    assert [each.bodies for each in drifting_sets(one)] == [bodies for bodies, is_held in sets if not is_held]


def test_a_link_with_a_formula_of_its_distance_is_a_spring_one_of_its_rate_is_none():
    link = 'links: {s: {between: [a, b], force: "FORCE"}}'
    spring = scene(link.replace("FORCE", "0.5 N/m^3*d**3"))
    damper = scene(link.replace("FORCE", "1 N s/m*v"))
    assert [each.bodies for each in drifting_sets(spring)] == [(0, 1)]
    assert [each.bodies for each in drifting_sets(damper)] == [(0,), (1,)]


def test_a_stop_with_a_formula_holds_nothing_by_its_own_depth():
    stop = 'stops: {wall: {between: [a, b], gap: 1 mm, acts: compression, force: "FORCE"}}'
    own, other = (scene(stop.replace("FORCE", force)) for force in ("100 N/m*p", "1 N/m^2*p*x_a"))
    assert felt_pairs(own) == ()
    assert [(pair.P, pair.Q) for pair in felt_pairs(other)] == [(0, GROUND)]


def test_a_load_of_friction_that_feels_a_place_is_felt():
    rubbed = scene('friction: {rub: {between: [a, ground], N: "2 N/m*x_b", mu: 1}}')
    assert ("rub", 1, GROUND) in felt_pairs(rubbed)


def test_force_pairs_have_what_formulas_read_too():
    one = scene(f"{SPRING}\n{pushed('1 N/m*(x_a - x_b)')}")
    assert [(pair.P, pair.Q) for pair in joined_pairs(one)] == [(0, GROUND)]
    assert [(pair.P, pair.Q) for pair in force_pairs(one)] == [(0, GROUND), (0, 1)]


def test_angles_are_felt_by_an_unbalance_or_a_formula():
    assert felt_angles(scene()) == [3]
    assert felt_angles(scene(torque="1 N m*cos(phi)")) == [2, 3]
    assert felt_angles(scene(torque="1 N m s/rad*w/3")) == [3]


def test_without_formulas_nothing_is_read():
    plain = scene_of("bodies: {a: 1 kg}\nlinks: {s: {between: [a, ground], k: 1 N/m}}\nrun: {t_end: 1 s}")
    assert not plain.has_formulas and felt_pairs(plain) == () and felt_angles(plain) == []
    assert plain.line is plain.bodies
