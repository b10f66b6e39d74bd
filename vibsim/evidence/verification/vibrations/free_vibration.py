"""V2 and V3: free vibration of two blocks, without and with the stop, against the closed form.

V2: y = x1 - x2 swings with w = sqrt(k1 (1/m1 + 1/m2)), the centre of mass rests. V3: with the stop at the
rest position, half a period of each frequency in turn: 2 f1 f2 / (f1 + f2).
"""

from collections.abc import Iterator
from functools import partial
from math import pi, ulp

import numpy as np

from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.rounding import REASON, relative_rounding, roundings
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, counted_row, number_row, worst_row
from vibsim.evidence.verification.runs import BOTH, made_case, run
from vibsim.evidence.verification.vibrations.bilinear_oscillator import FREE_RATE, PERIOD, contacts, energy
from vibsim.results import Result

FREE = """
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 200 N/m}
initial: {x1: 1 mm}
run: {t_end: 5 s, every: 5 ms}
"""
BILINEAR = """
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 200 N/m}
stop: {k2: 12400 N/m, G: 0 m}
initial: {x1: 50 mm}
run: {t_end: 3 s, every: 5 ms}
"""


def checks() -> list[Check]:
    """V2 and V3 by both flows."""
    listed = [Check(f"V2/{flow}", "Free vibration of two blocks", partial(free, flow)) for flow in BOTH]
    return listed + [
        Check(f"V3/{flow}", "Free vibration with the stop", partial(bilinear, flow)) for flow in BOTH
    ]


def free(flow: str, engine: str) -> Iterator[Row]:
    """V2: frequency, displacement and energy."""
    name = f"V2/{flow}"
    result = run(made_case(FREE, "free vibration"), engine, flow)
    t, w, f = result.time, FREE_RATE, FREE_RATE / (2 * pi)
    # y vanishes at (2 k + 1) / (4 f); what is left of it there, over its slope, is how late that is
    last = (2 * int(2 * f * t[-1]) - 1) / (4 * f)
    state = result.at(last)
    late = float((state["x1"] - state["x2"]) / (state["v1"] - state["v2"]))
    bound = f * (UNIT * (SCENE_UNITS + STATE_UNITS * roundings(result) / (w * last)) + ulp(last) / last)
    yield number_row(name, compared("frequency", f, f * last / (last - late), bound, "Hz"), REASON)
    y, expected = result["x1"] - result["x2"], 1e-3 * np.cos(w * t)
    points = [
        compared(f"x1 - x2 at {t[i]:g} s", expected[i], y[i], 1e-3 * relative_rounding(result, w * t[i]), "m")
        for i in range(0, len(t), 50)
    ]
    yield worst_row(name, points, REASON)
    yield energy_row(name, result, energy(result, 0.0))


def energy_row(name: str, result: Result, values: np.ndarray) -> Row:
    """Energy is constant; it is quadratic in the state, so it is off by twice as much."""
    far = int(np.argmax(np.abs(values - values[0])))
    bound = 2 * values[0] * relative_rounding(result)
    point = compared(f"energy at {result.time[far]:g} s", values[0], values[far], bound, "J")
    return number_row(name, point, f"{REASON}; energy is quadratic")


def bilinear(flow: str, engine: str) -> Iterator[Row]:
    """V3: frequency, contacts and energy."""
    name = f"V3/{flow}"
    result = run(made_case(BILINEAR, "bilinear oscillator"), engine, flow)
    begins = result.events["t"][result.events["kind"] == 1]
    expected = contacts(result.time[-1])
    yield counted_row(name, "impacts", expected, len(begins), "one in each period")
    span, f = float(begins[-1] - begins[0]), 1 / PERIOD
    late = ulp(span) + UNIT * STATE_UNITS * roundings(result) / FREE_RATE
    bound = f * (SCENE_UNITS * UNIT + 2 * late / span)
    yield number_row(name, compared("frequency", f, (len(begins) - 1) / span, bound, "Hz"), REASON)
    yield energy_row(name, result, energy(result))
