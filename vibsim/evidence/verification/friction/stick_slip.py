"""V16 and V18: a block on a spring and a belt whose friction falls with the speed of slip.

V16, of Leine, van Campen, de Kraker, van den Steen (1998): x'' + x = -sgn(v) / (1 + 3 |v|), belt at 0.2 m/s.
V18, of bSTAB: x'' + 0.1 x' + x = -sgn(v) (0.5 + 0.5 exp(-|v| / 0.5)), v = x' - belt. Rest loses its stability
where 0.1 = exp(-belt / 0.5), at ln(10) / 2; the stick-slip cycle ends where slip just reaches the belt.
Period, stick and the end of the cycle are an independent solver's.
"""

from collections.abc import Iterator
from math import exp, log

import numpy as np

from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.settled import BECAUSE, last_digit, settled_bound
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, number_row, worst_row
from vibsim.evidence.verification.runs import made_case, run
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results import Result

# sticking takes all memory: from the first release on each cycle is the same
BLOCK = """
bodies: {block: 1 kg}
links: {spring: {between: [block, ground], k: 1 N/m}}
friction:
  belt:
    {between: [block, ground], law: stribeck hyperbolic, N: 1 N, mu_s: 1, mu_d: 0, d: 3 s/m, belt: 0.2 m/s}
initial: {block: {v: 0.2 m/s}}
run: {t_end: 60 s, every: 1 s}
"""
PERIOD, STICK, RELEASE, PLACES = 12.001031294830, 7.705031769350, 1.0, 12
# sum of |p dq/dp| over m, k, N, mu_s, d, belt by difference quotients [s]; of the release: k, N, mu_s [m]
PERIOD_CONDITIONING, STICK_CONDITIONING, RELEASE_CONDITIONING = 35.0, 39.0, 3.0
OSCILLATOR = """
bodies: {block: 1 kg}
links: {spring: {between: [block, ground], k: 1 N/m, c: 0.1 N s/m}}
friction:
  belt:
    between: [block, ground]
    law: stribeck exponential
    N: 1 N
    mu_s: 1
    mu_d: 0.5
    v0: 0.5 m/s
    belt: 1 m/s
run: {t_end: 100 s, every: 1 s}
"""
UNSTABLE = log(10) / 2
SMALL = 1e-4  # of the vibration about rest [m]
CYCLE_ENDS, CYCLE_PLACES = 1.836600972207926, 15
END_CONDITIONING = 7.5  # sum of |p d(end)/dp|, by difference quotients [m/s]
HALVINGS = 46


def checks() -> list[Check]:
    """The block on a belt, and the two ends of the belt oscillator's stick-slip."""
    return [
        Check("V16/cycle", "Stick-slip of a block on a belt", cycle),
        Check("V18/rest", "Belt oscillator: rest loses its stability", unstable_rest),
        Check("V18/cycle", "Belt oscillator: the stick-slip cycle ends", cycle_ends),
    ]


def cycle(engine: str) -> Iterator[Row]:
    """Period, stick and place of the release of four cycles."""
    result = run(made_case(BLOCK, "block on a belt"), engine)
    begins, ends = times(result, "stick_begin"), times(result, "stick_end")
    released = result.events["x_block"][result.events["kind"] == EVENT_KINDS["stick_end"]]
    steps = 1 + result.attrs["steps"] / len(ends)  # Taylor steps of a cycle
    for what, expected, computed, conditioning, unit in (
        ("period", PERIOD, np.diff(begins), PERIOD_CONDITIONING, "s"),
        ("stick", STICK, ends[1:] - begins[: len(ends) - 1], STICK_CONDITIONING, "s"),
        ("release", RELEASE, released, RELEASE_CONDITIONING, "m"),
    ):
        bound = settled_bound(conditioning, result.t_reached, steps)
        bound += last_digit(PLACES) if unit == "s" else 0.0
        points = [compared(what, expected, float(value), bound, unit) for value in computed]
        yield worst_row("V16/cycle", points, BECAUSE)


def times(result: Result, kind: str) -> np.ndarray:
    """Times of events of one kind [s]."""
    return np.asarray(result.events["t"][result.events["kind"] == EVENT_KINDS[kind]])


def mu(speed: float) -> float:
    """Friction of the belt oscillator over its load."""
    return 0.5 + 0.5 * exp(-speed / 0.5)


def unstable_rest(engine: str) -> Iterator[Row]:
    """Small vibrations about rest grow as exp(-(0.1 - exp(-2 belt)) t / 2): not at all at ln(10) / 2.

    Left out are the cube of the amplitude, mu''' / 16 SMALL^2 t < 0.03 SMALL^2 t, and the square, which
    shifts what is read here by mu'' SMALL.
    """
    points = []
    for belt in (0.9 * UNSTABLE, UNSTABLE, 1.1 * UNSTABLE):
        settings = {"friction__belt__belt": belt, "initial__block__x": mu(belt) + SMALL}
        result = run(made_case(OSCILLATOR, "belt oscillator", **settings), engine)
        rate = -(0.1 - exp(-2 * belt)) / 2
        growth_rate = (
            log(energy(result, belt, rate, -1) / energy(result, belt, rate, 0)) / 2 / result.t_reached
        )
        steps, size = result.attrs["steps"], SMALL * exp(min(0.0, rate * result.t_reached))
        left_out = 0.03 * (SMALL * exp(max(0.0, rate * result.t_reached))) ** 2
        bound = left_out + (SMALL + UNIT * (SCENE_UNITS + STATE_UNITS * steps) / size) / result.t_reached
        points.append(compared(f"growth at {belt:.4g} m/s", rate, growth_rate, bound, "1/s"))
    yield worst_row("V18/rest", points, "amplitude 1e-4 m: its square once, its cube all the time; rounding")


def energy(result: Result, belt: float, rate: float, at: int) -> float:
    """The square of the amplitude: y^2 + ((y' - rate y) / w)^2 of y'' - 2 rate y' + y = 0 [m^2]."""
    y, speed = float(result["x_block"][at]) - mu(belt), float(result["v_block"][at])
    return y * y + (speed - rate * y) ** 2 / (1 - rate * rate)


def sticks_again(belt: float, engine: str) -> tuple[bool, Result]:
    """Whether slip that begins on the belt comes back to its speed."""
    settings = {
        "friction__belt__belt": belt,
        "initial__block__v": belt,
        "initial__block__x": 0.9 - 0.1 * belt,
    }
    span = {"run__t_end": 10.0, "run__every": "10 s"}
    result = run(made_case(OSCILLATOR, "belt oscillator", **settings, **span), engine)
    return len(times(result, "stick_begin")) > 0, result


def cycle_ends(engine: str) -> Iterator[Row]:
    """The largest speed of the belt with a stick-slip cycle, by halving."""
    low, high = CYCLE_ENDS * (1 - 1e-3), CYCLE_ENDS * (1 + 1e-3)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        again, result = sticks_again(middle, engine)
        low, high = (middle, high) if again else (low, middle)
    bound = settled_bound(END_CONDITIONING, result.t_reached, 1 + result.attrs["steps"])
    bound += last_digit(CYCLE_PLACES) + 2e-3 * CYCLE_ENDS / 2.0**HALVINGS
    point = compared("speed of the belt at the end of the cycle", CYCLE_ENDS, low, bound, "m/s")
    yield number_row("V18/cycle", point, BECAUSE)
