"""V12: the bilinear oscillator under a harmonic force: its cycle of two periods, and where impacts begin.

x'' + 0.02 x' + x + 29 max(x - 1, 0) = f cos(0.8 t), f = 0.9 * 0.64 / 1.26: parameters of the bilinear demo of
PWSDDE-cont. The velocities of the cycle are an independent solver's, the grazing is linear theory.
"""

from collections.abc import Iterator
from math import hypot, pi, ulp

from vibsim.evidence.verification.bounds.kicks import STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.rounding import relative_rounding
from vibsim.evidence.verification.bounds.settled import BECAUSE, last_digit, settled_bound
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, number_row, worst_row
from vibsim.evidence.verification.runs import made_case, run
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results import Result

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
PERIOD = 2 * 2 * pi / 0.8
GRAZING = hypot(1 - 0.8**2, 0.02 * 0.8)  # 0.3603553801457667 N
# of k, m and omega^2: 0.36 (1 + 3 * 0.64) / F^2; of c and omega: 2 (0.016 / F)^2; of gap and A: 1 each
GRAZING_CONDITIONING = 2 + (0.36 * (1 + 3 * 0.64) + 2 * 0.016**2) / GRAZING**2
HALVINGS = 44


def checks() -> list[Check]:
    """The cycle and its grazing."""
    return [
        Check("V12/cycle", "Bilinear oscillator: one impact in two periods", cycle),
        Check("V12/grazing", "Bilinear oscillator: where impacts begin", grazing),
    ]


def cycle(engine: str) -> Iterator[Row]:
    """Velocities into and out of contact, and the time between contacts, over the last five cycles."""
    name = "V12/cycle"
    result = run(made_case(CASE, "bilinear oscillator"), engine)
    bound = settled_bound(CONDITIONING, result.t_reached, 2) + last_digit(PLACES)
    for what, kind, expected in (("into", "contact_begin", ENTERS), ("out of", "contact_end", LEAVES)):
        chosen = result.events["kind"] == EVENT_KINDS[kind]
        speeds = result.events["v_mass"][chosen][-5:]
        points = [compared(f"velocity {what} contact", expected, float(v), bound, "m/s") for v in speeds]
        yield worst_row(name, points, BECAUSE)
    begins = result.events["t"][result.events["kind"] == EVENT_KINDS["contact_begin"]]
    late = 2 * bound / 0.9  # two instants; at contact the velocity changes with 0.9 m/s^2 or more
    period = compared("five cycles of two periods", 5 * PERIOD, float(begins[-1] - begins[-6]), late, "s")
    yield number_row(name, period, f"{BECAUSE}, over the acceleration")


def on_linear_orbit(amplitude: float, engine: str) -> Result:
    """Ten periods from the start of the orbit without impacts, f = `amplitude` [N]."""
    response = amplitude / complex(1 - 0.64, 0.016)
    start = {"initial__mass__x": response.real, "initial__mass__v": -0.8 * response.imag}
    settings = {"forces__drive__A": amplitude, "run__t_end": 10 * PERIOD / 2, "run__every": "10 s"}
    return run(made_case(CASE, "bilinear oscillator", **settings, **start), engine)


def grazing(engine: str) -> Iterator[Row]:
    """The least force with an impact on the orbit of linear theory, by halving."""
    low, high = GRAZING * (1 - 1e-3), GRAZING * (1 + 1e-3)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        result = on_linear_orbit(middle, engine)
        low, high = (low, middle) if result.attrs["impacts"] else (middle, high)
    t = result.t_reached
    blurred = UNIT * (STATE_UNITS + t) * 4 + ulp(t)  # terms of the closed form: two states, two of the drive
    bound = GRAZING * (
        relative_rounding(result, GRAZING_CONDITIONING) + 8 * UNIT + blurred + 1e-3 / 2.0**HALVINGS
    )
    point = compared("force at first contact", GRAZING, high, bound, "N")
    yield number_row("V12/grazing", point, "rounding; a gap within its rounding bound counts as none")
