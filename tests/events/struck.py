"""Random scenes of rigid impacts that others hardly draw: of a body that carries a motor, and of several
bodies at one instant.
"""

from tests.events.coincidences import harmonic
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Force,
    Friction,
    Link,
    Motor,
    RigidStop,
    Scene,
)

DYADIC = (0.25, 0.5, 1.0, 2.0)


def with_motor(draw):
    """One to three bodies, one of which carries a motor, among rigid stops; draw: a random.Random."""
    pick, even = draw.choice, draw.uniform
    n = pick([1, 1, 2, 2, 3])
    bodies = [Body(f"b{i}", even(0.4, 2.0), 0.0, pick([0.0, even(-0.3, 0.3)])) for i in range(n)]
    base = (harmonic(even(0.001, 0.01), even(5.0, 20.0), 0.0),) if draw.random() < 0.4 else ()
    frame = pick([GROUND, BASE]) if base else GROUND
    links = [Link("l0", 0, pick([frame, GROUND]), even(20.0, 200.0), pick([0.0, even(0.1, 2.0)]))]
    links += [Link(f"l{i}", i, i - 1, even(20.0, 200.0), pick([0.0, even(0.1, 2.0)])) for i in range(1, n)]
    stops = []
    for i in range(pick([1, 2, 2, 3])):
        P = draw.randrange(n)
        Q = pick([frame, GROUND, *(other for other in range(n) if other != P)])
        gap = pick([0.0, even(0.0, 0.02), even(0.0, 0.02)])
        stops.append(
            RigidStop(f"s{i}", P, Q, gap, pick([EXTENSION, COMPRESSION]), even(0.0, 0.9), gap == 0.0)
        )
    frictions = [
        Friction(
            "f", draw.randrange(n), pick([GROUND, frame]), limit, limit, pick([0.0, 0.0, even(-0.2, 0.2)])
        )
        for limit in [even(0.05, 2.0)] * pick([0, 0, 1])
    ]
    m3, e, speed = even(0.05, 0.5), even(0.01, 0.1), even(5.0, 40.0)
    inertia = m3 * e * e * even(0.5, 4.0)
    turning = pick([0.0, speed, even(-speed, speed)])
    motor = Motor(
        draw.randrange(n), m3, e, inertia, inertia * even(0.0, 200.0), speed, even(-3.0, 3.0), turning
    )
    forces = (Force("F", draw.randrange(n), even(-3.0, 3.0), ()),) if draw.random() < 0.4 else ()
    return Scene(
        tuple(bodies), tuple(links), tuple(stops), tuple(frictions), forces, base, motor,
        t_end=1.0, every_num=1, every_den=50,
    )  # fmt: skip


def at_once(draw):
    """Up to nine bodies in a row, a group of which touch each other while others strike it from one side or,
    as mirror images, from both; with walls, frictions, springs, and a motor now and then. draw: a
    random.Random.
    """
    pick, often = draw.choice, draw.random
    bodies = row(draw)
    last, e = len(bodies) - 1, pick([0.0, 0.5, 0.75, 1.0])
    stops = [
        RigidStop(f"s{i}", i, i + 1, 0.0, COMPRESSION, pick([e, e, e, 0.5]), one.x == bodies[i + 1].x)
        for i, one in enumerate(bodies[:-1])
    ]
    if often() < 0.5:
        stops.append(RigidStop("wall", last, GROUND, pick([0.25, 1.0]), COMPRESSION, e))
    if often() < 0.3:
        stops.append(RigidStop("other", 0, GROUND, 0.5, EXTENSION, e))
    limit, rubbing, held = pick([0.25, 0.5, 2.0]), pick([0.0, 0.0, 0.5, 1.0]), pick([0.0, 0.0, 0.3])
    rubbing = [i for i in range(last + 1) if often() < rubbing]
    frictions = [Friction(f"f{i}", i, GROUND, limit, limit, 0.0) for i in rubbing]
    held = [i for i in range(last + 1) if often() < held]
    links = [Link(f"l{i}", i, pick([GROUND, *range(i)]), pick([16.0, 64.0]), 0.0) for i in held]
    forces = [Force("F", draw.randint(0, last), pick([1.0, -1.0]), ())] * pick([0, 0, 1])
    motor = None
    if often() < 0.25:
        m3, arm = 0.25, pick([0.125, 0.0625])
        inertia = 2 * m3 * arm * arm
        on, phi, begins = draw.randint(0, last), draw.uniform(-3.0, 3.0), pick([0.0, 8.0])
        motor = Motor(on, m3, arm, inertia, inertia * 16.0, 16.0, phi, begins)
    return Scene(
        bodies, tuple(links), tuple(stops), tuple(frictions), tuple(forces), (), motor,
        t_end=0.99, every_num=1, every_den=50,
    )  # fmt: skip


def row(draw):
    """Bodies that stand at 0, and such as fly at them in pairs or alone: all numbers are exact, so what is a
    mirror image arrives at one instant.
    """
    pick = draw.choice
    room, speed = pick([0.125, 0.0625]), pick([0.5, 1.0])
    groups = [[pick(DYADIC) for _ in range(pick([1, 1, 2]))] for _ in range(pick([1, 2]))]
    flying = [(-room * (len(groups) - i), m, speed) for i, group in enumerate(groups) for m in group]
    middle = [pick(DYADIC) for _ in range(pick([0, 1, 1, 2, 3]))]
    opposite = []
    if draw.random() < 0.6:
        opposite = [(-x, m, -v) for x, m, v in reversed(flying)]
        middle = [*middle[:2], *middle[:1]] if len(middle) > 1 else middle
    standing = [(0.0, m, 0.0) for m in middle]
    return tuple(Body(f"b{i}", m, x, v) for i, (x, m, v) in enumerate([*flying, *standing, *opposite]))
