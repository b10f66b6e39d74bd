"""V19 and V20: impacts of several bodies by the Newton-Moreau law."""

from collections.abc import Iterator

from vibsim.evidence.verification.bounds.kicks import STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.rounding import REASON, time_rounding
from vibsim.evidence.verification.bounds.settled import last_digit
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, counted_row, worst_row
from vibsim.evidence.verification.runs import made_case, run
from vibsim.physics.modes import EVENT_KINDS

BALLS = """
bodies: {a: 1 kg, b: 1 kg, c: 1 kg}
stops:
  ab: {between: [a, b], gap: 0 m, acts: compression, law: rigid, e: 1}
  bc: {between: [b, c], gap: 0 m, acts: compression, law: rigid, e: 1}
initial: {a: {x: -1 m, v: 1 m/s}}
run: {t_end: 3 s, every: 0.5 s}
"""
# displacements from 1 m and 2 m above the floor; the lower ball touches at its radius of 0.2 m
SPRING = """
bodies: {low: 1 kg, high: 1 kg}
links: {spring: {between: [low, high], k: 10 kN/m}}
forces:
  low_weight: {on: low, A: 0 N, omega: 1 Hz, F0: -9.81 N}
  high_weight: {on: high, A: 0 N, omega: 1 Hz, F0: -9.81 N}
stops: {floor: {between: [ground, low], gap: 0.8 m, acts: compression, law: rigid, e: 0.8}}
run: {t_end: 0.43 s, every: 0.01 s}
"""
BOUNCES, PLACES = (0.4038550218769, 0.4233169688147), 13
CONDITIONING = 1.6  # sum of |p dt/dp| / t over m, k, weights, gap and e, by difference quotients


def checks() -> list[Check]:
    """Three balls, and two on a spring."""
    return [
        Check("V19/three_balls", "One ball meets two that touch", three_balls),
        Check("V20/two_balls", "Two balls on a spring fall on the floor", two_balls),
    ]


def three_balls(engine: str) -> Iterator[Row]:
    """(1, 0, 0) becomes (-1/3, 2/3, 2/3), with one impact and one blow passed on."""
    name = "V19/three_balls"
    result = run(made_case(BALLS, "three balls"), engine)
    points = [
        compared(f"velocity of {ball}", v, float(result[f"v_{ball}"][-1]), STATE_UNITS * UNIT * abs(v), "m/s")
        for ball, v in (("a", -1 / 3), ("b", 2 / 3), ("c", 2 / 3))
    ]
    yield worst_row(name, points, "Newton-Moreau law; 16 units of rounding")
    kinds = [int(kind) for kind in result.events["kind"][1:-1]]
    expected = [EVENT_KINDS["impact"], EVENT_KINDS["transmitted"]]
    wrong = int(kinds != expected)
    yield counted_row(name, "events but one impact, one passed on", 0, wrong, "Newton-Moreau law")


def two_balls(engine: str) -> Iterator[Row]:
    """First and second bounce: nosnoc's example, by an independent solver."""
    result = run(made_case(SPRING, "two balls on a spring"), engine)
    hits = result.events["t"][result.events["kind"] == EVENT_KINDS["impact"]]
    points = [
        compared(
            f"bounce {n + 1}",
            t,
            float(hits[n]),
            time_rounding(result, t, CONDITIONING) + last_digit(PLACES),
            "s",
        )
        for n, t in enumerate(BOUNCES)
    ]
    yield worst_row("V20/two_balls", points, f"{REASON}, and the last digit printed")
