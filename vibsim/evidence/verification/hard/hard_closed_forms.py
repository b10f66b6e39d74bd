"""The hard cases whose truth is a closed form: a linear vibration, tiny amplitudes, impacts without loss."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial
from math import atan2, pi, sqrt

import numpy as np

from vibsim.cases import load_case
from vibsim.evidence.verification.bounds.kicks import STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.rounding import REASON, relative_rounding, roundings, time_rounding
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.hard.hard_cases import LUCK
from vibsim.evidence.verification.row import Row, compared, counted_row, number_row, worst_row
from vibsim.evidence.verification.runs import BOTH, bare_run
from vibsim.evidence.verification.vibrations.bilinear_oscillator import (
    FREE_RATE,
    M1,
    contact_begin,
    contacts,
    energy,
    relative_displacement,
)
from vibsim.evidence.verification.vibrations.linear_theory import K1, conditioning, impedance
from vibsim.results import Result

LINEAR, TINY, CONSERVATIVE = "hard/a-million-seconds-linear", "hard/tiny-amplitude", "hard/conservative"
SHORTER = "1e5 s"  # what the Taylor flow does of LINEAR: three steps a period
SUBNORMAL = 2.0**-1040  # an amplitude with 34 bits left [m]
LAST_PLACE = 2.0**-1074  # of a subnormal number
CONSTANT = 1e-12  # of the energy: so far it may be off over 100,000 cycles


def checks() -> list[Check]:
    """The three cases by both flows."""
    makers = (
        (LINEAR, linear, "A linear vibration for a million seconds"),
        (TINY, tiny, "Impacts of 1e-307 m, and of subnormal ones"),
        (CONSERVATIVE, conservative, "Impacts without loss, 100,000 cycles"),
    )
    return [
        Check(f"{name}/{flow}", title, partial(rows, flow), long=name != TINY)
        for name, rows, title in makers
        for flow in BOTH
    ]


def linear(flow: str, engine: str) -> Iterator[Row]:
    """The steady state, its phase taken from the exact fraction 5.3 t of turns."""
    case = load_case(LINEAR, {"run.t_end": SHORTER} if flow == "taylor" else {})
    result = bare_run(case.two_blocks(), engine, flow)
    omega, c, force = 2 * pi * 5.3, 0.3, 0.5
    size, lag = force / impedance(omega, c), atan2(c * omega, K1 - M1 * omega**2)
    bound = size * relative_rounding(result, conditioning(omega, c), memory=2 * M1 / c)
    points = []
    for i in range(1, len(result)):
        turns = Fraction("5.3") * Fraction(float(result.time[i])) % 1
        angle = 2 * pi * float(turns) - lag
        at = f"{result.time[i]:.9g} s"
        x, v = float(result["x1"][i]), float(result["v1"][i])
        points.append(compared(f"x1 at {at}", size * np.sin(angle), x, bound, "m"))
        points.append(compared(f"v1 at {at}", omega * size * np.cos(angle), v, omega * bound, "m/s"))
    yield worst_row(f"{LINEAR}/{flow}", points, REASON)


def tiny(flow: str, engine: str) -> Iterator[Row]:
    """The amplitude of the case, and a subnormal one, which no case file may have."""
    scene = load_case(TINY).two_blocks()
    for amplitude in (scene.x1, SUBNORMAL):
        result = bare_run(replace(scene, x1=amplitude), engine, flow)
        yield from tiny_rows(f"{TINY}/{flow}", result, amplitude)


def tiny_rows(name: str, result: Result, size: float) -> Iterator[Row]:
    """Displacements and contacts of a bilinear oscillator released from x1 = `size` [m]."""
    t, y = result.time, result["x1"] - result["x2"]
    expected = size * relative_displacement(t)
    coarse = LAST_PLACE * STATE_UNITS * roundings(result)
    points = [
        compared(
            f"x1 - x2 of {size:.2g} m at {t[i]:g} s",
            expected[i],
            y[i],
            size * relative_rounding(result, FREE_RATE * t[i]) + coarse,
            "m",
        )
        for i in range(0, len(t), 10)
    ]
    yield worst_row(name, points, f"{REASON}; no finer than 2^-1074 m")
    count = contacts(result.t_reached)
    yield counted_row(name, f"impacts of {size:.2g} m", count, result.attrs["impacts"], "one in each period")


def conservative(flow: str, engine: str) -> Iterator[Row]:
    """Contacts, the time of the last one, and the energy."""
    name = f"{CONSERVATIVE}/{flow}"
    result = bare_run(load_case(CONSERVATIVE).two_blocks(), engine, flow)
    count = contacts(result.t_reached)
    begins = result.events["t"][result.events["kind"] == 1]
    yield counted_row(name, "impacts", count, len(begins), "one in each period")
    expected = contact_begin(len(begins))
    bound = time_rounding(result, expected, rate=FREE_RATE)
    yield number_row(name, compared("last impact", expected, float(begins[-1]), bound, "s"), REASON)
    values = energy(result)
    far = int(np.argmax(np.abs(values - values[0])))
    share, because = energy_bound(result)
    point = compared(f"energy at {result.time[far]:g} s", values[0], values[far], share * values[0], "J")
    yield number_row(name, point, because)


def energy_bound(result: Result) -> tuple[float, str]:
    """By what part the energy may be off, and why.

    1e-12 is demanded of the closed form, which rounds at events only. The Taylor flow rounds at every step,
    800,000 times in all; kicks of random sign add up as the square root of their number.
    """
    if result.attrs["method"] == "closed_form":
        return CONSTANT, "demanded: 1e-12 over 100,000 cycles"
    walk = 2 * STATE_UNITS * UNIT * sqrt(roundings(result))
    return LUCK * walk, "twice the random walk of 16 units per event and step; energy is quadratic"
