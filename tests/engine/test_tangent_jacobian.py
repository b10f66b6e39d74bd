"""The tangent flow of scenes made of parts is the derivative of the motion, events included: difference
quotients in 40 digits.
"""

from dataclasses import replace

import pytest
from hypothesis import given, settings

from tests.engine.bundles import course, finished, in_digits, started
from tests.engine.random_parts import part_scenes
from tests.engine.runs import scene_of
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.tangent.tangent_space import Gauge, TangentSpace
from vibsim.physics.parts import EVENT_NAMES
from vibsim.physics.precision import Balls

DIGITS = 40
SHIFT = "1e-18"  # the quotient is then wrong by 1e-18 times the second derivative, and by 1e-40 / 1e-18
CLOSE = 1e-12  # numbers given as doubles, omega and omega / (2 pi) among them, agree to 1e-16


def quotients(scene):
    """Yields (tangent flow, difference quotient, kinds of events) for the disturbances that the start
    allows; none where the shifted motion takes another course, or the motion has no derivative.
    """
    kit = Balls(DIGITS)
    scene, shift, gauge = in_digits(scene, kit), kit.number(SHIFT), Gauge(scene)
    base = finished(scene, kit)
    rows = RowMaker(scene, kit).rows(base.events[0][3])
    for vector in TangentSpace(scene, kit, rows).inside:
        moved = finished(started(scene, [shift * value for value in vector]), kit)
        if course(moved) != course(base):
            continue
        bundle = finished(scene, kit, vector).tangent
        if bundle.tangencies.undefined:
            continue
        size = 0 if bundle.lost[0] else kit.exp(bundle.sums[0])
        ours = [size * value for value in bundle.vectors[0]]
        ends = zip(numbers(moved), numbers(base), strict=True)
        theirs = gauge.apply(kit, [(after - before) / shift for after, before in ends])
        yield ours, theirs, {EVENT_NAMES[kind] for kind, *_ in base.events}


def numbers(driver):
    """(x, v, phi, w) at the end."""
    rotor = (driver.state.phase, driver.state.w) if driver.scene.motor is not None else ()
    return [*driver.state.x, *driver.state.v, *rotor]


def assert_derivative(scene):
    """Compares all columns; returns their number and the kinds of the events."""
    columns, kinds = 0, set()
    for ours, theirs, happened in quotients(scene):
        largest = max(max(abs(float(value.mid())) for value in theirs), 1e-3)
        for one, other in zip(ours, theirs, strict=True):
            assert abs(float((one - other).mid())) < CLOSE * largest
        columns, kinds = columns + 1, happened
    return columns, kinds


HAMMER = """
bodies: {a: 1 kg, b: 2 kg}
links: {l: {between: [a, b], k: 30 N/m, c: 0.1 N s/m}, k: {between: [b, base], k: 80 N/m, c: 0.5 N s/m}}
stops: {s: {between: [a, b], gap: 4 mm, acts: compression, k: 500 N/m, c: 12 N s/m, release: gap}}
friction: {f: {between: [b, ground], N: 1 N, plus: {mu: 0.6}, minus: {mu: 0.4}}}
base: {a: 1 cm, omega: 0.7 Hz, phase: 0.2 rad}
initial: {a: {v: 0.3 m/s}, b: {v: 0.01 m/s}}
run: {t_end: 1.2 s, every: 50 ms}
"""
ON_BASE = """
bodies: {a: 1 kg, b: 0.5 kg}
links: {l: {between: [a, b], k: 60 N/m, c: 0.2 N s/m}, k: {between: [a, ground], k: 20 N/m}}
friction: {f: {between: [a, base], N: 0.3 N, mu: 1, belt: 0.02 m/s}}
base: {a: 2 cm, omega: 1.1 Hz, phase: 0.5 rad}
initial: {b: {x: 1 cm, v: 0.1 m/s}}
run: {t_end: 1.5 s, every: 50 ms}
"""
STATIC = """
bodies: {a: 1 kg, b: 0.5 kg}
links: {k: {between: [a, ground], k: 50 N/m, c: 0.3 N s/m}, l: {between: [b, base], k: 30 N/m, c: 0.1 N s/m}}
friction:
  f: {between: [a, ground], N: 2 N, mu: 1, static: 1.75, belt: 0.3 m/s}
  g: {between: [b, a], N: 0.4 N, mu: 1, static: 1.5}
base: {a: 2 cm, omega: 1.1 Hz, phase: 0.5 rad}
initial: {a: {v: 0.3 m/s}, b: {v: 0.1 m/s}}
run: {t_end: 1.5 s, every: 50 ms}
"""
MOTOR = """
bodies: {a: 0.9 kg, b: 2 kg}
links: {k: {between: [b, ground], k: 90 N/m, c: 0.3 N s/m}}
motor: {on: a, m3: 0.1 kg, e: 5 cm, J: 3e-4 kg m^2, M0: 0.02 N m, Omega0: 15 rad/s}
initial: {a: {v: 0.1 m/s}, motor: {phi: 0.4 rad, phidot: 12 rad/s}}
"""
STICKING = """
stops: {s: {between: [a, ground], gap: 1 cm, acts: extension, k: 400 N/m, c: 3 N s/m, release: force}}
friction: {f: {between: [a, b], N: 1 N, plus: {mu: 0.9}, minus: {mu: 0.6}}}
run: {t_end: 0.75 s, every: 50 ms}
"""
DROPPING = """
friction:
  f: {between: [a, b], N: 0.5 N, mu: 1, static: 1.4}
  g: {between: [b, ground], N: 0.4 N, mu: 1, static: 1.5}
run: {t_end: 0.6 s, every: 50 ms}
"""
STRUCK, STUCK = {"contact_begin", "contact_end", "stick_begin"}, {"stick_begin", "stick_end"}
SCENES = {
    "damped stop, to its gap": (scene_of(HAMMER), STRUCK),
    "damped stop, to its force": (scene_of(HAMMER, {"s.release": "force"}), STRUCK),
    "friction against the moving base": (scene_of(ON_BASE), STUCK),
    "motor on a body that sticks to another": (scene_of(MOTOR + STICKING), STUCK),
    "friction that drops where it begins to slip": (scene_of(STATIC), STUCK),
    "motor on a body that drops": (scene_of(MOTOR + DROPPING), STUCK),
}


@pytest.mark.parametrize("label", SCENES)
def test_chosen_scenes(label):
    scene, expected = SCENES[label]
    columns, kinds = assert_derivative(scene)
    assert columns >= 3 and kinds >= expected


@settings(max_examples=3)
@given(part_scenes(radians=8.0, bodies=3))
def test_random_scenes(scene):
    assert_derivative(scene)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@settings(max_examples=300)
@given(part_scenes())
def test_many_random_scenes(scene):
    assert_derivative(scene)
    assert_derivative(replace(scene, method="taylor"))
