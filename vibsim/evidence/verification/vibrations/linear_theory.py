"""V4 and V5: block 1 before a wall under a harmonic force, against linear theory.

The steady state is x1 = A / |Z| sin(w t - lag) with Z = k1 - m1 w^2 + i c w; with a stop at the distance G,
its first contact (grazing) is at A = G |Z|.
"""

from collections.abc import Iterator
from functools import partial
from math import acos, atan2, cos, hypot, pi, sin, sqrt

import numpy as np

from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.rounding import REASON, relative_rounding, roundings
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Point, Row, compared, counted_row, number_row, worst_row
from vibsim.evidence.verification.runs import BOTH, made_case, run
from vibsim.results import Result

M1, K1, G = 0.297, 200.0, 1e-3
STEADY = """
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 200 N/m, c: 6 N s/m}
excitation: {kind: harmonic, A: 0.3 N, omega: 1 Hz}
run: {t_end: 5 s, every: 5 ms}
"""
GRAZING = """
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
HALVINGS = 48  # of the span 1 +- 1e-3 in which the grazing amplitude is looked for


def checks() -> list[Check]:
    """V4 and V5 by both flows."""
    listed = [
        Check(f"V4/{flow}", "Steady state under a harmonic force", partial(steady, flow)) for flow in BOTH
    ]
    listed += [Check(f"V5/{flow}", "Grazing of the steady state", partial(grazing, flow)) for flow in BOTH]
    return listed


def impedance(omega: float, c: float) -> float:
    """|k1 - m1 w^2 + i c w| [N/m]."""
    return hypot(K1 - M1 * omega**2, c * omega)


def conditioning(omega: float, c: float) -> float:
    """What one relative unit of k1, m1, c, w and A each changes A / |Z| by, added up."""
    size, detuned = impedance(omega, c) ** 2, abs(K1 - M1 * omega**2)
    stiffness, inertia, damping = K1 * detuned, M1 * omega**2 * detuned, (c * omega) ** 2
    return 1 + (stiffness + 3 * inertia + 2 * damping) / size


def steady(flow: str, engine: str) -> Iterator[Row]:
    """V4: amplitude below, at and above resonance; the transient has fallen to exp(-50)."""
    points = []
    for frequency in (1.0, 4.13, 9.0):
        omega = 2 * pi * frequency
        case = made_case(STEADY, "steady state", excitation__omega=f"{frequency} Hz")
        result = run(case, engine, flow)
        amplitudes = np.hypot(result["x1"], result["v1"] / omega)[-20:]
        expected = 0.3 / impedance(omega, 6.0)
        far = float(amplitudes[np.argmax(np.abs(amplitudes - expected))])
        bound = expected * relative_rounding(result, conditioning(omega, 6.0), memory=2 * M1 / 6.0)
        points.append(compared(f"amplitude at {frequency:g} Hz", expected, far, bound, "m"))
    yield worst_row(f"V4/{flow}", points, REASON)


def grazing_run(flow: str, engine: str, factor: float) -> Result:
    """Block 1 on the steady state that reaches `factor` G, from t = 0."""
    lag, size = atan2(C * OMEGA, K1 - M1 * OMEGA**2), factor * G
    case = made_case(
        GRAZING,
        "grazing",
        excitation__A=size * impedance(OMEGA, C),
        initial__x1=-size * sin(lag),
        initial__v1=size * OMEGA * cos(lag),
    )
    return run(case, engine, flow)


def level_rounding(result: Result) -> float:
    """Relative error of the level that block 1 reaches: start and force come rounded 8 times more."""
    return relative_rounding(result, conditioning(OMEGA, C)) + 8 * UNIT


def grazing(flow: str, engine: str) -> Iterator[Row]:
    """V5: the amplitude at which contact begins, the margin below it and the first contact above it."""
    name = f"V5/{flow}"
    yield amplitude_row(name, flow, engine)
    margins, begins, surprises = [], [], 0
    for k in DECADES:
        below, above = (grazing_run(flow, engine, 1 + sign * 10.0**-k) for sign in (-1, 1))
        surprises += int(below.attrs["impacts"] > 0) + int(above.attrs["impacts"] == 0)
        margins.append(margin_point(below, k))
        begins.append(contact_point(above, k))
    yield counted_row(
        name, "runs at 1 +- 10^-k with the wrong contacts", 0, surprises, "24 runs, k = 1 to 12"
    )
    yield worst_row(name, margins, REASON)
    yield worst_row(name, begins, "rounding of the level over sin of the angle before the trough")


def amplitude_row(name: str, flow: str, engine: str) -> Row:
    """The least force with contact, by halving.

    A gap within its rounding bound, eps (16 + w0 t) x terms, counts as none: closer than that to grazing
    the engine may see a contact where there is none.
    """
    low, high = 1 - 1e-3, 1 + 1e-3
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        result = grazing_run(flow, engine, middle)
        low, high = (low, middle) if result.attrs["impacts"] else (middle, high)
    force, phase = G * impedance(OMEGA, C), sqrt(K1 / M1) * result.t_reached
    blurred = UNIT * (STATE_UNITS + phase) * TERMS
    bound = force * (level_rounding(result) + blurred + 1e-3 / 2.0**HALVINGS)
    point = compared("force at first contact", force, high * force, bound, "N")
    return number_row(name, point, f"{REASON}; a gap within its rounding bound counts as none")


def margin_point(result: Result, k: int) -> Point:
    """The grazing margin of a run 10^-k below."""
    margin = float(result.attrs.get("grazing_margin", float("nan")))
    return compared(f"margin at 1 - 1e-{k}", G * 10.0**-k, margin, G * level_rounding(result), "m")


def contact_point(result: Result, k: int) -> Point:
    """First contact 10^-k above: X sin(w t - lag) = -G, `early` before the trough at 3 pi / 2."""
    lag = atan2(C * OMEGA, K1 - M1 * OMEGA**2)
    early = acos(1 / (1 + 10.0**-k))
    expected = (1.5 * pi - early + lag) / OMEGA
    first = float(result.events["t"][1])
    spread = level_rounding(result) / sin(early) + UNIT * (
        SCENE_UNITS * 1.5 * pi + STATE_UNITS * roundings(result)
    )
    return compared(f"contact at 1 + 1e-{k}", expected, first, spread / OMEGA, "s")
