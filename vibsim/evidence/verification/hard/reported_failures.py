"""Hard cases that others report as failures, with truths in closed form; docs/what-others-do.md names them.

A ball that rests after infinitely many bounces, a mass pressed on a stop, a body held by friction against its
weight, and a contact within one smooth flight.
"""

from collections.abc import Iterator
from functools import partial
from math import atan, sqrt, ulp

import numpy as np

from vibsim.cases import load_case
from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.rounding import REASON, time_rounding
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.impacts.bouncing_ball import rest_bound
from vibsim.evidence.verification.row import Point, Row, compared, counted_row, number_row, worst_row
from vibsim.evidence.verification.runs import named_case, run
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results import Result

ZENO, PRESSED = "hard/zeno-ball", "hard/pressed-on-a-stop"
HELD, TOUCH = "hard/held-by-friction", "hard/touch-within-a-step"
METHODS = ("auto", "taylor")


def checks() -> list[Check]:
    """The four cases by both methods."""
    makers = ((ZENO, zeno), (PRESSED, pressed), (HELD, held), (TOUCH, touch))
    return [
        Check(f"{name}/{how}", load_case(name).title, partial(rows, how))
        for name, rows in makers
        for how in METHODS
    ]


def times(result: Result, kind: str) -> np.ndarray:
    """Times of the events of a kind [s]."""
    return np.asarray(result.events["t"][result.events["kind"] == EVENT_KINDS[kind]])


def stays(result: Result, column: str, since: float, place: float) -> Point:
    """How far the body is from `place` [m] after `since` [s]: not one bit."""
    values = result[column][result.time > since]
    far = float(values[np.argmax(np.abs(values - place))])
    return compared("place after that", place, far, 0.0, "m")


def zeno(method: str, engine: str) -> Iterator[Row]:
    """Rest after sqrt(2 h / g) (1 + e) / (1 - e), never below the floor, and on it for ever."""
    name, end = f"{ZENO}/{method}", sqrt(2 / 9.81) * 1.7 / 0.3
    result = run(load_case(ZENO), engine, method)
    rested = times(result, "rest_begin")
    yield counted_row(name, "times that it comes to rest", 1, len(rested), "once, and for ever")
    fall, first = sqrt(2 / 9.81), float(times(result, "impact")[0])
    bound = UNIT * (SCENE_UNITS + STATE_UNITS) * fall + ulp(fall)
    yield number_row(name, compared("first impact", fall, first, bound, "s"), REASON)
    point = compared("rest", end, float(rested[0]), rest_bound(result, end, 0.7), "s")
    yield number_row(name, point, "grid of t and 16 units of speed per impact, and what was cut off")
    yield number_row(name, stays(result, "x_ball", end, 0.0), "it stays on the floor, to the last bit")
    lowest = float(result["x_ball"].min())
    below = compared("depth below the floor", 0.0, max(0.0, -lowest), STATE_UNITS * UNIT, "m")
    yield number_row(name, below, "16 units of the height of 1 m")


def pressed(method: str, engine: str) -> Iterator[Row]:
    """With (5 - 1) N on 1 kg it is at the stop after sqrt(2 / 4) s, where nothing more happens."""
    name, end = f"{PRESSED}/{method}", sqrt(0.5)
    result = run(load_case(PRESSED), engine, method)
    impact = float(times(result, "impact")[0])
    yield number_row(name, compared("impact", end, impact, time_rounding(result, end, 2), "s"), REASON)
    kinds = sorted(result.events["kind"][1:-1].tolist())
    expected = sorted(EVENT_KINDS[kind] for kind in ("impact", "rest_begin", "stick_begin"))
    wrong = int(kinds != expected)
    yield counted_row(name, "events but one impact, rest and stick", 0, wrong, "it is pressed on and stays")
    yield number_row(name, stays(result, "x_mass", end, 1.0), "it stays, to the last bit")


def held(method: str, engine: str) -> Iterator[Row]:
    """Slip stops after v m / (2 mu N - W), on half of v times that; then it hangs."""
    name, load = f"{HELD}/{method}", 2 * 0.7 * 12 - 0.44145
    end = 0.1 * 0.045 / load
    result = run(load_case(HELD), engine, method)
    stuck = float(times(result, "stick_begin")[0])
    yield number_row(name, compared("stick", end, stuck, time_rounding(result, end, 4, 1 / end), "s"), REASON)
    way, last = -0.1 * end / 2, float(result["x_capsule"][-1])
    bound = abs(way) * UNIT * (SCENE_UNITS * 5 + STATE_UNITS * 3)
    yield number_row(name, compared("place after 1000 s", way, last, bound, "m"), REASON)
    moved = float(np.ptp(result["x_capsule"][result.time > end]))
    yield number_row(name, compared("creep in 1000 s", 0.0, moved, 0.0, "m"), "it stays, to the last bit")
    slips = len(times(result, "stick_end"))
    yield counted_row(name, "slips after that", 0, slips, "the limit is 38 times the weight")


def touch(method: str, engine: str) -> Iterator[Row]:
    """Contacts by which the flight, 5 m high, goes too far by 10^-2 to 10^-12 m; begin and end of each."""
    name, missed = f"{TOUCH}/{method}", 0
    points: list[Point] = []
    for k in range(2, 13):
        result = run(named_case(TOUCH, stops__spring__gap=5 - 10.0**-k), engine, method)
        begins, ends = times(result, "contact_begin"), times(result, "contact_end")
        missed += int((len(begins), len(ends)) != (1, 1))
        points += touch_points(result, k, begins[:1], ends[:1])
    yield counted_row(name, "contacts missed or invented", 0, missed, "11 flights with one contact each")
    yield worst_row(name, points, "rounding of a height of 5 m over the speed at contact")


def touch_points(result: Result, k: int, begins: np.ndarray, ends: np.ndarray) -> Iterator[Point]:
    """The ball meets the spring at w = sqrt(2 g d), and is back after 2 / q atan(q w / g), q^2 = k / m.

    d is 5 m less the gap, as doubles have it, exactly.
    """
    depth, q = 5 - (5 - 10.0**-k), sqrt(1000.0)
    w = sqrt(2 * 10 * depth)
    begin = (10 - w) / 10
    end = begin + 2 / q * atan(q * w / 10)
    steps = result.attrs["steps"] if method_steps(result) else 0
    late = 5 * UNIT * (SCENE_UNITS * 3 + STATE_UNITS * (1 + steps)) / w + ulp(1.0)
    for what, expected, computed in (("begin", begin, begins), ("end", end, ends)):
        for t in computed:
            yield compared(f"{what} of contact 1e-{k} m deep", expected, float(t), 2 * late, "s")


def method_steps(result: Result) -> bool:
    """Whether the run took Taylor steps, which round as well."""
    return bool(result.attrs["method"] != "closed_form")
