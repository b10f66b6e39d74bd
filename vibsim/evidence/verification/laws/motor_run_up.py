"""V9: the motor on a block that does not move runs up exponentially.

(J + m3 e^2) w' = M0 (1 - w / Omega0), so w = Omega0 + (w0 - Omega0) exp(-t / tau) with
tau = Omega0 (J + m3 e^2) / M0.
"""

from collections.abc import Iterator
from math import pi

import numpy as np

from vibsim.evidence.verification.bounds.rounding import REASON, relative_rounding
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, worst_row
from vibsim.evidence.verification.runs import made_case, run

HEAVY = """
blocks: {m1: 1e30 kg, m2: fixed}
coupling: {k1: 0 N/m}
excitation: {kind: motor, m3: 0.03 kg, e: 0.11 m, J: 0.001 kg m^2, M0: 0.005 N m, Omega0: 5.5 Hz}
initial: {phi: 0.3 rad}
run: {t_end: 60 s, every: 0.5 s}
"""
OMEGA0 = 2 * pi * 5.5
TAU = OMEGA0 * (0.001 + 0.03 * 0.11**2) / 0.005


def checks() -> list[Check]:
    """V9."""
    return [Check("V9/taylor", "Run-up of the motor alone", rows)]


def rows(engine: str) -> Iterator[Row]:
    """Speed and angle from three speeds at the start."""
    speeds, angles = [], []
    for start in (0.0, -20.0, 50.0):
        result = run(made_case(HEAVY, "motor alone", initial__phidot=f"{start} rad/s"), engine)
        t = result.time
        decay = np.exp(-t / TAU)
        w = OMEGA0 + (start - OMEGA0) * decay
        phi = 0.3 + OMEGA0 * t + (start - OMEGA0) * TAU * (1 - decay)
        rounded = relative_rounding(result, 3, memory=TAU)
        for i in range(0, len(t), 10):
            at = f"{t[i]:g} s from {start:g} rad/s"
            speeds.append(
                compared(f"speed at {at}", w[i], float(result["phidot"][i]), OMEGA0 * rounded, "rad/s")
            )
            bound = max(1.0, OMEGA0 * t[i]) * rounded
            angles.append(compared(f"angle at {at}", phi[i], float(result["phi"][i]), bound, "rad"))
    yield worst_row("V9/taylor", speeds, REASON)
    yield worst_row("V9/taylor", angles, REASON)
