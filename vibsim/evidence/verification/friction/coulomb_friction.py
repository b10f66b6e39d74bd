"""V6 and V7: Coulomb friction alone, with exact stops."""

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from math import atan2, pi, sqrt

import numpy as np

from vibsim.evidence.verification.bounds.rounding import REASON, relative_rounding, time_rounding
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, counted_row, number_row, worst_row
from vibsim.evidence.verification.runs import BOTH, made_case, run

MU_G = 0.001 * 9.81  # [m/s^2]
SLIDING = """
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 0 N/m}
friction: {mu: 0.001}
run: {t_end: 100 s, every: 0.5 s}
"""
# x'' + x + sgn(x') = 0 for block 2, block 1 practically a wall
SCALED = """
blocks: {m1: 1e12 kg, m2: 1 kg}
coupling: {k1: 1 N/m}
friction: {mu: 0.1, g: 10 m/s^2}
initial: {x2: 12 m, v2: 6 m/s}
run: {t_end: 40 s, every: 0.1 s}
"""
DECAYING = """
blocks: {m1: 1e12 kg, m2: 2.94 kg}
coupling: {k1: 200 N/m}
friction: {mu: 0.02}
initial: {x2: 50 mm}
run: {t_end: 8 s, every: 10 ms}
"""


def checks() -> list[Check]:
    """V6 and V7 by both flows."""
    listed = [Check(f"V6/{flow}", "A block that slides and stops", partial(sliding, flow)) for flow in BOTH]
    listed += [Check(f"V7/{flow}", "Spring and Coulomb friction", partial(swinging, flow)) for flow in BOTH]
    return listed


def sliding(flow: str, engine: str) -> Iterator[Row]:
    """V6: block 2 alone stops after v0 / (mu g) and v0^2 / (2 mu g), and stays."""
    name = f"V6/{flow}"
    times, ways, moves = [], [], []
    for v0 in (0.02, -0.02, 0.7):
        result = run(made_case(SLIDING, "sliding block", initial__v2=v0), engine, flow)
        stop, way = abs(v0) / MU_G, v0 * abs(v0) / (2 * MU_G)
        t = float(result.events["t"][1])
        after = result.time > stop
        times.append(
            compared(f"stop from {v0} m/s", stop, t, time_rounding(result, stop, 3, MU_G / abs(v0)), "s")
        )
        end = float(result["x2"][-1])
        ways.append(compared(f"way from {v0} m/s", way, end, abs(way) * relative_rounding(result, 4), "m"))
        moves.append(compared(f"motion after {v0} m/s", 0.0, float(np.ptp(result["x2"][after])), 0.0, "m"))
    yield worst_row(name, times, REASON)
    yield worst_row(name, ways, REASON)
    yield worst_row(name, moves, "it stays: x2 does not change in one bit")


def swinging(flow: str, engine: str) -> Iterator[Row]:
    """V7: circles about -1 (x' > 0) and +1, and amplitudes that fall by 4 mu m2 g / k1 per cycle."""
    name = f"V7/{flow}"
    result = run(made_case(SCALED, "scaled friction oscillator"), engine, flow)
    radius, expected = sqrt(205), atan2(6, 13) + pi * np.arange(8)
    t = result.events["t"][1:-1]
    yield counted_row(name, "events", 8, len(t), "seven reversals and the stop")
    # block 1, of 1e12 kg under 14 N at most, gives way; the last half circle has the radius 15 - sqrt(205)
    way = 14 * expected[-1] ** 2 / (2 * 1e12)
    because = "block 1 gives way by 14 N t^2 / (2 m1); rounding is far below"
    rest = 15 - radius
    points = [
        compared(f"turn {n + 1}", when, float(t[n]), way / rest + time_rounding(result, when), "s")
        for n, when in enumerate(expected[: len(t)])
    ]
    yield worst_row(name, points, because)
    end, size = float(result["x2"][-1]), 15 * relative_rounding(result)
    yield number_row(name, compared("stop", rest, end, way + size, "m"), because)
    after = result["x2"][result.time > t[-1]]
    yield number_row(name, compared("motion after the stop", 0.0, float(np.ptp(after)), 0.0, "m"), "it stays")
    yield amplitude_row(name, flow, engine)


def amplitude_row(name: str, flow: str, engine: str) -> Row:
    """Fall of the maxima per cycle."""
    result = run(made_case(DECAYING, "decaying vibration"), engine, flow)
    tops = result.events["x2"][1:-1][1::2][:-1]  # every second turn is a maximum; the last event is the stop
    fall = 4 * 0.02 * 2.94 * 9.81 / 200
    way = 10 * 8**2 / (2 * 1e12)  # block 1 gives way under 10 N at most in 8 s
    bound = 2 * (0.05 * relative_rounding(result, 4) + way)
    points = [
        compared(f"fall of the amplitude in cycle {n + 2}", fall, float(before - here), bound, "m")
        for n, (before, here) in enumerate(pairwise(tops))
    ]
    return worst_row(name, points, "4 mu m2 g / k1; block 1 gives way, rounding of two maxima")
