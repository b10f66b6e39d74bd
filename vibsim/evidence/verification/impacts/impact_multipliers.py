"""V13: multipliers of the motion of Budd and Dux, from runs that start beside it.

The derivative of the state after two periods by the state at the start, by difference quotients: in it,
impacts count as they happen in runs. Its determinant is e^2, whatever sigma: no damping, one impact.
"""

from collections.abc import Iterator
from math import cos, pi, sin

import numpy as np

from vibsim.evidence.verification.bounds.kicks import STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.settled import last_digit
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.impacts.impact_oscillators import (
    CASE,
    OMEGA,
    PERIOD,
    SIGMAS,
    E,
    orbit,
)
from vibsim.evidence.verification.row import Row, compared, worst_row
from vibsim.evidence.verification.runs import made_case, run

PRINTED, PLACES = 0.44251655 + 0.66646763j, 8  # at sigma = 0
AWAY = 0.4 * PERIOD  # from the impact to the start [s]
STEP = 1e-4  # of the start [m], [m/s]
BECAUSE = "third of what half the step changes, 16 units per event over the step, the last digit printed"


def checks() -> list[Check]:
    """One check."""
    return [Check("V13/multipliers", "Budd and Dux: multipliers", multipliers)]


def multipliers(engine: str) -> Iterator[Row]:
    """Both multipliers at sigma = 0, as printed, and their product along the family."""
    points = []
    for sigma in (0.0, *SIGMAS):
        coarse, fine = (monodromy(sigma, step, engine) for step in (STEP, STEP / 2))
        best = fine + (fine - coarse) / 3  # the error of the fourth order in the step is left
        blur = float(np.abs(fine - coarse).max()) / 3 + 4 * STATE_UNITS * UNIT / STEP
        multiplier = max(np.linalg.eigvals(best), key=lambda one: one.imag)
        if sigma == 0:
            bound = 2 * blur / abs(2 * multiplier.imag) + last_digit(PLACES)
            for what, expected, value in (
                ("real part of the multipliers", PRINTED.real, multiplier.real),
                ("imaginary part of the multipliers", PRINTED.imag, multiplier.imag),
            ):
                points.append(compared(what, expected, float(value), bound))
        bound = 4 * float(np.abs(best).max()) * blur
        what = f"product of the multipliers at sigma = {sigma:g} m"
        points.append(compared(what, E * E, float(np.linalg.det(best)), bound))
    yield worst_row("V13/multipliers", points, BECAUSE)


def monodromy(sigma: float, step: float, engine: str) -> np.ndarray:
    """d (x, v) two periods later / d (x, v), by central differences."""
    columns = []
    for direction in np.eye(2):
        ahead, behind = (carried(sigma, sign * step * direction, engine) for sign in (1, -1))
        columns.append((ahead - behind) / (2 * step))
    return np.transpose(columns)


def carried(sigma: float, push: np.ndarray, engine: str) -> np.ndarray:
    """x [m] and v [m/s] two periods after a start `push` beside the motion, AWAY behind an impact."""
    result = run(made_case(CASE, "Budd and Dux", **between_impacts(sigma, *push.tolist())), engine)
    return np.array([result.events["x_mass"][-1], result.events["v_mass"][-1]])


def between_impacts(sigma: float, dx: float = 0.0, dv: float = 0.0) -> dict[str, object]:
    """A run of two periods that starts AWAY behind an impact, dx [m] and dv [m/s] beside the motion."""
    a, b, gamma, phase = orbit(sigma)
    turned = OMEGA * AWAY + phase
    x = a * cos(AWAY) + b * sin(AWAY) + gamma * cos(turned)
    v = -a * sin(AWAY) + b * cos(AWAY) - gamma * OMEGA * sin(turned)
    return {
        "stops__wall__gap": sigma,
        "initial__mass__x": x + dx,
        "initial__mass__v": v + dv,
        "forces__drive__phase": turned + pi / 2,
        "run__t_end": PERIOD,
        "run__every": "1 s",
    }
