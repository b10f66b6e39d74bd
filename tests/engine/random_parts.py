"""Random scenes made of parts: up to four bodies with every kind of part, short enough for the Python
engine.
"""

import math
from dataclasses import replace

from hypothesis import strategies as st

from tests.random_scenes import between, decades, signed
from tests.scenes import falling
from vibsim.physics.parts import (
    AT_FORCE,
    AT_GAP,
    BASE,
    COMPRESSION,
    EXPONENTIAL,
    EXTENSION,
    GROUND,
    HYPERBOLIC,
    Body,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    RigidStop,
    Scene,
    Stop,
)

LENGTH, RATE = 0.01, 2 * math.pi  # scales of displacements [m] and rates [rad/s]


@st.composite
def harmonics(draw, size, least=0):
    """Up to two harmonics of about `size`."""
    terms = []
    for _ in range(draw(st.integers(least, 2))):
        omega = RATE * draw(decades(-0.5, 0.7))
        amplitude, phase = size * draw(between(-1.0, 1.0)), draw(st.sampled_from((0.0, 0.5, 2.0)))
        terms.append(Harmonic(amplitude, omega, omega / (2 * math.pi), 0.0, phase))
    return tuple(terms)


def holds(slipping):
    """Limits while sticking: None, as much as while slipping, or more."""
    return st.sampled_from((None, None, 1.0, 1.3, 3.0)).map(lambda ratio: ratio and ratio * slipping)


@st.composite
def falls(draw, slipping):
    """Laws that fall with speed, in one direction or both; their drops beside the forces `slipping`."""
    laws = []
    for force in slipping:
        law = draw(st.sampled_from((None, HYPERBOLIC, EXPONENTIAL)))
        drop, rate = force * draw(decades(-1, 0.5)), draw(decades(-0.5, 1.5)) / (RATE * LENGTH)
        laws.append(law and (law, drop, rate))
    return laws


@st.composite
def part_scenes(draw, motor=None, radians=12.0, bodies=4):
    """A scene of 1 to `bodies` bodies. motor: True, False or None (either)."""
    n = draw(st.integers(1, bodies))
    count = draw(st.integers(0, 2))
    damped = draw(st.booleans())
    base = draw(harmonics(LENGTH, 1)) if draw(st.booleans()) else ()
    parts = []
    for i in range(n):
        x = draw(signed(LENGTH))
        parts.append(Body(f"b{i}", draw(decades(-0.5, 0.5)), x, draw(signed(LENGTH * RATE))))

    def ends():
        P = draw(st.integers(0, n - 1))
        Q = draw(st.sampled_from([*[k for k in range(n) if k != P], GROUND, *([BASE] if base else [])]))
        return (P, Q) if draw(st.booleans()) else (Q, P)

    links = tuple(
        Link(f"l{i}", *ends(), RATE**2 * draw(decades(-0.5, 0.5)), draw(decades(-2, 0)) * RATE * damped)
        for i in range(draw(st.integers(0, n + 1)))
    )
    stops = tuple(elastic_stop(draw, f"s{i}", ends(), damped) for i in range(draw(st.integers(0, 2))))
    frictions = tuple(friction(draw, f"f{i}", ends) for i in range(count))
    forces = tuple(force(draw, f"F{i}", n) for i in range(draw(st.integers(0, 2))))
    with_motor = draw(st.booleans()) if motor is None else motor
    source = one_motor(draw, n) if with_motor else None
    return Scene(
        tuple(parts), links, stops, frictions, forces, base, source,
        t_end=radians / (4 * RATE), every_num=1, every_den=40,
    )  # fmt: skip


def elastic_stop(draw, name, ends, damped):
    """A stop with a spring, and with a damper where there are some."""
    return Stop(
        name,
        *ends,
        draw(st.sampled_from((0.0, 0.3, 1.0, -0.2))) * LENGTH,
        draw(st.sampled_from((EXTENSION, COMPRESSION))),
        RATE**2 * draw(decades(0, 1.5)),
        draw(st.sampled_from((0.0, 0.5, 3.0))) * RATE * damped,
        draw(st.sampled_from((AT_GAP, AT_FORCE))),
    )


def friction(draw, name, ends):
    """A friction on a belt or none, with laws that fall or limits while sticking; ends: draws them."""
    N = draw(decades(-1.5, 0)) * RATE**2 * LENGTH
    belt = draw(st.sampled_from((0.0, 0.0, 0.2))) * RATE * LENGTH
    slip = N, N * draw(st.sampled_from((1.0, 0.5)))
    laws = draw(falls(slip)) if draw(st.booleans()) else None
    limits = (None, None) if laws else tuple(draw(holds(limit)) for limit in slip)
    one = Friction(name, *ends(), *slip, belt, *limits)
    return falling(one, *laws) if laws and any(laws) else one


def force(draw, name, n):
    """A force on one of n bodies, constant, harmonic or both."""
    on = draw(st.integers(0, n - 1))
    return Force(name, on, draw(signed(RATE**2 * LENGTH)), draw(harmonics(RATE**2 * LENGTH)))


def one_motor(draw, n):
    """A motor on one of n bodies."""
    m3, e = draw(decades(-1, 0)), LENGTH * draw(decades(0, 1))
    inertia = m3 * e * e
    on = draw(st.integers(0, n - 1))
    return Motor(on, m3, e, inertia, inertia * RATE**2, 1.5 * RATE, 0.5, draw(signed(RATE)))


@st.composite
def rigid_scenes(draw, radians=2.0, **options):
    """A scene with up to three rigid stops besides; none of its bodies starts inside one."""
    scene = draw(part_scenes(radians=radians, **options))
    n, stops = len(scene.bodies), list(scene.stops)
    X = sum((term.amplitude * math.sin(term.phase) for term in scene.base), 0.0)
    places = [body.x for body in scene.bodies] + [X, 0.0]  # BASE is -2, GROUND -1
    for i in range(draw(st.integers(1, 3))):
        P = draw(st.integers(0, n - 1))
        Q = draw(st.sampled_from([*[k for k in range(n) if k != P], GROUND, *([BASE] if scene.base else [])]))
        P, Q = (P, Q) if draw(st.booleans()) else (Q, P)
        sense = draw(st.sampled_from((EXTENSION, COMPRESSION)))
        touching = -(sense * (places[P] - places[Q]))
        gap = touching + draw(st.sampled_from((0.0, 0.0, 0.1, 0.5))) * LENGTH
        e = draw(st.sampled_from((0.0, 0.3, 0.5, 0.8)))
        stops.insert(
            draw(st.integers(0, len(stops))), RigidStop(f"r{i}", P, Q, gap, sense, e, gap == touching)
        )
    return replace(scene, stops=tuple(stops))
