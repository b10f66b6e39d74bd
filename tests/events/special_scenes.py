"""Random scenes of kinds that random numbers hardly make. Each is drawn by a random.Random, `draw`."""

import math
from dataclasses import replace
from fractions import Fraction

from tests.scenes import NO_SOURCE, falling, scene
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

TURN = 2 * math.pi
QUARTERS = (0.0, 0.0, math.pi / 2, -math.pi / 2)  # phases
DYADIC = (0.25, 0.5, 1.0, 2.0)  # masses [kg]


def harmonic(amplitude, omega, phase):
    """amplitude sin(omega t + phase), omega a double that 2 pi times its cycles is near."""
    return Harmonic(amplitude, omega, omega / TURN, 0.0, phase)


# Numbers so special that motions begin balanced, in truth or but for rounding, meet a limit as they turn
# round, or come to two limits at once.


def two_blocks(draw):
    """A scene of the paper's machine."""
    pick = draw.choice
    m1 = pick([1.0, 0.5, 0.7])
    m2 = pick([None, m1, m1, 2 * m1, 0.3])
    k1 = pick([100.0, 64.0, 87.3, 0.0])
    k2 = pick([k1 or 50.0, 400.0, 3000.0])
    F0, A = pick([0.0, 1.0, -1.0, 2.5]), pick([0.0, 1.0, 1.0, -1.0])
    mobility = 1 / m1 + (1 / m2 if m2 else 0)
    omega = math.sqrt((k1 or k2) * mobility) * pick([1.0, 1.0, 0.5, 2.0])
    source = {"A": A, "F0": F0, "omega": omega, "cycles": omega / TURN, "cycles_lo": 0.0}
    damping = pick([0.0, 0.0, 2 * math.sqrt((k1 or k2) / mobility)])
    gap, sense = pick([0.0, 0.0, 0.01, abs(F0) / k1 if k1 else 0.01]), pick([1, -1])
    limit = pick([None, abs(F0) or 1.0, abs(F0) + abs(A) or 1.0, abs(A) or 1.0]) if m2 else None
    blocks = {"m1": m1, "m2": m2, "k1": k1, "k2": k2, "c": damping, "G": gap, "stop_sign": sense, "N": limit}
    start = {"x1": pick([0.0, 0.01, -0.01, -gap * sense]), "v1": pick([0.0, 0.0, 0.1, -0.1])}
    start |= {"x2": None, "v2": None}
    if m2:
        start |= {"x2": pick([0.0, 0.0, 0.01]), "v2": pick([0.0, 0.0, 0.1, -0.1])}
    run = {"t_end": 20 / max(omega, 1), "every_num": 1, "every_den": 50}
    method = pick(["closed_form", "taylor"])
    return scene({**NO_SOURCE, "source": "harmonic", **source}, **blocks, **start, **run, method=method)


def machine(draw):
    """One or two bodies on ground or base, with an elastic or a rigid stop, a friction and a force."""
    pick = draw.choice
    m = pick([1.0, 0.5, 0.7])
    k, x = pick([100.0, 64.0, 87.3, 0.0]), pick([0.0, 0.0, 0.01, -0.01])
    bodies = [Body("a", m, x, pick([0.0, 0.0, 0.11, -0.11]))]
    if pick([True, False]):
        bodies.append(Body("b", pick([m, 2 * m, 0.3]), pick([0.0, 0.01]), pick([0.0, 0.0, 0.11])))
    last = len(bodies) - 1
    omega = math.sqrt((k or 64.0) / m) * pick([1.0, 0.5, 2.0])
    shaken = pick([0.0, 0.01, 0.01, abs(x) or 0.02])
    base = (harmonic(shaken, omega, pick(QUARTERS)),) if shaken else ()
    frame = BASE if base else GROUND
    F0, A = pick([0.0, k * x, -k * x, 1.0, -1.0]), pick([0.0, 0.0, 1.0, k * shaken])
    links = [Link("spring", 0, pick([frame, GROUND]), k, 0.0)] if k else []
    if last:
        links.append(Link("tie", last, 0, pick([k or 50.0, 87.3]), 0.0))
    gap = pick([0.0, 0.0, abs(x), 0.01])
    ends = (last, pick([frame, GROUND]) if last == 0 or pick([True, False]) else 0)
    sense = pick([EXTENSION, COMPRESSION])
    meets = exactly_met(bodies, base, ends, gap, sense)
    if meets and base:  # at other phases more digits leave less of a quarter turn, but never nothing
        base = (harmonic(shaken, omega, 0.0),)
        meets = exactly_met(bodies, base, ends, gap, sense)
    if pick([True, False]):
        stop = Stop("stop", *ends, gap, sense, pick([k or 50.0, 3000.0]), 0.0, at_start=meets)
    else:
        if depth_at_start(bodies, base, ends, gap, sense) > 0:  # no case starts inside a rigid stop
            sense = -sense
            meets = exactly_met(bodies, base, ends, gap, sense)
        stop = RigidStop("stop", *ends, gap, sense, pick([1.0, 0.0]), meets)
    limit = pick([abs(F0) or 1.0, abs(A) or 1.0, m * shaken * omega**2 or 1.0])
    belt = pick([0.0, 0.0, 0.1])
    frictions = (Friction("f", last, pick([frame, GROUND]), limit, limit, belt),) if pick([1, 0, 0]) else ()
    if frictions and isinstance(stop, RigidStop):  # no infinite sequences, which end where rounding says
        stop = replace(stop, e=0.0)
    forces = (Force("drive", 0, F0, (harmonic(A, omega, pick([0.0, 0.0, 1.0, -1.0])),)),)
    return Scene(
        tuple(bodies), tuple(links), (stop,), frictions, forces, base,
        t_end=20 / max(omega, 1.0), every_num=1, every_den=50, method=pick(["auto", "taylor"]),
    )  # fmt: skip


def driven(draw):
    """A machine with a motor, and with a friction whose force falls with speed or holds more than that."""
    pick = draw.choice
    scene = machine(draw)
    m3, e, speed = pick([0.5, 0.2]), pick([0.01, 0.05]), pick([8.0, 16.0])
    inertia = m3 * e * e * pick([1.0, 2.0])
    begins = pick([0.0, 0.0, speed, -speed, 0.5 * speed])  # the torque is M0 at 0, none at the full speed
    on = pick(range(len(scene.bodies)))
    motor = Motor(on, m3, e, inertia, inertia * pick([0.0, 10.0, 100.0]), speed, pick(QUARTERS), begins)
    frictions = tuple(static(pick, one, m3 * e * begins**2) for one in scene.frictions)
    return replace(scene, motor=motor, frictions=frictions, method="auto")


def static(pick, friction, centrifugal):
    """`friction` with limits that the force of the unbalance may reach, laws that fall, or both."""
    slipping = pick([friction.forward, centrifugal or friction.forward])
    law = pick([None, None, HYPERBOLIC, EXPONENTIAL])
    holding = pick([None, 1.5 * slipping, 2.0 * slipping])
    one = replace(friction, forward=slipping, backward=slipping)
    if law:  # slip begins with half as much again then
        one = falling(one, (law, 0.5 * slipping, 10.0))
        holding = holding if holding == 2.0 * slipping else None
    return replace(one, hold_forward=holding, hold_backward=holding)


def exactly_met(bodies, base, ends, gap, sense):
    """Whether the ends of a stop just touch, the base at a quarter turn or none."""
    return depth_at_start(bodies, base, ends, gap, sense) == 0


def depth_at_start(bodies, base, ends, gap, sense):
    """Depth of a stop [m], exactly; the base at a quarter turn or none."""
    places = [body.x for body in bodies] + [
        sum(one.amplitude * round(math.sin(one.phase)) for one in base),
        0.0,
    ]
    P, Q = (Fraction(places[end]) for end in ends)  # BASE is -2, GROUND -1
    return sense * (Q - P) - Fraction(gap)


# Forces of several harmonics that touch a limit, belts and starts of one speed, stops that engage at one
# instant, light bodies, and long rests.


def oddity(draw):
    """One to three bodies with one or more of these."""
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
    forces = [Force("F", draw.randrange(n), *touching_at(draw, size, omega))] if draw.random() < 0.8 else []
    t_end = pick([2.0, 2.0, 4.0, 30.0]) if not stops and light == 1.0 else pick([2.0, 4.0])
    return Scene(
        tuple(bodies), tuple(links), tuple(stops), tuple(frictions), tuple(forces), base,
        t_end=t_end, every_num=1, every_den=50 if t_end < 10 else 5,
    )  # fmt: skip


def touching_at(draw, size, omega):
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


# Chains of bodies at rest: driven somewhere, some of their ends touch stops from the start on.


def chain(draw):
    """Two to five bodies in a row, mostly linked, with up to three stops, a friction, a shaken base, forces,
    and one that flies at them.
    """
    pick, often = draw.choice, draw.random
    n, k, omega = pick([2, 3, 3, 4, 4, 5]), pick([87.3, 100.0, 64.0]), pick([5.0, 7.0, 9.344])
    frame = pick([GROUND, BASE])
    bodies = [Body(f"b{i}", pick([1.0, 1.0, 1.0, 1.0, 0.5, 0.7]), 0.0, 0.0) for i in range(n)]
    places = [(i, i - 1 if i else pick([frame, frame, GROUND])) for i in range(n) if often() > 0.15]
    links = [Link(f"l{P}", P, Q, k, pick([0.0] * 4 + [0.02 * k])) for P, Q in places]
    stops = list(touching_stops(draw, n, k, frame))
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


def touching_stops(draw, n, k, frame):
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


# Rigid impacts: of a body that carries a motor, and of several bodies at one instant.


def with_motor(draw):
    """One to three bodies, one of which carries a motor, among rigid stops."""
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
    as mirror images, from both; with walls, frictions, springs, and a motor now and then.
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
