"""hard/spool-between-stops against 40 digits: 18 events in each period of the pressure, the same in all.

The spool sticks near the right stop in each period. So from the first release there on, every period is the
one before it, in exact numbers as well.
"""

from collections.abc import Iterator
from decimal import Decimal
from functools import partial
from math import pi, sin, ulp

from vibsim.cases import load_case
from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Point, Row, compared, counted_row, worst_row
from vibsim.evidence.verification.runs import run
from vibsim.physics.modes import EVENT_NAMES
from vibsim.results import Result

SPOOL = "hard/spool-between-stops"
METHODS = ("auto", "taylor")
SLOW = 1e-9  # a reversal without blow is met with rounding for a speed, one by a blow with 1e-4 m/s or more
PERIOD, PERIODS = Decimal("0.004"), 10  # [s]; the first of them starts otherwise
M, K, F0, A, N = 0.3361185937456267e-3, 1488.578099595049, 0.6064131049344343, 2.033654850633301, 1.0
OMEGA = 500 * pi
# the terms that the closed form adds: response to A, vibration of its own, offset, way between the stops
PLACE = 2 * A / (K - M * OMEGA**2) + F0 / K + 1.016e-3  # [m]
SPEED = 2 * OMEGA * A / (K - M * OMEGA**2) + 2.3  # likewise, and the fastest impact [m/s]
CONDITIONING = 0.027  # of the latest event: sum of |p dt/dp| over the numbers of the case [s]
# a period, from a run of 40 digits: kind, and time since the last multiple of 4 ms [s]
TRUTH = (
    ("stick_end", "1.239917297813318850519690e-4"),
    ("impact", "1.138185704841566212164555e-3"),
    ("reversal", "1.138185704841566212164555e-3"),
    ("reversal", "1.239975408375652638119714e-3"),
    ("stick_begin", "1.291179124651515739691084e-3"),
    ("stick_end", "2.044243403023824699878625e-3"),
    ("impact", "3.009198651444677335843665e-3"),
    ("reversal", "3.009198651444677335843665e-3"),
    ("reversal", "3.103895412910924765624844e-3"),
    ("impact", "3.346358923364531046297704e-3"),
    ("reversal", "3.346358923364531046297704e-3"),
    ("reversal", "3.357359996037581090840750e-3"),
    ("impact", "3.412978379597373024675994e-3"),
    ("reversal", "3.412978379597373024675994e-3"),
    ("reversal", "3.413525897175876066283987e-3"),
    ("impact", "3.422727660282692248814406e-3"),
    ("reversal", "3.422727660282692248814406e-3"),
    ("stick_begin", "3.422733384206404030483814e-3"),
)
BECAUSE = (
    "4 units x conditioning; 16 of place over speed of each impact, of speed over deceleration to a stop"
)


def checks() -> list[Check]:
    """The case by both methods."""
    return [Check(f"{SPOOL}/{how}", load_case(SPOOL).title, partial(rows, how)) for how in METHODS]


def rows(method: str, engine: str) -> Iterator[Row]:
    """Every event of nine periods, none missed and none invented, and the certificate."""
    name = f"{SPOOL}/{method}"
    result = run(load_case(SPOOL), engine, method)
    points: list[Point] = []
    wrong = 0
    for n in range(1, PERIODS):
        events = events_between(result, n * PERIOD, (n + 1) * PERIOD)
        wrong += int([kind for kind, *_ in events] != [kind for kind, _ in TRUTH])
        points += period_points(events, n * PERIOD)
    yield counted_row(name, "periods with other events", 0, wrong, "18 events in each of nine periods")
    yield worst_row(name, points, BECAUSE)
    doubts = int(result.attrs["uncertified"])
    yield counted_row(name, "stretches in doubt", 0, doubts, "no event is nearly missed")


def events_between(result: Result, low: Decimal, high: Decimal) -> list[tuple[str, float, float, float]]:
    """Kind, time [s], speed before [m/s] and place [m] of the events between two times."""
    columns = (result.events[name].tolist() for name in ("kind", "t", "before_v_spool", "x_spool"))
    named = [(EVENT_NAMES[kind], t, abs(v), x) for kind, t, v, x in zip(*columns, strict=True)]
    inner = [event for event in named if low < Decimal(event[1]) < high]
    return [event for event in inner if event[0] != "end"]


def period_points(events: list[tuple[str, float, float, float]], start: Decimal) -> Iterator[Point]:
    """Times of one period's events. An impact at the speed v comes late by an error of place over v, and
    so do all after it; the end of slip by an error of speed over the deceleration.
    """
    late = 0.0
    for (kind, expected), (_, t, speed, x) in zip(TRUTH, events, strict=False):
        late += STATE_UNITS * UNIT * PLACE / speed if kind == "impact" else 0.0
        ends = kind == "stick_begin" or (kind == "reversal" and speed < SLOW)
        stopping = STATE_UNITS * UNIT * SPEED / deceleration(t, x) if ends else 0.0
        true = start + Decimal(expected)
        bound = SCENE_UNITS * UNIT * CONDITIONING + late + stopping + 2 * ulp(t)
        yield compared(f"{kind} at {t:.6g} s", float(true), t, bound, "s", float(abs(Decimal(t) - true)))


def deceleration(t: float, x: float) -> float:
    """Of slip at its end, the smaller one of the two directions [m/s^2]."""
    force = F0 + A * sin(OMEGA * t) - K * x
    return min(abs(force - N), abs(force + N)) / M
