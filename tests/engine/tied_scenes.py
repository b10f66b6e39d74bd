"""Random scenes of bodies that are alike or mirror each other, so that many events fall into one instant."""

import math
import random

from vibsim.physics.parts import (
    AT_FORCE,
    AT_GAP,
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    RigidStop,
    Scene,
    Stop,
)


def tied_scene(seed):
    draw = random.Random(seed)
    pick = draw.choice
    n, w = pick([2, 2, 3, 4]), pick([1.0, 2.0, 3.0])
    x, v = pick([0.0, 0.01, 0.02, -0.01]), pick([0.0, 0.1, -0.1, 0.05])
    signs = [(-1) ** i for i in range(n)] if draw.random() < 0.5 else [1] * n
    m = [1.0] * n if draw.random() < 0.7 else [pick([1.0, 2.0]) for _ in range(n)]
    bodies = [Body(f"b{i}", m[i], signs[i] * x, signs[i] * v) for i in range(n)]
    links = [Link(f"l{i}", i, GROUND, m[i] * w * w, pick([0.0, 0.0, 0.1]) * m[0]) for i in range(n)]
    if draw.random() < 0.4:
        links += [Link(f"c{i}", i, i + 1, pick([1.0, 5.0]), 0.0) for i in range(n - 1)]
    stops = list(_stops(draw, n, w, signs, x))
    frictions = []
    if draw.random() < 0.6:
        slip = pick([0.005, 0.02, 0.1])
        hold = pick([slip, slip, 1.5 * slip])
        frictions = [Friction(f"f{i}", i, GROUND, slip, hold, pick([0.0, 0.0, 0.05])) for i in range(n)]
        if draw.random() < 0.3:
            frictions.append(Friction("fx", 0, 1, slip, hold, 0.0))
    forces = []
    if draw.random() < 0.6:
        omega, A, phase = pick([1.0, 2.0, 3.0, 5.0]), pick([0.05, 0.2]), pick([0.0, math.pi / 2])
        terms = [Harmonic(signs[i] * A * m[i], omega, omega / (2 * math.pi), 0.0, phase) for i in range(n)]
        forces = [Force(f"F{i}", i, 0.0, (term,)) for i, term in enumerate(terms)]
    clearances = []
    if draw.random() < 0.3:
        clearances = [Clearance(f"k{i}", i, GROUND, pick([0.01, 0.005, 0.02])) for i in range(n)]
    return Scene(
        tuple(bodies), tuple(links), tuple(stops), tuple(frictions), tuple(forces),
        clearances=tuple(clearances), t_end=pick([4.0, 8.0]), every_num=1, every_den=20,
        method=pick(["auto", "auto", "taylor"]),
    )  # fmt: skip


def _stops(draw, n, w, signs, x):
    """One stop of each body against the ground, perhaps some between neighbours, most of them alike. A rigid
    one that the bodies would start beyond, which no case may say, acts on the other side.
    """
    pick = draw.choice
    gap, rigid = pick([0.0, 0.01, 0.005, 0.02]), draw.random() < 0.5
    e, k, c, release = (
        pick([0.0, 0.5, 0.8]),
        pick([10, 100]) * w * w,
        pick([0.0, 1.0]),
        pick([AT_FORCE, AT_GAP]),
    )
    at_start = gap == 0.0 and x == 0.0

    def stop(name, P, Q, gap, sense, rigid):
        if rigid:
            beyond = -sense * (signs[P] - (signs[Q] if Q != GROUND else 0)) * x > gap
            return RigidStop(name, P, Q, gap, -sense if beyond else sense, e, at_start)
        return Stop(name, P, Q, gap, sense, k, c, release, at_start)

    for i in range(n):
        sense = EXTENSION if signs[i] > 0 else COMPRESSION
        sense = sense if draw.random() < 0.8 else -sense
        yield stop(f"s{i}", i, GROUND, gap, sense, rigid if draw.random() < 0.8 else not rigid)
    if draw.random() < 0.5:
        for i in range(n - 1):
            sense, hard = pick([EXTENSION, COMPRESSION]), draw.random() < 0.5
            yield stop(f"s{n + i}", i, i + 1, pick([gap, 2 * gap]), sense, hard)
