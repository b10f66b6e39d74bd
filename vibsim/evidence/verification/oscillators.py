"""Oscillators that strike a rigid stop (V13, V14) or stick and slip on a belt (V16 to V18).

V13 and V14 are x'' + c x' + x = A cos(w t) with a stop at x = sigma. V13 is that of Budd and Dux (c = 0,
w = 3.7, e = 0.8), one impact in two periods in closed form: with
gamma = 1 / (1 - w^2), T = 4 pi / w, cs = sin T (1 + e) / (1 - cos T) and r = (1 - e) / w the speed is
V = (-2 cs sigma + 2 sqrt(gamma^2 cs^2 - (sigma^2 - gamma^2) r^2)) / (cs^2 + r^2).
V14 is example 15.2 of Recipes for Continuation (COCO; c = 0.1, w = 1, sigma = 1, e = 0.8); its numbers are an
independent solver's. The demo of that example in COCO goes on along the orbits that graze, over w and A <= 1:
A = sqrt((1 - w^2)^2 + (c w)^2), by linear theory.
"""

from collections.abc import Iterator
from math import atan2, cos, exp, log, pi, sin, sqrt

import numpy as np

from vibsim.evidence.verification.checks import (
    BECAUSE,
    REASON,
    SCENE_UNITS,
    STATE_UNITS,
    UNIT,
    Check,
    CheckPoint,
    CheckRow,
    compared,
    counted_row,
    last_digit,
    made_case,
    number_row,
    run,
    settled_bound,
    time_rounding,
    worst_row,
)
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results import Result

# multipliers of the modulus e = 0.8 per impact: the start has fallen to 4e-20 of itself after 200
CASE = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 1 N/m, c: 0 N s/m}}
stops: {wall: {between: [mass, ground], gap: 0 m, acts: compression, law: rigid, e: 0.8}}
forces: {drive: {on: mass, A: 1 N, omega: 3.7 rad/s, phase: 90 deg}}
run: {t_end: 700 s, every: 100 s}
"""
OMEGA, E = 3.7, 0.8
PERIOD = 4 * pi / OMEGA
SPEED, IMPACT_OSCILLATORS_PLACES = 0.66569335283999, 14  # printed for sigma = 0
SIGMAS = (0.1, 0.2, 0.3)  # short of the fold of the family at 0.34514712445281
STEP = 1e-6  # of difference quotients
# multipliers of the modulus e exp(-0.1 pi) = 0.58 per impact: the start has fallen to 6e-24 after 100
RECIPES = {"links__spring__c": "0.1 N s/m", "stops__wall__gap": "1 m", "forces__drive__omega": "1 rad/s"}
GRAZING_AT = (0.5, 0.75, 1.0, 1.2, 1.35)  # rad/s, where A is at most 1 N
RECIPES_SPEED, RECIPES_PHASE = 1.695732937594882, 0.0759521649383
RECIPES_CONDITIONING = (5.0, 1.7)  # of speed [m/s] and phase [rad], by difference quotients as in V12


def impact_oscillator_checks() -> list[Check]:
    """Both oscillators."""
    return [
        Check("V13/settled", "Budd and Dux: one impact in two periods, from rest", settled),
        Check("V13/family", "Budd and Dux: the family of these motions", family),
        Check("V14/cycle", "Recipes for Continuation 15.2: one impact a period", recipes_cycle),
        Check("V14/grazing", "Recipes for Continuation 15.2: where impacts begin", recipes_grazing),
    ]


def speed_of(
    k: float = 1.0, m: float = 1.0, A: float = 1.0, omega: float = OMEGA, e: float = E, sigma: float = 0.0
) -> float:
    """Speed V of the impact [m/s], in closed form; numbers in SI."""
    own = sqrt(k / m)
    w, s = omega / own, sigma * k / A
    gamma, T = 1 / (1 - w * w), 4 * pi / w
    cs, r = sin(T) * (1 + e) / (1 - cos(T)), (1 - e) / w
    root = sqrt(gamma**2 * cs**2 - (s * s - gamma**2) * r * r)
    return A / k * own * (-2 * cs * s + 2 * root) / (cs**2 + r**2)


def conditioning_of(sigma: float) -> float:
    """Sum of |p dV/dp| over the numbers of the scene [m/s], and once the size of a state."""
    numbers = {"k": 1.0, "m": 1.0, "A": 1.0, "omega": OMEGA, "e": E, "sigma": sigma}
    moved = (
        speed_of(**{**numbers, key: value * (1 + STEP)}) - speed_of(**{**numbers, key: value * (1 - STEP)})
        for key, value in numbers.items()
    )
    # an error of the place where the mass is counts as one of sigma, in units of the amplitude
    place = (speed_of(sigma=sigma + STEP) - speed_of(sigma=sigma - STEP)) / (2 * STEP)
    return sum(abs(change) / (2 * STEP) for change in moved) + abs(place)


def speeds_of(result: Result) -> np.ndarray:
    """Speeds at all impacts [m/s]."""
    return np.asarray(result.events["before_v_mass"][result.events["kind"] == EVENT_KINDS["impact"]])


def settled() -> Iterator[CheckRow]:
    """From rest at sigma = 0: the speed of the last ten impacts, printed and in closed form."""
    result = run(made_case(CASE, "Budd and Dux"))
    bound = settled_bound(conditioning_of(0.0), result.t_reached, 1, OMEGA)
    for what, expected, more in (
        ("printed", SPEED, last_digit(IMPACT_OSCILLATORS_PLACES)),
        ("closed form", speed_of(), 0.0),
    ):
        points = [
            compared(f"impact speed, {what}", expected, float(v), bound + more, "m/s")
            for v in speeds_of(result)[-10:]
        ]
        yield worst_row("V13/settled", points, BECAUSE)


def family() -> Iterator[CheckRow]:
    """Started on the orbit, behind an impact, the mass strikes with the same speed each time."""
    points: list[CheckPoint] = []
    for sigma in SIGMAS:
        result = run(made_case(CASE, "Budd and Dux", **start_on_orbit(sigma)))
        bound = settled_bound(conditioning_of(sigma), result.t_reached, 1, OMEGA)
        points += [
            compared(f"impact speed at sigma = {sigma:g} m", speed_of(sigma=sigma), float(v), bound, "m/s")
            for v in speeds_of(result)
        ]
    yield worst_row("V13/family", points, BECAUSE)


def orbit(sigma: float) -> tuple[float, float, float, float]:
    """a, b, gamma and p of x = a cos t + b sin t + gamma cos(w t + p), t from behind an impact."""
    V, gamma = speed_of(sigma=sigma), 1 / (1 - OMEGA**2)
    a, b = -(1 + E) * V * sin(PERIOD) / (2 * (1 - cos(PERIOD))), -(1 + E) * V / 2
    response, rate = sigma - a, -E * V - b  # gamma cos p and -gamma w sin p
    return a, b, gamma, atan2(-rate / (gamma * OMEGA), response / gamma)


def start_on_orbit(sigma: float) -> dict[str, object]:
    """A run of 20 impacts that starts behind one of them."""
    phase = orbit(sigma)[-1]
    return {
        "stops__wall__gap": sigma,
        "initial__mass__x": sigma,
        "initial__mass__v": -E * speed_of(sigma=sigma),
        "forces__drive__phase": phase + pi / 2,
        "run__t_end": 20.5 * PERIOD,
        "run__every": "10 s",
    }


def recipes_cycle() -> Iterator[CheckRow]:
    """Speed and phase of the last ten impacts at A = 1, from rest."""
    result = run(made_case(CASE, "example 15.2", **RECIPES))
    fast, late = (settled_bound(one, result.t_reached, 1) for one in RECIPES_CONDITIONING)
    points = [
        compared("impact speed", RECIPES_SPEED, float(v), fast + last_digit(15), "m/s")
        for v in speeds_of(result)[-10:]
    ]
    yield worst_row("V14/cycle", points, BECAUSE)
    times = result.events["t"][result.events["kind"] == EVENT_KINDS["impact"]][-10:]
    late += last_digit(13) + UNIT * result.t_reached  # 2 pi itself is rounded
    points = [compared("phase of the impact", RECIPES_PHASE, float(t % (2 * pi)), late, "rad") for t in times]
    yield worst_row("V14/cycle", points, BECAUSE)


def recipes_grazing() -> Iterator[CheckRow]:
    """The steady state without impact reaches the stop at 1 m where A = sqrt((1 - w^2)^2 + (c w)^2)."""
    for omega in GRAZING_AT:
        beside = [sign * 10.0**-k for k in range(2, 13) for sign in (-1, 1)]
        wrong = sum(strikes(omega, 1 + each) != (each > 0) for each in beside)
        what = f"runs with the wrong contacts at {omega:g} rad/s"
        because = "22 runs on the steady state, its amplitude 1 +- 10^-k m, k = 2 to 12"
        yield counted_row("V14/grazing", what, 0, wrong, because)


def strikes(omega: float, amplitude: float) -> bool:
    """Whether the steady state amplitude sin(w t) [m] meets the stop."""
    in_phase, out_of_phase = 1 - omega**2, 0.1 * omega  # of the force, for 1 m
    values = {
        "forces__drive__A": amplitude * sqrt(in_phase**2 + out_of_phase**2),
        "forces__drive__omega": f"{omega!r} rad/s",
        "forces__drive__phase": f"{atan2(out_of_phase, in_phase)!r} rad",
        "initial__mass__v": amplitude * omega,
    }
    span = {"run__t_end": 2.2 * pi / omega, "run__every": "100 s"}  # more than a period
    result = run(made_case(CASE, "example 15.2", **{**RECIPES, **values, **span}))
    return bool(result.attrs["impacts"] > 0)


# V19 and V20: impacts of several bodies by the Newton-Moreau law.


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
BOUNCES, SEVERAL_IMPACTS_PLACES = (0.4038550218769, 0.4233169688147), 13
CONDITIONING = 1.6  # sum of |p dt/dp| / t over m, k, weights, gap and e, by difference quotients


def several_impact_checks() -> list[Check]:
    """Three balls, and two on a spring."""
    return [
        Check("V19/three_balls", "One ball meets two that touch", three_balls),
        Check("V20/two_balls", "Two balls on a spring fall on the floor", two_balls),
    ]


def three_balls() -> Iterator[CheckRow]:
    """(1, 0, 0) becomes (-1/3, 2/3, 2/3), with one impact and one impact passed on."""
    name = "V19/three_balls"
    result = run(made_case(BALLS, "three balls"))
    points = [
        compared(f"velocity of {ball}", v, float(result[f"v_{ball}"][-1]), STATE_UNITS * UNIT * abs(v), "m/s")
        for ball, v in (("a", -1 / 3), ("b", 2 / 3), ("c", 2 / 3))
    ]
    yield worst_row(name, points, "Newton-Moreau law; 16 units of rounding")
    kinds = [int(kind) for kind in result.events["kind"][1:-1]]
    expected = [EVENT_KINDS["impact"], EVENT_KINDS["transmitted"]]
    wrong = int(kinds != expected)
    yield counted_row(name, "events but one impact, one passed on", 0, wrong, "Newton-Moreau law")


def two_balls() -> Iterator[CheckRow]:
    """First and second bounce: nosnoc's example, by an independent solver."""
    result = run(made_case(SPRING, "two balls on a spring"))
    hits = result.events["t"][result.events["kind"] == EVENT_KINDS["impact"]]
    points = [
        compared(
            f"bounce {n + 1}",
            t,
            float(hits[n]),
            time_rounding(result, t, CONDITIONING) + last_digit(SEVERAL_IMPACTS_PLACES),
            "s",
        )
        for n, t in enumerate(BOUNCES)
    ]
    yield worst_row("V20/two_balls", points, f"{REASON}, and the last digit printed")


# Known cases of friction: Coulomb's alone, and sticking and slipping on a belt (V6, V7, V16 to V18).


# V17: x'' + 0.1 x' + x = 1.5 cos(0.9 t) - friction, 1 N while slipping and 1.1 N while sticking.
#
# Parameters of the friction demo of PWSDDE-cont: a symmetric orbit without sticking, whose amplitude is an
# independent solver's; Den Hartog (1931) has it in closed form.


# the damper alone takes a factor e in 20 s: the start has fallen to 6e-16 of itself by 700 s
FRICTION_OSCILLATOR = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 1 N/m, c: 0.1 N s/m}}
friction: {floor: {between: [mass, ground], N: 1 N, mu: 1, static: 1.1}}
forces: {drive: {on: mass, A: 1.5 N, omega: 0.9 rad/s, phase: 90 deg}}
initial: {mass: {v: 5 m/s}}
run: {t_end: 800 s, every: 100 s}
"""
AMPLITUDE, FRICTION_OSCILLATOR_PLACES = 2.42023635057437, 14
FRICTION_CONDITIONING = 27.0  # sum of |p dX/dp| over m, k, c, N, A, omega by difference quotients [m]
TURNS = 10


def friction_oscillator_checks() -> list[Check]:
    """One check."""
    return [Check("V17/amplitude", "Friction oscillator: symmetric orbit without sticking", amplitude)]


def amplitude() -> Iterator[CheckRow]:
    """Places of the last turns, and no stick."""
    name = "V17/amplitude"
    result = run(made_case(FRICTION_OSCILLATOR, "friction oscillator"))
    turning = result.events["kind"] == EVENT_KINDS["reversal"]
    places = result.events["x_mass"][turning][-TURNS:]
    bound = settled_bound(FRICTION_CONDITIONING, result.t_reached, 2)
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
CYCLE_PERIOD, STICK, RELEASE, STICK_SLIP_PLACES = 12.001031294830, 7.705031769350, 1.0, 12
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


def cycle() -> Iterator[CheckRow]:
    """Period, stick and place of the release of four cycles."""
    result = run(made_case(BLOCK, "block on a belt"))
    begins, ends = times(result, "stick_begin"), times(result, "stick_end")
    released = result.events["x_block"][result.events["kind"] == EVENT_KINDS["stick_end"]]
    steps = 1 + result.attrs["steps"] / len(ends)  # Taylor steps of a cycle
    for what, expected, computed, conditioning, unit in (
        ("period", CYCLE_PERIOD, np.diff(begins), PERIOD_CONDITIONING, "s"),
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


def unstable_rest() -> Iterator[CheckRow]:
    """Small vibrations about rest grow as exp(-(0.1 - exp(-2 belt)) t / 2): not at all at ln(10) / 2.

    Left out are the cube of the amplitude, mu''' / 16 SMALL^2 t < 0.03 SMALL^2 t, and the square, which
    shifts what is read here by mu'' SMALL.
    """
    points = []
    for belt in (0.9 * UNSTABLE, UNSTABLE, 1.1 * UNSTABLE):
        settings = {"friction__belt__belt": belt, "initial__block__x": mu(belt) + SMALL}
        result = run(made_case(OSCILLATOR, "belt oscillator", **settings))
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


def sticks_again(belt: float) -> tuple[bool, Result]:
    """Whether slip that begins on the belt comes back to its speed."""
    settings = {
        "friction__belt__belt": belt,
        "initial__block__v": belt,
        "initial__block__x": 0.9 - 0.1 * belt,
    }
    span = {"run__t_end": 10.0, "run__every": "10 s"}
    result = run(made_case(OSCILLATOR, "belt oscillator", **settings, **span))
    return len(times(result, "stick_begin")) > 0, result


def cycle_ends() -> Iterator[CheckRow]:
    """The largest speed of the belt with a stick-slip cycle, by halving."""
    low, high = CYCLE_ENDS * (1 - 1e-3), CYCLE_ENDS * (1 + 1e-3)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        again, result = sticks_again(middle)
        low, high = (middle, high) if again else (low, middle)
    bound = settled_bound(END_CONDITIONING, result.t_reached, 1 + result.attrs["steps"])
    bound += last_digit(CYCLE_PLACES) + 2e-3 * CYCLE_ENDS / 2.0**HALVINGS
    point = compared("speed of the belt at the end of the cycle", CYCLE_ENDS, low, bound, "m/s")
    yield number_row("V18/cycle", point, BECAUSE)
