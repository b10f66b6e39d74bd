"""Random chains of bodies at rest: driven somewhere, some of their ends touch stops from the start on."""

import math

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
    RigidStop,
    Scene,
    Stop,
)


def chain(draw):
    """Two to five bodies in a row, mostly linked, with up to three stops, a friction, a shaken base, forces,
    and one that flies at them; draw: a random.Random.
    """
    pick, often = draw.choice, draw.random
    n, k, omega = pick([2, 3, 3, 4, 4, 5]), pick([87.3, 100.0, 64.0]), pick([5.0, 7.0, 9.344])
    frame = pick([GROUND, BASE])
    bodies = [Body(f"b{i}", pick([1.0, 1.0, 1.0, 1.0, 0.5, 0.7]), 0.0, 0.0) for i in range(n)]
    places = [(i, i - 1 if i else pick([frame, frame, GROUND])) for i in range(n) if often() > 0.15]
    links = [Link(f"l{P}", P, Q, k, pick([0.0] * 4 + [0.02 * k])) for P, Q in places]
    stops = list(touching(draw, n, k, frame))
    frictions = (Friction("f", draw.randrange(n), GROUND, 0.3, 0.3, 0.0),) if often() < 0.35 else ()
    base = (harmonic(0.02, omega, 0.0),) if frame == BASE else ()
    forces = ()
    if not base or often() < 0.3:
        drive = harmonic(pick([1.0, 0.5, 2.0]), omega, pick([0.0, 0.0, math.pi / 2]))
        forces = (Force("F", draw.randrange(n), pick([0.0, 1.0, -1.0]), (drive,)),)
    if often() < 0.35:
        bodies.append(Body("hammer", 1.0, -0.1, 1.0))
        blow = n, draw.randrange(n), 0.0, COMPRESSION
        stops.append(pick([RigidStop("blow", *blow, pick([0.5, 0.8])), Stop("blow", *blow, 1e4, 0.0)]))
    return Scene(
        tuple(bodies), tuple(links), tuple(stops), frictions, forces, base,
        t_end=2.0, every_num=1, every_den=50,
    )  # fmt: skip


def touching(draw, n, k, frame):
    """Up to three stops between different ends, most of which touch."""
    pick, taken = draw.choice, set()
    for i in range(pick([1, 1, 2, 3])):
        P = draw.randrange(n)
        Q = pick([GROUND, GROUND, frame, *(other for other in range(n) if other != P)])
        gap, sense = pick([0.0, 0.0, 0.0, 0.01]), pick([EXTENSION, COMPRESSION])
        if {P, Q} not in taken:
            taken.add(frozenset({P, Q}))
            yield pick(
                [
                    RigidStop(f"s{i}", P, Q, gap, sense, pick([0.0, 0.5, 0.8]), gap == 0),
                    Stop(f"s{i}", P, Q, gap, sense, pick([k, 3000.0]), 0.0, at_start=gap == 0),
                ]
            )
