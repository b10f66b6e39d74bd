"""Random scenes made of parts: up to four bodies with every kind of part."""

import math
from dataclasses import replace
from fractions import Fraction

from tests.random_scenes import strategy
from tests.scenes import falling
from vibsim.physics.formulas import TIME, ZERO, absolute, add, call, largest, mul, num, sub
from vibsim.physics.numbers import Doubles
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


def harmonics(draw, size, least=0):
    """Up to two harmonics of about `size`."""
    terms = []
    for _ in range(draw.integers(least, 2)):
        omega = RATE * draw.decades(-0.5, 0.7)
        amplitude, phase = size * draw.between(-1.0, 1.0), draw.sampled_from((0.0, 0.5, 2.0))
        terms.append(Harmonic(amplitude, omega, omega / (2 * math.pi), 0.0, phase))
    return tuple(terms)


def limit(draw, slipping):
    """The most that a friction holds while sticking: None, as much as while slipping, or more."""
    ratio = draw.sampled_from((None, None, 1.0, 1.3, 3.0))
    return ratio and ratio * slipping


def falls(draw, slipping):
    """Laws that fall with speed, in one direction or both; their drops beside the forces `slipping`."""
    laws = []
    for force in slipping:
        law = draw.sampled_from((None, HYPERBOLIC, EXPONENTIAL))
        drop, rate = force * draw.decades(-1, 0.5), draw.decades(-0.5, 1.5) / (RATE * LENGTH)
        laws.append(law and (law, drop, rate))
    return laws


def part_scene(draw, motor=None, radians=12.0, bodies=4, based=None):
    """A scene of 1 to `bodies` bodies. motor: True, False or None (either); based: whether on a base."""
    n = draw.integers(1, bodies)
    count = draw.integers(0, 2)
    damped = draw.booleans()
    with_base = draw.booleans() if based is None else based
    base = harmonics(draw, LENGTH, 1) if with_base else ()
    parts = []
    for i in range(n):
        x = draw.signed(LENGTH)
        parts.append(Body(f"b{i}", draw.decades(-0.5, 0.5), x, draw.signed(LENGTH * RATE)))

    def ends():
        return two_ends(draw, n, base)

    links = tuple(
        Link(f"l{i}", *ends(), RATE**2 * draw.decades(-0.5, 0.5), draw.decades(-2, 0) * RATE * damped)
        for i in range(draw.integers(0, n + 1))
    )
    stops = tuple(elastic_stop(draw, f"s{i}", ends(), damped) for i in range(draw.integers(0, 2)))
    frictions = tuple(friction(draw, f"f{i}", ends) for i in range(count))
    forces = tuple(force(draw, f"F{i}", n) for i in range(draw.integers(0, 2)))
    with_motor = draw.booleans() if motor is None else motor
    source = one_motor(draw, n) if with_motor else None
    return Scene(
        tuple(parts), links, stops, frictions, forces, base, source,
        t_end=radians / (4 * RATE), every_num=1, every_den=40,
    )  # fmt: skip


def two_ends(draw, n, base):
    """Two ends of a part, of which one is a body of n."""
    P = draw.integers(0, n - 1)
    Q = draw.sampled_from([*[k for k in range(n) if k != P], GROUND, *([BASE] if base else [])])
    return (P, Q) if draw.booleans() else (Q, P)


def elastic_stop(draw, name, ends, damped):
    """A stop with a spring, and with a damper where there are some."""
    return Stop(
        name,
        *ends,
        draw.sampled_from((0.0, 0.3, 1.0, -0.2)) * LENGTH,
        draw.sampled_from((EXTENSION, COMPRESSION)),
        RATE**2 * draw.decades(0, 1.5),
        draw.sampled_from((0.0, 0.5, 3.0)) * RATE * damped,
        draw.sampled_from((AT_GAP, AT_FORCE)),
    )


def friction(draw, name, ends):
    """A friction on a belt or none, with laws that fall or limits while sticking; ends: draws them."""
    N = draw.decades(-1.5, 0) * RATE**2 * LENGTH
    belt = draw.sampled_from((0.0, 0.0, 0.2)) * RATE * LENGTH
    slip = N, N * draw.sampled_from((1.0, 0.5))
    laws = falls(draw, slip) if draw.booleans() else None
    limits = (None, None) if laws else tuple(limit(draw, one) for one in slip)
    one = Friction(name, *ends(), *slip, belt, *limits)
    return falling(one, *laws) if laws and any(laws) else one


def force(draw, name, n):
    """A force on one of n bodies, constant, harmonic or both."""
    on = draw.integers(0, n - 1)
    return Force(name, on, draw.signed(RATE**2 * LENGTH), harmonics(draw, RATE**2 * LENGTH))


def one_motor(draw, n):
    """A motor on one of n bodies."""
    m3, e = draw.decades(-1, 0), LENGTH * draw.decades(0, 1)
    inertia = m3 * e * e
    on = draw.integers(0, n - 1)
    return Motor(on, m3, e, inertia, inertia * RATE**2, 1.5 * RATE, 0.5, draw.signed(RATE))


def rigid_scene(draw, radians=2.0, **options):
    """A scene with up to three rigid stops besides; none of its bodies starts inside one."""
    scene = part_scene(draw, radians=radians, **options)
    stops = list(scene.stops)
    places = [body.x for body in scene.bodies] + [base_start(scene), 0.0]  # BASE is -2, GROUND -1
    for i in range(draw.integers(1, 3)):
        P, Q = two_ends(draw, len(scene.bodies), scene.base)
        sense = draw.sampled_from((EXTENSION, COMPRESSION))
        touching = -(sense * (places[P] - places[Q]))
        gap = touching + draw.sampled_from((0.0, 0.0, 0.1, 0.5)) * LENGTH
        e = draw.sampled_from((0.0, 0.3, 0.5, 0.8))
        place = draw.integers(0, len(stops))
        stops.insert(place, RigidStop(f"r{i}", P, Q, gap, sense, e, gap == touching))
    return replace(scene, stops=tuple(stops))


def base_start(scene):
    """Displacement of the base at t = 0 [m]."""
    return sum((term.amplitude * Doubles.sin(term.phase) for term in scene.base), 0.0)


def belted_scene(draw, **options):
    """A scene whose frictions, if any, have belts of velocities by formulas."""
    scene = part_scene(draw, **options)
    return replace(scene, frictions=tuple(belted(draw, one) for one in scene.frictions))


def belted(draw, friction):
    """The friction, of constant forces, on a belt whose velocity is a sine."""
    angle = add(mul(decimal(draw.between(2, 20)), TIME), decimal(draw.sampled_from((0.0, 0.5, 2.0))))
    course = mul(decimal(0.2 * RATE * LENGTH * draw.between(-1, 1)), call("sin", angle))
    slips, holds = (
        tuple(map(decimal, forces)) for forces in ((friction.forward, friction.backward), friction.limits)
    )
    rises = friction.drops(1), friction.drops(-1)
    return Friction(
        friction.name, friction.P, friction.Q, 0.0, 0.0, friction.belt,
        slips=slips, holds=holds, rises=rises, course=course,
    )  # fmt: skip


def kinked_scene(draw, drawn=part_scene):
    """A scene, `drawn` on a base whose velocity jumps: A |sin(w t)|, or A sin(w t) from some time on."""
    scene = drawn(draw, based=True)
    term, t1 = scene.base[0], decimal(draw.between(0.02, 0.2))
    if draw.booleans():
        swing = absolute(call("sin", mul(decimal(term.omega), TIME)), "abs(sin(w*t))")
    else:
        swing = call("sin", mul(decimal(term.omega), largest(sub(TIME, t1), ZERO, "max(t - t1, 0)")))
    formula = add(num(Fraction(base_start(scene))), mul(decimal(term.amplitude), swing))
    return replace(scene, base=(), base_formula=formula)


def decimal(value):
    """A number of a formula to nine digits."""
    return num(Fraction(f"{value:.9g}"))


part_scenes, rigid_scenes = strategy(part_scene), strategy(rigid_scene)
