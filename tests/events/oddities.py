"""Random scenes of kinds that random numbers hardly make: forces of several harmonics that touch a limit,
belts and starts of one speed, stops that engage at one instant, light bodies, and long rests.
"""

import math

from tests.events.coincidences import harmonic
from vibsim.physics.parts import (
    AT_FORCE,
    AT_GAP,
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


def oddity(draw):
    """One to three bodies with one or more of these; draw: a random.Random."""
    pick, even = draw.choice, draw.uniform
    n, omega = pick([1, 1, 2, 2, 3]), pick([3.0, 5.0, 2.0 * math.pi])
    light = pick([1.0, 1.0, 1.0, 1e-3])
    masses = [even(0.5, 2.0) * (light if i == n - 1 else 1.0) for i in range(n)]
    speed = pick([0.0, 0.25, -0.125])
    bodies = [Body(f"b{i}", m, 0.0, pick([0.0, speed, speed])) for i, m in enumerate(masses)]
    base = (harmonic(pick([0.01, 0.02]), omega, 0.0),) if draw.random() < 0.3 else ()
    frame = BASE if base else GROUND
    k = even(20.0, 200.0)
    links = [Link("l0", 0, pick([frame, GROUND]), k, pick([0.0, 0.5]))] if draw.random() < 0.7 else []
    links += [
        Link(f"l{i}", i, i - 1, k * pick([1.0, masses[i]]), pick([0.0, 0.3 * masses[i]])) for i in range(1, n)
    ]
    size = pick([0.5, 1.0, 2.0])
    stops = list(engaging(draw, n, frame, k, masses))
    frictions = [rubbing(draw, n, size, frame, speed)] if draw.random() < 0.6 else []
    forces = [Force("F", draw.randrange(n), *touching(draw, size, omega))] if draw.random() < 0.8 else []
    t_end = pick([2.0, 2.0, 4.0, 30.0]) if not stops and light == 1.0 else pick([2.0, 4.0])
    return Scene(
        tuple(bodies), tuple(links), tuple(stops), tuple(frictions), tuple(forces), base,
        t_end=t_end, every_num=1, every_den=50 if t_end < 10 else 5,
    )  # fmt: skip


def touching(draw, size, omega):
    """(constant, harmonics) of a force [N] that touches 0 or `size` on one side, to order 2 or 4."""
    pick = draw.choice
    sign, flat = pick([1.0, -1.0]), draw.random() < 0.5
    one = size * pick([0.5, 0.25, 0.75])
    quarter = pick([math.pi / 2, 0.0])
    terms = (harmonic(-sign * one, omega, quarter),)
    constant = sign * one
    if flat:  # 3 / 2 - 2 cos(a) + cos(2 a) / 2 = 4 sin(a / 2)^4
        constant = sign * 0.75 * size
        slow = harmonic(-sign * size, omega, math.pi / 2)
        terms = slow, harmonic(sign * 0.25 * size, 2 * omega, math.pi / 2)
    return constant + pick([0.0, 0.0, size]), terms


def engaging(draw, n, frame, k, masses):
    """One to three stops, some of which are met at one place."""
    pick = draw.choice
    gap = pick([0.0, 0.01, 0.01, 0.0037])
    ends = draw.randrange(n), pick([GROUND, frame])
    sense = pick([EXTENSION, COMPRESSION])
    for i in range(pick([1, 2, 2, 3])):
        if i and draw.random() < 0.5:
            ends = draw.randrange(n), pick([GROUND, frame, *(range(ends[0]))])
        if draw.random() < 0.3:
            sense = -sense
        if ends[0] == ends[1]:
            continue
        if draw.random() < 0.4:
            yield RigidStop(f"s{i}", *ends, gap, sense, pick([0.0, 0.5, 0.8]), gap == 0.0)
        else:
            m = masses[ends[0]]
            stiff, c = k * pick([1.0, 10.0, 100.0]), pick([0.0, 0.0, 2.0]) * m
            yield Stop(f"s{i}", *ends, gap, sense, stiff, c, pick([AT_FORCE, AT_GAP]), gap == 0.0)


def rubbing(draw, n, size, frame, speed):
    """A friction whose limit is that of the force, on a belt that may have the speed of the bodies."""
    pick = draw.choice
    hold = pick([None, None, 1.5 * size])
    return Friction(
        "f", draw.randrange(n), pick([GROUND, frame]), size, size, pick([0.0, speed, speed]), hold, hold
    )
