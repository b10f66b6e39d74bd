"""V22 to V32: laws as formulas, beside closed forms, independent solvers and numbers of the literature.

V22: Duffing's oscillator, V23: a pendulum; periods from elliptic integrals. V24: Hertz's contact. V25: the
start of a motor with its current, Modelica's DCPM_Start. V26: friction with a state, LuGre (Canudas de Wit
and others, 1995). V27: a gear pair with backlash (Kahraman and Singh, 1991). V28: a sweep of the frequency.
V29: Mathieu's equation. V30: Modelica's CoupledClutches. V31: exponents of Sprott (2003). V32: a motor with
its current becomes the paper's motor as the inductance goes to 0.
"""

from collections.abc import Iterator
from math import cos, pi, radians, sin

import numpy as np

from vibsim.engine.tangent.monodromy import Carrier
from vibsim.evidence.verification.checks import (
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
    named_case,
    number_row,
    run,
    worst_row,
)
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results import Result

PRINTED = "half a unit of the last digit that was printed"
ROUNDED = "rounding: (4 units of the scene, 16 per event and step) x conditioning"


def formula_checks() -> list[Check]:
    """V22 to V32."""
    return [
        Check("V22/periods", "Duffing's oscillator, free", duffing_periods),
        Check("V23/period", "A pendulum let go at 170 deg", pendulum_period),
        Check("V24/contact", "Hertz: a ball against a wall", hertz_contact),
        Check("V25/start", "Start of a motor with its current (Modelica)", motor_start),
        Check("V26/stick_slip", "LuGre friction (Canudas de Wit and others)", lugre_places),
        Check("V27/gears", "Gear pair with backlash (Kahraman and Singh)", gear_states),
        Check("V28/sweep", "An oscillator through whose resonance the frequency goes", swept_extremes),
        Check("V29/traces", "Mathieu's equation on the edges of stability", mathieu_traces),
        Check("V30/clutches", "Coupled clutches (Modelica)", clutch_events),
        Check("V31/exponents", "Largest exponents of driven oscillators (Sprott)", exponents),
        Check("V32/current", "A motor with its current, L to 0", vanishing_inductance),
    ]


def rounding(result: Result, conditioning: float) -> float:
    """Bound of the relative error of a number of a run: every number of the scene, every event and every
    Taylor step is rounded.
    """
    stages = 1 + result.attrs["events"] + result.attrs["steps"]
    return float(UNIT * conditioning * (SCENE_UNITS + STATE_UNITS * stages))


def state_at(result: Result, column: str, t: float) -> float:
    """A column at the sample nearest to t [s]."""
    return float(result[column][np.argmin(np.abs(result.time - t))])


def at_end(result: Result, column: str) -> float:
    """A column at the end of the run."""
    return float(result.events[column][-1])


def times_of(result: Result, kind: str) -> np.ndarray:
    return np.asarray(result.events["t"][result.events["kind"] == EVENT_KINDS[kind]])


# V22 and V23: periods. The run ends where the motion should be back at rest; there v / a is by how much the
# period is shorter, a the acceleration at the start.


DUFFING = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], force: "k*d + k3*d**3", k: 1 N/m, k3: 1 N/m^3}}
initial: {mass: {x: 1 m}}
run: {t_end: 5 s, every: 1 s}
"""
PENDULUM = """
bodies: {bob: 1 kg m^2}
links: {weight: {between: [bob, ground], force: "M*sin(d)", M: 1 N m}}
initial: {bob: {x: 170 deg}}
run: {t_end: 15 s, every: 1 s}
"""
DUFFING_PERIODS = (
    (1.0, 1.0, 4.7680220291024608),
    (1.0, 2.0, 3.1797233167817153),
    (0.0, 1.0, 7.4162987092054877),
)
DUFFING_CONDITIONING = 3.0  # A, k, k3 and the mass move the period by at most 1, 1/2, 1/2 and 1/2 of it
PENDULUM_PERIOD = 15.326967999136585
PENDULUM_CONDITIONING = 6.0  # the angle by 4.4: dT = 22.9 s/rad there; M and the inertia by 1/2 each


def period_point(case_text: str, name: str, T: float, a: float, c: float, **values: str) -> CheckPoint:
    """The period of a free vibration; a: acceleration at the start; c: conditioning."""
    result = run(made_case(case_text, name, **values, run__t_end=f"{T!r} s"))
    column = next(key for key in result if key.startswith("v_"))
    obtained = T - at_end(result, column) / a
    return compared(f"period, {name}", T, obtained, T * rounding(result, c), "s")


def duffing_periods() -> Iterator[CheckRow]:
    """x'' + k x + x^3 = 0 from rest at A."""
    points = []
    for k, A, T in DUFFING_PERIODS:
        values = {"links__spring__k": f"{k} N/m", "initial__mass__x": f"{A} m"}
        name = f"k = {k:g} N/m, A = {A:g} m"
        points.append(period_point(DUFFING, name, T, -k * A - A**3, DUFFING_CONDITIONING, **values))
    yield worst_row("V22/periods", points, ROUNDED)


def pendulum_period() -> Iterator[CheckRow]:
    """x'' + sin x = 0."""
    a = -sin(radians(170))
    point = period_point(PENDULUM, "170 deg", PENDULUM_PERIOD, a, PENDULUM_CONDITIONING)
    yield number_row("V23/period", point, ROUNDED)


# V24: depth (5 m v^2 / (4 K))^(2/5), duration 2.94 depth / v, force K depth^(3/2).


HERTZ = """
bodies: {ball: 1 kg}
stops: {wall: {between: [ball, ground], gap: 1 mm, acts: compression, force: "K*p**1.5", K: 1e6 N/m^1.5}}
initial: {ball: {v: 1 m/s}}
run: {t_end: 30 ms, every: 1 ms}
"""
HERTZ_DEPTH, HERTZ_DURATION, HERTZ_FORCE = 4.3527528164806e-3, 12.811349348247e-3, 287.17458874926
HERTZ_CONDITIONING = 2.0  # m, v and K move the depth by 2/5, 4/5 and 2/5 of it, the duration by less


def hertz_contact() -> Iterator[CheckRow]:
    """Duration from the events, depth in the middle of the contact, where the ball turns."""
    result = run(made_case(HERTZ, "Hertz"))
    begin, end = times_of(result, "contact_begin")[0], times_of(result, "contact_end")[0]
    share = rounding(result, HERTZ_CONDITIONING)
    point = compared("duration", HERTZ_DURATION, float(end - begin), last_digit(15) + end * share, "s")
    yield number_row("V24/contact", point, f"{PRINTED}; {ROUNDED}")
    middle = float(begin + HERTZ_DURATION / 2)
    depth = at_end(run(made_case(HERTZ, "Hertz", run__t_end=f"{middle!r} s")), "x_ball") - 1e-3
    because = f"{PRINTED}; {ROUNDED}"
    bound = last_digit(16) + (HERTZ_DEPTH + 1e-3) * share
    yield number_row("V24/contact", compared("depth", HERTZ_DEPTH, depth, bound, "m"), because)
    force = 1e6 * depth**1.5
    bound = last_digit(11) + 1.5 * HERTZ_FORCE * bound / HERTZ_DEPTH
    yield number_row("V24/contact", compared("greatest force", HERTZ_FORCE, force, bound, "N"), because)


# V25: linear between the kinks of the voltage and the jump of the load: exponentials of matrices, in 40
# digits. The printed ones are these to 8 decimals.


MOTOR = """
bodies: {shaft: 0.3 kg m^2}
states:
  i:
    rate: "(V*max(0, min(1, (t - ta)/(tb - ta))) - R*i - k*v_shaft)/L"
    start: 0 A
    V: 100 V
    ta: 0.2 s
    tb: 1 s
    R: 0.05 ohm
    k: 0.6366197723675815 V s/rad
    L: 1.5 mH
forces:
  torque: {on: shaft, force: "k*i", k: 0.6366197723675815 N m/A}
  load: {on: shaft, force: "where(t < t1, 0, -T)", t1: 1.5 s, T: 63.66 N m}
run: {t_end: 2 s, every: 0.5 s}
"""
MOTOR_STATES = {
    1.0: {"i": 92.527385535512510938, "v_shaft": 149.81253736567408136, "x_shaft": 57.069126262845346238},
    2.0: {"i": 99.974363430949031512, "v_shaft": 149.22784374991321578, "x_shaft": 210.22598366802848969},
}
MOTOR_UNITS = {"i": "A", "v_shaft": "rad/s", "x_shaft": "rad"}
MOTOR_CONDITIONING = 6.0  # V, k twice, J, L, R: each moves speed, angle and current by at most all of it


def motor_start() -> Iterator[CheckRow]:
    """Current, speed and angle at the end of the ramp, and under load."""
    result = run(made_case(MOTOR, "motor start"))
    share = rounding(result, MOTOR_CONDITIONING)
    points = [
        compared(f"{name} at {t:g} s", value, state_at(result, name, t), share * value, MOTOR_UNITS[name])
        for t, values in MOTOR_STATES.items()
        for name, value in values.items()
    ]
    yield worst_row("V25/start", points, ROUNDED)
    switches = int(np.sum(result.events["kind"] == EVENT_KINDS["switch"]))
    yield counted_row("V25/start", "jumps", 1, switches, "the load jumps, the voltage has kinks alone")


# V26 to V28: printed by independent solvers.


LUGRE = """
parameters: {s0: 1e5 N/m, s1: 316.22776601683796 N s/m, Fc: 1 N, Fs: 1.5 N, vs: 1e-3 m/s}
bodies: {mass: 1 kg}
links: {spring: {between: [mass, base], k: 2 N/m}}
states: {z: {rate: "v_mass - s0*abs(v_mass)*z/(Fc + (Fs - Fc)*exp(-(v_mass/vs)**2))", start: 0 m}}
forces:
  friction:
    on: mass
    force: "-s0*z - s1*(v_mass - s0*abs(v_mass)*z/(Fc + (Fs - Fc)*exp(-(v_mass/vs)**2))) - s2*v_mass"
    s2: 0.4 N s/m
base: {x: "V*t", V: 0.1 m/s}
run: {t_end: 30 s, every: 10 s}
"""
LUGRE_PLACES = ((10.0, 0.627583129, 9), (20.0, 1.272596412, 9), (30.0, 2.5451019, 7))
GEARS = """
parameters: {w: 0.5 rad/s}
bodies: {gears: 1 kg}
links:
  mesh:
    between: [gears, ground]
    force: "(k0 - k1*cos(w*t) - k2*cos(2*w*t) - k3*cos(3*w*t))*(max(d - b, 0) + min(d + b, 0)) + c*v"
    k0: 1 N/m
    k1: 0.2 N/m
    k2: 0.1 N/m
    k3: 0.05 N/m
    b: 1 m
    c: 0.1 N s/m
forces:
  load:
    on: gears
    force: "F + m*w**2*(e1*cos(w*t) + 4*e2*cos(2*w*t) + 9*e3*cos(3*w*t))"
    F: 0.1 N
    m: 1 kg
    e1: 0.01 m
    e2: 0.004 m
    e3: 0.002 m
run: {t_end: 400 s, every: 10 ms}
"""
GEAR_STATES = (
    (50.0, "x_gears", 1.12236268644, 11),
    (50.0, "v_gears", 0.08437248869, 11),
    (400.0, "x_gears", 1.066841539275, 12),
    (400.0, "v_gears", -0.103165961282, 12),
)
GEAR_PASSAGES = 115  # of x through the backlash's edge
SWEEP = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 1 N/m}}
forces: {drive: {on: mass, force: "A*cos(a*t**2/2)", A: 1 N, a: 0.01 1/s^2}}
run: {t_end: 100 s, every: 100 s}
"""
SWEEP_EXTREMES = (("0.01", 13.5325024, 120.0264411), ("0.001", -46.4239976, 1069.4090234))


def lugre_places() -> Iterator[CheckRow]:
    """Places of the mass: it sticks, jumps, sticks."""
    result = run(made_case(LUGRE, "LuGre"))
    points = [
        compared(f"x at {t:g} s", x, state_at(result, "x_mass", t), last_digit(places), "m")
        for t, x, places in LUGRE_PLACES
    ]
    yield worst_row("V26/stick_slip", points, PRINTED)


def gear_states() -> Iterator[CheckRow]:
    """Two states, and how often the teeth part or meet."""
    result = run(made_case(GEARS, "gear pair"))
    points = [
        compared(f"{name} at {t:g} s", value, state_at(result, name, t), last_digit(places))
        for t, name, value, places in GEAR_STATES
    ]
    yield worst_row("V27/gears", points, PRINTED)
    pressed = result["x_gears"] > 1
    passages = int(np.sum(pressed[1:] != pressed[:-1]))
    yield counted_row(
        "V27/gears", "passages of the edge", GEAR_PASSAGES, passages, "counted in samples 10 ms apart"
    )


def swept_extremes() -> Iterator[CheckRow]:
    """x'' + x = cos(a t^2/2) from rest: the extreme, and when it is met, from x and v at the printed time."""
    values, times = [], []
    for a, extreme, t in SWEEP_EXTREMES:
        values_of = {"run__t_end": f"{t} s", "forces__drive__a": f"{a} 1/s^2"}
        result = run(made_case(SWEEP, f"sweep {a}", **values_of))
        x, v = at_end(result, "x_mass"), at_end(result, "v_mass")
        turn = t - v / (cos(float(a) * t**2 / 2) - x)
        values.append(compared(f"extreme, a = {a}/s^2", extreme, x, last_digit(7), "m"))
        times.append(compared(f"its time, a = {a}/s^2", t, turn, last_digit(7), "s"))
    yield worst_row("V28/sweep", values, PRINTED)
    yield worst_row("V28/sweep", times, PRINTED)


# V29: x'' + (a - 2 cos 2t) x = 0; on the edges of stability the trace over pi is 2 or -2.


MATHIEU = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], force: "(a - q*cos(w*t))*d", a: 1 N/m, q: 2 N/m, w: 2 rad/s}}
run: {t_end: 4 s, every: 1 s}
"""
MATHIEU_EDGES = ((-0.4551386041074136, 2.0), (3.91702477299847, 2.0), (-0.1102488169920952, -2.0))
MATHIEU_STEPS = 20  # over pi, no more


def mathieu_traces() -> Iterator[CheckRow]:
    """The trace of the monodromy matrix, along a motion and at rest; its entries tell how disturbances are
    amplified on the way.
    """
    for start, where in (([1.0, 0.0], "along a motion"), ([0.0, 0.0], "at rest")):
        points = []
        for a, trace in MATHIEU_EDGES:
            case = made_case(MATHIEU, f"Mathieu {a}", links__spring__a=f"{a!r} N/m")
            monodromy = Carrier(case.scene()).carry(start, pi).vectors
            size = (1 + float(np.abs(monodromy).max())) ** 2
            bound = UNIT * size * (SCENE_UNITS + STATE_UNITS * MATHIEU_STEPS)
            what = f"trace {where}, a = {a:.9f}"
            points.append(compared(what, trace, float(np.trace(monodromy)), bound))
        yield worst_row("V29/traces", points, ROUNDED)


# V30: every phase in closed form; 30 digits of each. Load 20 N m, coefficient 0.5, holding 1.1 times that.


CLUTCHES = """
bodies: {disc1: 1 kg m^2, disc2: 1 kg m^2, disc3: 1 kg m^2, disc4: 1 kg m^2}
friction:
  clutch1: {between: [disc1, disc2], N: "F*cos(w*t)", F: 20 N m, w: 0.2 Hz, mu: 0.5, static: 1.1}
  clutch2: {between: [disc2, disc3], N: "where(t < t2, 0, F)", F: 20 N m, t2: 0.4 s, mu: 0.5, static: 1.1}
  clutch3: {between: [disc3, disc4], N: "where(t < t3, 0, F)", F: 20 N m, t3: 0.9 s, mu: 0.5, static: 1.1}
forces: {drive: {on: disc1, A: 10 N m, omega: 5 Hz}}
initial: {disc1: {v: 10 rad/s}}
run: {t_end: 1.5 s, every: 0.5 s}
"""
CLUTCH_EVENTS = (
    ("stick_begin", 0.70962147469374666, 20.0),  # rate at which slip, or what is left to hold, goes to 0
    ("stick_begin", 0.79166235915481601, 10.0),
    ("stick_end", 0.83110850613765324, 100.0),
    ("stick_begin", 0.90685019279787972, 10.0),
    ("stick_end", 1.00029585989463867, 100.0),
    ("stick_begin", 1.14396749247316597, 10.0),
)
CLUTCH_SPEED = 3.24705827241879501


def clutch_events() -> Iterator[CheckRow]:
    """The six changes from slip to stick and back, and the speed at the end."""
    result = run(made_case(CLUTCHES, "coupled clutches"))
    kinds = {EVENT_KINDS[kind]: kind for kind in ("stick_begin", "stick_end")}
    happened = [
        (kinds[int(kind)], float(t))
        for kind, t in zip(result.events["kind"], result.events["t"], strict=True)
        if int(kind) in kinds and t != 0.4  # at which clutch 2, without load so far, begins to slip
    ]
    expected = [kind for kind, _, _ in CLUTCH_EVENTS]
    same = sum(one == other for (one, _), other in zip(happened, expected, strict=False))
    yield counted_row("V30/clutches", "changes", len(expected), same, "locks and slips in their order")
    share = rounding(result, 1.0)
    points = [
        compared(f"{kind} at {t:.3f} s", t, obtained, t * share * (1 + 10 / rate), "s")
        for (kind, t, rate), (_, obtained) in zip(CLUTCH_EVENTS, happened, strict=False)
    ]
    yield worst_row("V30/clutches", points, ROUNDED)
    speed = float(result["v_disc1"][-1])
    point = compared("speed of disc 1 at 1.5 s", CLUTCH_SPEED, speed, 10 * share, "rad/s")
    yield number_row("V30/clutches", point, ROUNDED)


# V31: exponents of chaotic motions scatter; ours comes with the half width of its 95 % interval.


CHAOTIC = {
    "gallery/driven-pendulum": 0.1414,
    "gallery/ueda-oscillator": 0.1034,
    "gallery/duffing-two-well": 0.1572,
}
EXPONENT_SPAN = 50_000.0  # s
WIDTHS = 2.0  # half widths of 95 % intervals: four standard errors


def exponents() -> Iterator[CheckRow]:
    """The largest exponent, behind a transient of 1,000 s."""
    from vibsim.analysis.regime import lyapunov

    points = []
    for name, expected in CHAOTIC.items():
        case = named_case(name, run__t_end=f"{EXPONENT_SPAN} s", run__every="1000 s")
        spectrum = lyapunov(case, count=1, discard=1000.0)
        bound = WIDTHS * float(spectrum.half_widths[0]) + last_digit(4)
        points.append(
            compared(f"exponent of {case.name}", expected, float(spectrum.exponents[0]), bound, "1/s")
        )
    yield worst_row("V31/exponents", points, "twice the half width of the 95 % interval; printed digits")


# V32: with the torque Kt i and L i' = Kt (Omega0 - w) - R i, R = Kt^2 Omega0 / M0, differences from the
# paper's motor are a series in L. Its first two terms are taken out by runs at L, L/2 and L/4; what is left
# is less than what the second one was.


INDUCTANCES = ("4 mH", "2 mH", "1 mH")
CURRENT_END = "5 s"


def vanishing_inductance() -> Iterator[CheckRow]:
    """Rotor and blocks after 5 s."""
    ends = {"run__t_end": CURRENT_END, "run__every": CURRENT_END}
    paper = run(named_case("II-B-captured", **ends))
    runs = [run(named_case("gallery/captured-motor", **ends, states__i__L=L)) for L in INDUCTANCES]
    points, orders = [], []
    for name, unit in (("phi", "rad"), ("phidot", "rad/s"), ("x1", "m")):
        whole, half, quarter = (float(result[name][-1]) for result in runs)
        first, second = 2 * half - whole, 2 * quarter - half
        limit, expected = (4 * second - first) / 3, float(paper[name][-1])
        points.append(compared(f"{name}, L to 0", expected, limit, abs(second - first) / 3, unit))
        ratio = (whole - expected) / (half - expected)
        left = abs(second - first) / abs(half - expected)
        orders.append(compared(f"ratio of differences in {name}", 2.0, ratio, 2 * left))
    yield worst_row("V32/current", points, "the last correction of the extrapolation")
    yield worst_row("V32/current", orders, "terms of the second order in L")
