"""Scenes whose numbers are so special that motions begin balanced, in truth or but for rounding, meet a limit
as they turn round, or come to two limits at once. Draws at random hardly ever do.
"""

import math
from dataclasses import replace
from fractions import Fraction

from tests.scenes import NO_SOURCE, falling, scene
from vibsim.physics.parts import (
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


def two_blocks(draw):
    """A scene of the paper's machine; draw: a random.Random."""
    pick = draw.choice
    m1 = pick([1.0, 0.5, 0.7])
    m2 = pick([None, m1, m1, 2 * m1, 0.3])
    k1 = pick([100.0, 64.0, 87.3, 0.0])
    k2 = pick([k1 or 50.0, 400.0, 3000.0])
    F0, A = pick([0.0, 1.0, -1.0, 2.5]), pick([0.0, 1.0, 1.0, -1.0])
    mobility = 1 / m1 + (1 / m2 if m2 else 0)
    omega = math.sqrt((k1 or k2) * mobility) * pick([1.0, 1.0, 0.5, 2.0])
    source = {"A": A, "F0": F0, "omega": omega, "cycles": omega / TURN, "cycles_lo": 0.0}
    blocks = {
        **{
            "m1": m1,
            "m2": m2,
            "k1": k1,
            "k2": k2,
            "c": pick([0.0, 0.0, 2 * math.sqrt((k1 or k2) / mobility)]),
        },
        **{"G": pick([0.0, 0.0, 0.01, abs(F0) / k1 if k1 else 0.01]), "stop_sign": pick([1, -1])},
        "N": pick([None, abs(F0) or 1.0, abs(F0) + abs(A) or 1.0, abs(A) or 1.0]) if m2 else None,
    }
    start = {
        "x1": pick([0.0, 0.01, -0.01, -blocks["G"] * blocks["stop_sign"]]),
        "v1": pick([0.0, 0.0, 0.1, -0.1]),
        "x2": None,
        "v2": None,
    }
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


def harmonic(amplitude, omega, phase):
    """amplitude sin(omega t + phase), omega a double that 2 pi times its cycles is near."""
    return Harmonic(amplitude, omega, omega / TURN, 0.0, phase)


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
