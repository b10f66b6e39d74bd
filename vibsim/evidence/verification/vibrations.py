"""Known vibrations: free, forced, with a spring on one side, with dry friction alone (V2 to V7, V12)."""

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from math import acos, atan2, cos, hypot, pi, sin, sqrt, ulp

import numpy as np

from vibsim.evidence.verification.checks import (
    BECAUSE,
    BOTH,
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
    relative_rounding,
    roundings,
    run,
    settled_bound,
    time_rounding,
    worst_row,
)
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results import Result

# V2 and V3: free vibration of two blocks, without and with the stop, against the closed form.
#
# V2: y = x1 - x2 swings with w = sqrt(k1 (1/m1 + 1/m2)), the centre of mass rests. V3: with the stop at the
# rest position, half a period of each frequency in turn: 2 f1 f2 / (f1 + f2).


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


def free_vibration_checks() -> list[Check]:
    """V2 and V3 by both flows."""
    listed = [Check(f"V2/{flow}", "Free vibration of two blocks", partial(free, flow)) for flow in BOTH]
    return listed + [
        Check(f"V3/{flow}", "Free vibration with the stop", partial(bilinear, flow)) for flow in BOTH
    ]


def free(flow: str) -> Iterator[CheckRow]:
    """V2: frequency, displacement and energy."""
    name = f"V2/{flow}"
    result = run(made_case(FREE, "free vibration"), flow)
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


def energy_row(name: str, result: Result, values: np.ndarray) -> CheckRow:
    """Energy is constant; it is quadratic in the state, so it is off by twice as much."""
    far = int(np.argmax(np.abs(values - values[0])))
    bound = 2 * values[0] * relative_rounding(result)
    point = compared(f"energy at {result.time[far]:g} s", values[0], values[far], bound, "J")
    return number_row(name, point, f"{REASON}; energy is quadratic")


def bilinear(flow: str) -> Iterator[CheckRow]:
    """V3: frequency, contacts and energy."""
    name = f"V3/{flow}"
    result = run(made_case(BILINEAR, "bilinear oscillator"), flow)
    begins = result.events["t"][result.events["kind"] == 1]
    expected = contacts(result.time[-1])
    yield counted_row(name, "impacts", expected, len(begins), "one in each period")
    span, f = float(begins[-1] - begins[0]), 1 / BILINEAR_OSCILLATOR_PERIOD
    late = ulp(span) + UNIT * STATE_UNITS * roundings(result) / FREE_RATE
    bound = f * (SCENE_UNITS * UNIT + 2 * late / span)
    yield number_row(name, compared("frequency", f, (len(begins) - 1) / span, bound, "Hz"), REASON)
    yield energy_row(name, result, energy(result))


# V4 and V5: block 1 before a wall under a harmonic force, against linear theory.
#
# The steady state is x1 = A / |Z| sin(w t - lag) with Z = k1 - m1 w^2 + i c w; with a stop at the distance G,
# its first contact (grazing) is at A = G |Z|.


M1, M2, K1, K2, G = 0.297, 2.94, 200.0, 12400.0, 1e-3
STEADY = """
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 200 N/m, c: 6 N s/m}
excitation: {kind: harmonic, A: 0.3 N, omega: 1 Hz}
run: {t_end: 5 s, every: 5 ms}
"""
GRAZING_CASE = """
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 200 N/m, c: 0.5 N s/m}
stop: {k2: 12400 N/m, G: 1 mm}
excitation: {kind: harmonic, A: 0.1 N, omega: 3 Hz}
run: {t_end: 13/6 s, every: 10 ms}
"""
OMEGA, C = 6 * pi, 0.5  # of GRAZING
DECADES = range(1, 13)
# |y0| + |u0 S| + A / m1 (|Hc| + |Hs|) + G <= (0.1 + 0.73 + 2 + 1.73 + 1) G: the terms of the closed form
TERMS = 5.6
HALVINGS_LINEAR = 48  # of the span 1 +- 1e-3 in which the grazing amplitude is looked for


def linear_theory_checks() -> list[Check]:
    """V4 and V5 by both flows."""
    listed = [
        Check(f"V4/{flow}", "Steady state under a harmonic force", partial(steady, flow)) for flow in BOTH
    ]
    listed += [
        Check(f"V5/{flow}", "Grazing of the steady state", partial(linear_theory_grazing, flow))
        for flow in BOTH
    ]
    return listed


def impedance(omega: float, c: float) -> float:
    """|k1 - m1 w^2 + i c w| [N/m]."""
    return hypot(K1 - M1 * omega**2, c * omega)


def conditioning(omega: float, c: float) -> float:
    """Sum of the changes of A / |Z| by one relative unit of k1, m1, c, w and A each."""
    size, detuned = impedance(omega, c) ** 2, abs(K1 - M1 * omega**2)
    stiffness, inertia, damping = K1 * detuned, M1 * omega**2 * detuned, (c * omega) ** 2
    return 1 + (stiffness + 3 * inertia + 2 * damping) / size


def steady(flow: str) -> Iterator[CheckRow]:
    """V4: amplitude below, at and above resonance; the transient has fallen to exp(-50)."""
    points = []
    for frequency in (1.0, 4.13, 9.0):
        omega = 2 * pi * frequency
        case = made_case(STEADY, "steady state", excitation__omega=f"{frequency} Hz")
        result = run(case, flow)
        amplitudes = np.hypot(result["x1"], result["v1"] / omega)[-20:]
        expected = 0.3 / impedance(omega, 6.0)
        far = float(amplitudes[np.argmax(np.abs(amplitudes - expected))])
        bound = expected * relative_rounding(result, conditioning(omega, 6.0), memory=2 * M1 / 6.0)
        points.append(compared(f"amplitude at {frequency:g} Hz", expected, far, bound, "m"))
    yield worst_row(f"V4/{flow}", points, REASON)


def grazing_run(flow: str, factor: float) -> Result:
    """Block 1 on the steady state that reaches `factor` G, from t = 0."""
    lag, size = atan2(C * OMEGA, K1 - M1 * OMEGA**2), factor * G
    case = made_case(
        GRAZING_CASE,
        "grazing",
        excitation__A=size * impedance(OMEGA, C),
        initial__x1=-size * sin(lag),
        initial__v1=size * OMEGA * cos(lag),
    )
    return run(case, flow)


def level_rounding(result: Result) -> float:
    """Relative error of the level that block 1 reaches: start and force come rounded 8 times more."""
    return relative_rounding(result, conditioning(OMEGA, C)) + 8 * UNIT


def linear_theory_grazing(flow: str) -> Iterator[CheckRow]:
    """V5: the amplitude at which contact begins, the margin below it and the first contact above it."""
    name = f"V5/{flow}"
    yield amplitude_row(name, flow)
    margins, begins, surprises = [], [], 0
    for k in DECADES:
        below, above = (grazing_run(flow, 1 + sign * 10.0**-k) for sign in (-1, 1))
        surprises += int(below.attrs["impacts"] > 0) + int(above.attrs["impacts"] == 0)
        margins.append(margin_point(below, k))
        begins.append(contact_point(above, k))
    yield counted_row(
        name, "runs at 1 +- 10^-k with the wrong contacts", 0, surprises, "24 runs, k = 1 to 12"
    )
    yield worst_row(name, margins, REASON)
    yield worst_row(name, begins, "rounding of the level over sin of the angle before the trough")


def amplitude_row(name: str, flow: str) -> CheckRow:
    """The least force with contact, by halving.

    A gap within its rounding bound, eps (16 + w0 t) x terms, counts as none: closer than that to grazing
    the engine may see a contact where there is none.
    """
    low, high = 1 - 1e-3, 1 + 1e-3
    for _ in range(HALVINGS_LINEAR):
        middle = (low + high) / 2
        result = grazing_run(flow, middle)
        low, high = (low, middle) if result.attrs["impacts"] else (middle, high)
    force, phase = G * impedance(OMEGA, C), sqrt(K1 / M1) * result.t_reached
    blurred = UNIT * (STATE_UNITS + phase) * TERMS
    bound = force * (level_rounding(result) + blurred + 1e-3 / 2.0**HALVINGS_LINEAR)
    point = compared("force at first contact", force, high * force, bound, "N")
    return number_row(name, point, f"{REASON}; a gap within its rounding bound counts as none")


def margin_point(result: Result, k: int) -> CheckPoint:
    """The grazing margin of a run 10^-k below."""
    margin = float(result.attrs.get("grazing_margin", float("nan")))
    return compared(f"margin at 1 - 1e-{k}", G * 10.0**-k, margin, G * level_rounding(result), "m")


def contact_point(result: Result, k: int) -> CheckPoint:
    """First contact 10^-k above: X sin(w t - lag) = -G, `early` before the trough at 3 pi / 2."""
    lag = atan2(C * OMEGA, K1 - M1 * OMEGA**2)
    early = acos(1 / (1 + 10.0**-k))
    expected = (1.5 * pi - early + lag) / OMEGA
    first = float(result.events["t"][1])
    spread = level_rounding(result) / sin(early) + UNIT * (
        SCENE_UNITS * 1.5 * pi + STATE_UNITS * roundings(result)
    )
    return compared(f"contact at 1 + 1e-{k}", expected, first, spread / OMEGA, "s")


# V12: the bilinear oscillator under a harmonic force: its cycle of two periods, and where impacts begin.
#
# x'' + 0.02 x' + x + 29 max(x - 1, 0) = f cos(0.8 t), f = 0.9 * 0.64 / 1.26: parameters of the bilinear demo
# of PWSDDE-cont. The velocities of the cycle are an independent solver's, the grazing is linear theory.


# multipliers of the modulus exp(-0.01 * 5 pi): errors fall by e in 100 s, to 4e-18 of themselves by 4000 s
CASE = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 1 N/m, c: 0.02 N s/m}}
stops: {wall: {between: [mass, ground], gap: 1 m, acts: compression, k: 29 N/m}}
forces: {drive: {on: mass, A: 16/35 N, omega: 0.8 rad/s, phase: 90 deg}}
run: {t_end: 4000 s, every: 100 s}
"""
ENTERS, LEAVES, PLACES = 1.073267857664968, -1.067358714677524, 15
# sum of |p dv/dp| over m, k, c, gap, k of the stop, A, omega by difference quotients [m/s]
CONDITIONING = 22.0
BILINEAR_CYCLE_PERIOD = 2 * 2 * pi / 0.8
GRAZING_AMPLITUDE = hypot(1 - 0.8**2, 0.02 * 0.8)  # 0.3603553801457667 N
# of k, m and omega^2: 0.36 (1 + 3 * 0.64) / F^2; of c and omega: 2 (0.016 / F)^2; of gap and A: 1 each
GRAZING_CONDITIONING = 2 + (0.36 * (1 + 3 * 0.64) + 2 * 0.016**2) / GRAZING_AMPLITUDE**2
HALVINGS_BILINEAR = 44


def bilinear_cycle_checks() -> list[Check]:
    """The cycle and its grazing."""
    return [
        Check("V12/cycle", "Bilinear oscillator: one impact in two periods", cycle),
        Check("V12/grazing", "Bilinear oscillator: where impacts begin", bilinear_cycle_grazing),
    ]


def cycle() -> Iterator[CheckRow]:
    """Velocities into and out of contact, and the time between contacts, over the last five cycles."""
    name = "V12/cycle"
    result = run(made_case(CASE, "bilinear oscillator"))
    bound = settled_bound(CONDITIONING, result.t_reached, 2) + last_digit(PLACES)
    for what, kind, expected in (("into", "contact_begin", ENTERS), ("out of", "contact_end", LEAVES)):
        chosen = result.events["kind"] == EVENT_KINDS[kind]
        speeds = result.events["v_mass"][chosen][-5:]
        points = [compared(f"velocity {what} contact", expected, float(v), bound, "m/s") for v in speeds]
        yield worst_row(name, points, BECAUSE)
    begins = result.events["t"][result.events["kind"] == EVENT_KINDS["contact_begin"]]
    late = 2 * bound / 0.9  # two instants; at contact the velocity changes with 0.9 m/s^2 or more
    period = compared(
        "five cycles of two periods", 5 * BILINEAR_CYCLE_PERIOD, float(begins[-1] - begins[-6]), late, "s"
    )
    yield number_row(name, period, f"{BECAUSE}, over the acceleration")


def on_linear_orbit(amplitude: float) -> Result:
    """Ten periods from the start of the orbit without impacts, f = `amplitude` [N]."""
    response = amplitude / complex(1 - 0.64, 0.016)
    start = {"initial__mass__x": response.real, "initial__mass__v": -0.8 * response.imag}
    settings = {
        "forces__drive__A": amplitude,
        "run__t_end": 10 * BILINEAR_CYCLE_PERIOD / 2,
        "run__every": "10 s",
    }
    return run(made_case(CASE, "bilinear oscillator", **settings, **start))


def bilinear_cycle_grazing() -> Iterator[CheckRow]:
    """The least force with an impact on the orbit of linear theory, by halving."""
    low, high = GRAZING_AMPLITUDE * (1 - 1e-3), GRAZING_AMPLITUDE * (1 + 1e-3)
    for _ in range(HALVINGS_BILINEAR):
        middle = (low + high) / 2
        result = on_linear_orbit(middle)
        low, high = (low, middle) if result.attrs["impacts"] else (middle, high)
    t = result.t_reached
    blurred = UNIT * (STATE_UNITS + t) * 4 + ulp(t)  # terms of the closed form: two states, two of the drive
    bound = GRAZING_AMPLITUDE * (
        relative_rounding(result, GRAZING_CONDITIONING) + 8 * UNIT + blurred + 1e-3 / 2.0**HALVINGS_BILINEAR
    )
    point = compared("force at first contact", GRAZING_AMPLITUDE, high, bound, "N")
    yield number_row("V12/grazing", point, "rounding; a gap within its rounding bound counts as none")


# The free bilinear oscillator in closed form: two blocks, a spring, and a stop at the rest position.
#
# y = x1 - x2 swings with w1 = sqrt(k1 (1/m1 + 1/m2)) while y > 0 and with w2, of k1 + k2, in contact: half a
# period of each in turn. The centre of mass rests.


FREE_RATE, CONTACT_RATE = (sqrt(k * (1 / M1 + 1 / M2)) for k in (K1, K1 + K2))
BILINEAR_OSCILLATOR_PERIOD = pi / FREE_RATE + pi / CONTACT_RATE


def relative_displacement(t: np.ndarray) -> np.ndarray:
    """y at the times t [s], released from y = 1 at rest."""
    phase = np.fmod(t, BILINEAR_OSCILLATOR_PERIOD)
    quarter = pi / (2 * FREE_RATE)
    contact = quarter + pi / CONTACT_RATE
    pressed = -FREE_RATE / CONTACT_RATE * np.sin(CONTACT_RATE * (phase - quarter))
    apart = np.cos(FREE_RATE * np.where(phase < contact, phase, BILINEAR_OSCILLATOR_PERIOD - phase))
    return np.asarray(np.where((phase < quarter) | (phase > contact), apart, pressed))


def contacts(t_end: float) -> int:
    """Number of contacts that begin until t_end [s]: the first after a quarter of a free period."""
    return int((t_end - pi / (2 * FREE_RATE)) / BILINEAR_OSCILLATOR_PERIOD) + 1


def contact_begin(n: int) -> float:
    """Time [s] at which contact n = 1, 2, ... begins."""
    return pi / (2 * FREE_RATE) + (n - 1) * BILINEAR_OSCILLATOR_PERIOD


def energy(result: Result, k2: float = K2) -> np.ndarray:
    """Kinetic and elastic energy [J] at every sample, from the states alone."""
    y = result["x1"] - result["x2"]
    kinetic = (M1 * result["v1"] ** 2 + M2 * result["v2"] ** 2) / 2
    return np.asarray(kinetic + (K1 + np.where(y < 0, k2, 0.0)) * y**2 / 2)


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


def sliding(flow: str) -> Iterator[CheckRow]:
    """V6: block 2 alone stops after v0 / (mu g) and v0^2 / (2 mu g), and stays."""
    name = f"V6/{flow}"
    times, ways, moves = [], [], []
    for v0 in (0.02, -0.02, 0.7):
        result = run(made_case(SLIDING, "sliding block", initial__v2=v0), flow)
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


def swinging(flow: str) -> Iterator[CheckRow]:
    """V7: circles about -1 (x' > 0) and +1, and amplitudes that fall by 4 mu m2 g / k1 per cycle."""
    name = f"V7/{flow}"
    result = run(made_case(SCALED, "scaled friction oscillator"), flow)
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
    yield friction_amplitude_row(name, flow)


def friction_amplitude_row(name: str, flow: str) -> CheckRow:
    """Fall of the maxima per cycle."""
    result = run(made_case(DECAYING, "decaying vibration"), flow)
    tops = result.events["x2"][1:-1][1::2][:-1]  # every second turn is a maximum; the last event is the stop
    fall = 4 * 0.02 * 2.94 * 9.81 / 200
    way = 10 * 8**2 / (2 * 1e12)  # block 1 gives way under 10 N at most in 8 s
    bound = 2 * (0.05 * relative_rounding(result, 4) + way)
    points = [
        compared(f"fall of the amplitude in cycle {n + 2}", fall, float(before - here), bound, "m")
        for n, (before, here) in enumerate(pairwise(tops))
    ]
    return worst_row(name, points, "4 mu m2 g / k1; block 1 gives way, rounding of two maxima")
