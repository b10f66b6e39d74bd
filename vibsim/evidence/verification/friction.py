"""Known cases of friction: Coulomb's alone, and sticking and slipping on a belt (V6, V7, V16 to V18)."""

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from math import atan2, exp, log, pi, sqrt

import numpy as np

from vibsim.evidence.verification.checks import (
    BECAUSE,
    BOTH,
    REASON,
    SCENE_UNITS,
    STATE_UNITS,
    UNIT,
    Check,
    CheckRow,
    compared,
    counted_row,
    last_digit,
    made_case,
    number_row,
    relative_rounding,
    run,
    settled_bound,
    time_rounding,
    worst_row,
)
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results import Result

# V6 and V7: Coulomb friction alone, with exact stops.


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


def coulomb_friction_checks() -> list[Check]:
    """V6 and V7 by both flows."""
    listed = [Check(f"V6/{flow}", "A block that slides and stops", partial(sliding, flow)) for flow in BOTH]
    listed += [Check(f"V7/{flow}", "Spring and Coulomb friction", partial(swinging, flow)) for flow in BOTH]
    return listed


def sliding(flow: str, engine: str) -> Iterator[CheckRow]:
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


def swinging(flow: str, engine: str) -> Iterator[CheckRow]:
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


def amplitude_row(name: str, flow: str, engine: str) -> CheckRow:
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


# V17: x'' + 0.1 x' + x = 1.5 cos(0.9 t) - friction, 1 N while slipping and 1.1 N while sticking.
#
# Parameters of the friction demo of PWSDDE-cont: a symmetric orbit without sticking, whose amplitude is an
# independent solver's; Den Hartog (1931) has it in closed form.


# the damper alone takes a factor e in 20 s: the start has fallen to 6e-16 of itself by 700 s
CASE = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 1 N/m, c: 0.1 N s/m}}
friction: {floor: {between: [mass, ground], N: 1 N, mu: 1, static: 1.1}}
forces: {drive: {on: mass, A: 1.5 N, omega: 0.9 rad/s, phase: 90 deg}}
initial: {mass: {v: 5 m/s}}
run: {t_end: 800 s, every: 100 s}
"""
AMPLITUDE, FRICTION_OSCILLATOR_PLACES = 2.42023635057437, 14
CONDITIONING = 27.0  # sum of |p dX/dp| over m, k, c, N, A, omega by difference quotients [m]
TURNS = 10


def friction_oscillator_checks() -> list[Check]:
    """One check."""
    return [Check("V17/amplitude", "Friction oscillator: symmetric orbit without sticking", amplitude)]


def amplitude(engine: str) -> Iterator[CheckRow]:
    """Places of the last turns, and no stick."""
    name = "V17/amplitude"
    result = run(made_case(CASE, "friction oscillator"), engine)
    turning = result.events["kind"] == EVENT_KINDS["reversal"]
    places = result.events["x_mass"][turning][-TURNS:]
    bound = settled_bound(CONDITIONING, result.t_reached, 2)
    points = [
        compared("amplitude", AMPLITUDE, abs(float(x)), bound + last_digit(FRICTION_OSCILLATOR_PLACES), "m")
        for x in places
    ]
    yield worst_row(name, points, BECAUSE)
    sticks = int(np.sum(result.events["kind"] == EVENT_KINDS["stick_begin"]))
    yield counted_row(name, "sticks", 0, sticks, "the mass turns at once")


# V16 and V18: a block on a spring and a belt whose friction falls with the speed of slip.
#
# V16, of Leine, van Campen, de Kraker, van den Steen (1998): x'' + x = -sgn(v) / (1 + 3 |v|), belt at 0.2
# m/s. V18, of bSTAB: x'' + 0.1 x' + x = -sgn(v) (0.5 + 0.5 exp(-|v| / 0.5)), v = x' - belt. Rest loses its
# stability where 0.1 = exp(-belt / 0.5), at ln(10) / 2; the stick-slip cycle ends where slip just reaches the
# belt. Period, stick and the end of the cycle are an independent solver's.


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
PERIOD, STICK, RELEASE, STICK_SLIP_PLACES = 12.001031294830, 7.705031769350, 1.0, 12
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


def stick_slip_checks() -> list[Check]:
    """The block on a belt, and the two ends of the belt oscillator's stick-slip."""
    return [
        Check("V16/cycle", "Stick-slip of a block on a belt", cycle),
        Check("V18/rest", "Belt oscillator: rest loses its stability", unstable_rest),
        Check("V18/cycle", "Belt oscillator: the stick-slip cycle ends", cycle_ends),
    ]


def cycle(engine: str) -> Iterator[CheckRow]:
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
        bound += last_digit(STICK_SLIP_PLACES) if unit == "s" else 0.0
        points = [compared(what, expected, float(value), bound, unit) for value in computed]
        yield worst_row("V16/cycle", points, BECAUSE)


def times(result: Result, kind: str) -> np.ndarray:
    """Times of events of one kind [s]."""
    return np.asarray(result.events["t"][result.events["kind"] == EVENT_KINDS[kind]])


def mu(speed: float) -> float:
    """Friction of the belt oscillator over its load."""
    return 0.5 + 0.5 * exp(-speed / 0.5)


def unstable_rest(engine: str) -> Iterator[CheckRow]:
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


def cycle_ends(engine: str) -> Iterator[CheckRow]:
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
