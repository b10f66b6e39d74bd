"""V17: x'' + 0.1 x' + x = 1.5 cos(0.9 t) - friction, 1 N while slipping and 1.1 N while sticking.

Parameters of the friction demo of PWSDDE-cont: a symmetric orbit without sticking, whose amplitude is an
independent solver's; Den Hartog (1931) has it in closed form.
"""

from collections.abc import Iterator

import numpy as np

from vibsim.evidence.verification.bounds.settled import BECAUSE, last_digit, settled_bound
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, counted_row, worst_row
from vibsim.evidence.verification.runs import made_case, run
from vibsim.physics.modes import EVENT_KINDS

# the damper alone takes a factor e in 20 s: the start has fallen to 6e-16 of itself by 700 s
CASE = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 1 N/m, c: 0.1 N s/m}}
friction: {floor: {between: [mass, ground], N: 1 N, mu: 1, static: 1.1}}
forces: {drive: {on: mass, A: 1.5 N, omega: 0.9 rad/s, phase: 90 deg}}
initial: {mass: {v: 5 m/s}}
run: {t_end: 800 s, every: 100 s}
"""
AMPLITUDE, PLACES = 2.42023635057437, 14
CONDITIONING = 27.0  # sum of |p dX/dp| over m, k, c, N, A, omega by difference quotients [m]
TURNS = 10


def checks() -> list[Check]:
    """One check."""
    return [Check("V17/amplitude", "Friction oscillator: symmetric orbit without sticking", amplitude)]


def amplitude(engine: str) -> Iterator[Row]:
    """Places of the last turns, and no stick."""
    name = "V17/amplitude"
    result = run(made_case(CASE, "friction oscillator"), engine)
    turning = result.events["kind"] == EVENT_KINDS["reversal"]
    places = result.events["x_mass"][turning][-TURNS:]
    bound = settled_bound(CONDITIONING, result.t_reached, 2)
    points = [
        compared("amplitude", AMPLITUDE, abs(float(x)), bound + last_digit(PLACES), "m") for x in places
    ]
    yield worst_row(name, points, BECAUSE)
    sticks = int(np.sum(result.events["kind"] == EVENT_KINDS["stick_begin"]))
    yield counted_row(name, "sticks", 0, sticks, "the mass turns at once")
