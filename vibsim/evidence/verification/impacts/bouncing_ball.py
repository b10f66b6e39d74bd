"""V15: a ball on a floor, and on a table s = a sin(w t), restitution e, g = 9.81 m/s^2: closed forms.

Dropped from h it rests after sqrt(2 h / g) (1 + e) / (1 - e). On the table it bounces once a period,
w T = 2 pi, with (g T / 2) (1 - e) / (1 + e) = a w cos(w t) at the impact; these motions are born at
a w^2 / g = pi (1 - e) / (1 + e) and double their period at
a w^2 / g = sqrt((pi (1 - e) / (1 + e))^2 + (2 (1 + e^2) / (1 + e)^2)^2), which Holmes (1982) gives for a
table that hardly moves; with e = 0.8 at 1.070836468247907.
"""

from collections.abc import Iterator
from math import acos, hypot, pi, sin, sqrt, ulp

import numpy as np

from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.settled import BECAUSE, settled_bound
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Point, Row, compared, counted_row, worst_row
from vibsim.evidence.verification.runs import made_case, run
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results import Result

GRAVITY = 9.81
DROPPED = """
bodies: {ball: 1 kg}
forces: {weight: {on: ball, A: 0 N, omega: 1 Hz, F0: -9.81 N}}
stops: {floor: {between: [ground, ball], gap: 0 m, acts: compression, law: rigid, e: 0.8}}
initial: {ball: {x: 1 m}}
run: {t_end: 5 s, every: 0.1 s}
"""
TABLE = """
bodies: {ball: 1 kg}
forces: {weight: {on: ball, A: 0 N, omega: 1 Hz, F0: -9.81 N}}
stops: {table: {between: [base, ball], gap: 0 m, acts: compression, law: rigid, e: 0.8}}
base: {a: 1 mm, omega: 10 Hz}
run: {t_end: 20 s, every: 1 s}
"""
E, OMEGA = 0.8, 20 * pi
PERIOD = 2 * pi / OMEGA
BORN = pi * (1 - E) / (1 + E)  # a w^2 / g
DOUBLED = hypot(BORN, 2 * (1 + E * E) / (1 + E) ** 2)
BOUNCES = 60


def checks() -> list[Check]:
    """The ball that comes to rest, and the one that bounces once a period."""
    return [
        Check("V15/rest", "A dropped ball comes to rest", rest),
        Check("V15/bounces", "A ball bounces once a period of the table", bounces),
        Check("V15/doubling", "Where bounces of one period become those of two", doubling),
    ]


def rest(engine: str) -> Iterator[Row]:
    """Time of rest, speeds of the impacts on the way, and rest itself."""
    ends, speeds, moves = [], [], []
    for e in (0.2, 0.5, 0.8):
        end = sqrt(2 / GRAVITY) * (1 + e) / (1 - e)
        result = run(made_case(DROPPED, "dropped ball", stops__floor__e=e), engine)
        rested = result.events["t"][result.events["kind"] == EVENT_KINDS["rest_begin"]]
        bound = rest_bound(result, end, e)
        ends.append(compared(f"rest with e = {e:g}", end, float(rested[0]), bound, "s"))
        speeds += speed_points(result, e, end)
        after = result["x_ball"][result.time > rested[0]]
        moves.append(compared(f"height after rest with e = {e:g}", 0.0, float(np.abs(after).max()), 0.0, "m"))
    because = (
        "half a unit of t per impact and 1 / (1 - e) of it by the speed, 16 units of speed, what was cut off"
    )
    yield worst_row("V15/rest", ends, because)
    yield worst_row("V15/rest", speeds, "16 units and g half a unit of t per impact")
    yield worst_row("V15/rest", moves, "it stays: its height does not change in one bit")


def rest_bound(result: Result, end: float, e: float) -> float:
    """An impact late by half a unit of t strikes g times that faster, and all flights behind it with it."""
    grid = ulp(end) * (0.5 + 1 / (1 - e)) * result.attrs["impacts"]
    rounding = SCENE_UNITS * (1 + 2 / (1 - e * e)) + STATE_UNITS / (1 - e)
    return float(grid + end * UNIT * rounding + result.attrs["chatter_time"])


def speed_points(result: Result, e: float, end: float) -> list[Point]:
    """Impact n = 0, 1, ... at e^n sqrt(2 g h)."""
    hits = result.events["before_v_ball"][result.events["kind"] == EVENT_KINDS["impact"]]
    first, late = sqrt(2 * GRAVITY), GRAVITY * ulp(end) / 2
    return [
        compared(
            f"speed of impact {n + 1} with e = {e:g}",
            first * e**n,
            -float(v),
            (n + 1) * first * e**n * UNIT * (SCENE_UNITS + STATE_UNITS) + late / (1 - e),
            "m/s",
        )
        for n, v in enumerate(hits)
    ]


def start_on_orbit(strength: float, push: float = 0.0) -> dict[str, object]:
    """A run that starts behind an impact of the motion of one bounce a period, a w^2 / g = `strength`.

    push : relative change of the velocity at the start
    """
    a, phase = strength * GRAVITY / OMEGA**2, acos(BORN / strength)
    return {
        "base__a": a,
        "base__phase": phase,
        "initial__ball__x": a * sin(phase),
        "initial__ball__v": GRAVITY * PERIOD / 2 * (1 + push),
        "run__t_end": (BOUNCES + 0.5) * PERIOD,
        "run__every": "0.1 s",
    }


def intervals(result: Result) -> np.ndarray:
    """Times between impacts [s]."""
    return np.diff(result.events["t"][result.events["kind"] == EVENT_KINDS["impact"]])


def bounces(engine: str) -> Iterator[Row]:
    """Between birth and doubling the ball meets the table with g T / 2 in each period."""
    points, counts = [], 0
    for strength in (0.5, 0.8, 1.0):
        result = run(made_case(TABLE, "ball on a table", **start_on_orbit(strength)), engine)
        hits = result.events["before_v_ball"][result.events["kind"] == EVENT_KINDS["impact"]]
        counts += len(hits)
        speed, bound = GRAVITY * PERIOD / 2, orbit_bound(strength, result)
        points += [
            compared(f"speed at a w^2 / g = {strength:g}", -speed, float(v), bound, "m/s") for v in hits
        ]
    yield worst_row("V15/bounces", points, BECAUSE)
    yield counted_row("V15/bounces", "bounces in 3 x 60 periods", 3 * BOUNCES, counts, "one in each period")


def orbit_bound(strength: float, result: Result) -> float:
    """Bound of the speed; the orbit depends on the phase, cos = BORN / strength, by 1 / sin of it.

    A change of the scene moves the speed by as much times the numbers g, a, w, e, of which e counts
    2 e / (1 - e^2), and the phase by cot; what is moved is forgotten like e^n: det of the multipliers is e^2.
    """
    steep = 1 / sin(acos(BORN / strength))
    conditioning = GRAVITY * PERIOD / 2 * (4 + 2 * E / (1 - E * E)) * steep / (1 - E)
    return settled_bound(conditioning, result.t_reached, 1, OMEGA)


def doubling(engine: str) -> Iterator[Row]:
    """A small push dies out below the doubling, and grows above it as jumps to and fro."""
    wrong = 0
    for part in (0.03, 0.01):
        for sign in (-1, 1):
            settings = start_on_orbit(DOUBLED * (1 + sign * part), push=1e-4)
            settings["run__t_end"] = 200.5 * PERIOD
            apart = intervals(run(made_case(TABLE, "ball on a table", **settings), engine)) - PERIOD
            first, last = np.abs(apart[20:30]).max(), np.abs(apart[-10:]).max()
            wrong += int((last > first) != (sign > 0))
            wrong += int(sign > 0 and not np.all(apart[-10:-1] * apart[-9:] < 0))
    because = f"a w^2 / g 1 % and 3 % below and above {DOUBLED:.15g}: closed form"
    yield counted_row("V15/doubling", "runs that go the wrong way", 0, wrong, because)
