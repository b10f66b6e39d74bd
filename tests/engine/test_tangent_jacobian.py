"""The tangent flow of scenes made of parts is the derivative of the motion, events included: difference
quotients in 40 digits.
"""

from dataclasses import replace
from math import pi

import pytest
from hypothesis import given, settings

from tests.engine.bundles import course, finished, in_digits, started
from tests.engine.random_parts import part_scenes
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.tangent.tangent_space import Gauge, TangentSpace
from vibsim.physics.parts import (
    AT_FORCE,
    AT_GAP,
    BASE,
    COMPRESSION,
    EVENT_NAMES,
    EXTENSION,
    GROUND,
    Body,
    Friction,
    Harmonic,
    Link,
    Motor,
    Scene,
    Stop,
)
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


def harmonic(amplitude, frequency, phase=0.0):
    return Harmonic(amplitude, 2 * pi * frequency, frequency, 0.0, phase)


def hammer(release, sense=COMPRESSION):
    """A body on a damped stop of a second one, which rubs on the ground and is shaken."""
    return Scene(
        (Body("a", 1.0, 0.0, 0.3), Body("b", 2.0, 0.0, 0.01)),
        links=(Link("l", 0, 1, 30.0, 0.1), Link("k", 1, BASE, 80.0, 0.5)),
        stops=(Stop("s", 0, 1, 0.004, sense, 500.0, 12.0, release),),
        frictions=(Friction("f", 1, GROUND, 0.6, 0.4, 0.0),),
        base=(harmonic(0.01, 0.7, 0.2),),
        t_end=1.2,
    )


SCENES = {
    "damped stop, to its gap": (hammer(AT_GAP), {"contact_begin", "contact_end", "stick_begin"}),
    "damped stop, to its force": (hammer(AT_FORCE), {"contact_begin", "contact_end", "stick_begin"}),
    "friction against the moving base": (
        Scene(
            (Body("a", 1.0, 0.0, 0.0), Body("b", 0.5, 0.01, 0.1)),
            links=(Link("l", 0, 1, 60.0, 0.2), Link("k", 0, GROUND, 20.0, 0.0)),
            frictions=(Friction("f", 0, BASE, 0.3, 0.3, 0.02),),
            base=(harmonic(0.02, 1.1, 0.5),),
            t_end=1.5,
        ),
        {"stick_begin", "stick_end"},
    ),
    "motor on a body that sticks to another": (
        Scene(
            (Body("a", 1.0, 0.0, 0.1), Body("b", 2.0, 0.0, 0.0)),
            links=(Link("k", 1, GROUND, 90.0, 0.3),),
            stops=(Stop("s", 0, GROUND, 0.01, EXTENSION, 400.0, 3.0, AT_FORCE),),
            frictions=(Friction("f", 0, 1, 0.9, 0.6, 0.0),),
            motor=Motor(0, 0.1, 0.05, 3e-4, 2e-2, 15.0, 0.4, 12.0),
            t_end=0.75,
        ),
        {"stick_begin", "stick_end"},
    ),
    "friction that drops where it begins to slip": (
        Scene(
            (Body("a", 1.0, 0.0, 0.3), Body("b", 0.5, 0.0, 0.1)),
            links=(Link("k", 0, GROUND, 50.0, 0.3), Link("l", 1, BASE, 30.0, 0.1)),
            frictions=(
                Friction("f", 0, GROUND, 2.0, 2.0, 0.3, 3.5, 3.5),
                Friction("g", 1, 0, 0.4, 0.4, 0.0, 0.6, 0.6),
            ),
            base=(harmonic(0.02, 1.1, 0.5),),
            t_end=1.5,
        ),
        {"stick_begin", "stick_end"},
    ),
    "motor on a body that drops": (
        Scene(
            (Body("a", 1.0, 0.0, 0.1), Body("b", 2.0, 0.0, 0.0)),
            links=(Link("k", 1, GROUND, 90.0, 0.3),),
            frictions=(
                Friction("f", 0, 1, 0.5, 0.5, 0.0, 0.7, 0.7),
                Friction("g", 1, GROUND, 0.4, 0.4, 0.0, 0.6, 0.6),
            ),
            motor=Motor(0, 0.1, 0.05, 3e-4, 2e-2, 15.0, 0.4, 12.0),
            t_end=0.6,
        ),
        {"stick_begin", "stick_end"},
    ),
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
