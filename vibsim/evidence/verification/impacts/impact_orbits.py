"""V13 and V14: orbits with one impact, their multipliers, and the fold of their family.

Between impacts the mass obeys x'' + c x' + x = A cos(w t), at the stop x = sigma its speed V is multiplied
by -e. A disturbance (dx, dv) is turned by exp(B T), with B = [[0, 1], [-1, -c]] and T from impact to impact,
and multiplied at the impact by S = [[-e, 0], [(1 + e) (A cos(phase) - sigma) / V, -e]]. So the multipliers
are the eigenvalues of S exp(B T), and their product is e^2 exp(-c T). The speed of Budd and Dux
(`impact_oscillators`) is real as far as sigma = |gamma| sqrt(1 + (cs / r)^2): there the family turns back.
"""

from collections.abc import Callable, Iterator
from math import cos, exp, pi, sin, sqrt

import numpy as np

from vibsim.branches import continue_branch
from vibsim.evidence.verification.bounds.kicks import STATE_UNITS, UNIT
from vibsim.evidence.verification.bounds.settled import last_digit, settled_bound
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.impacts.impact_multipliers import PLACES, PRINTED, between_impacts
from vibsim.evidence.verification.impacts.impact_oscillators import (
    CASE,
    OMEGA,
    PERIOD,
    RECIPES,
    RECIPES_PHASE,
    RECIPES_SPEED,
    SIGMAS,
    STEP,
    E,
    speed_of,
)
from vibsim.evidence.verification.row import Point, Row, compared, number_row, worst_row
from vibsim.evidence.verification.runs import made_case
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.search.seeking import orbit

FOLD, FOLD_PLACES = 0.34514712445281, 14  # printed
SPAN = "0.3:0.35 m"
NEWTON = 1e-13  # length of a Newton step, over the parameter at the start, that continuation stops at
RECIPES_PRODUCT, PRODUCT_PLACES = 0.341432378298, 12  # printed
DAMPING = 0.1
BECAUSE = "rounding of the scene x conditioning; 16 units for each factor of the derivative; digits printed"
BECAUSE_FOLD = "rounding of the scene x conditioning; Newton's method stops at steps of 1e-13"


def checks() -> list[Check]:
    """Orbits of both oscillators, and the family of Budd and Dux."""
    return [
        Check("V13/orbit", "Budd and Dux: multipliers of orbits", orbits),
        Check("V13/fold", "Budd and Dux: the fold of the family", fold),
        Check("V14/orbit", "Recipes for Continuation 15.2: multipliers of the orbit", recipes_orbit),
    ]


def fold_of(k: float = 1.0, m: float = 1.0, A: float = 1.0, omega: float = OMEGA, e: float = E) -> float:
    """Place of the stop at the fold of the family [m], in closed form; numbers in SI."""
    w = omega / sqrt(k / m)
    T = 4 * pi / w
    cs, r = sin(T) * (1 + e) / (1 - cos(T)), (1 - e) / w
    return A / k / abs(1 - w * w) * sqrt(1 + (cs / r) ** 2)


def trace_of(
    k: float = 1.0, m: float = 1.0, A: float = 1.0, omega: float = OMEGA, e: float = E, sigma: float = 0.0
) -> float:
    """Sum of the multipliers of an orbit of Budd and Dux, in closed form; numbers in SI."""
    own = sqrt(k / m)
    w, s = omega / own, sigma * k / A
    V, T = speed_of(k, m, A, omega, e, sigma) * k / (A * own), 4 * pi / w
    # x = a cos t + b sin t + gamma cos(w t + phase) behind an impact, in units of 1 / own and A / k
    a = -(1 + e) * V * sin(T) / (2 * (1 - cos(T)))
    force = (s - a) * (1 - w * w) - s
    return float(np.trace(impact_matrix(e, force, V) @ flow_matrix(0.0, T)))


def recipes_trace(
    V: float = RECIPES_SPEED,
    phase: float = RECIPES_PHASE,
    A: float = 1.0,
    c: float = DAMPING,
    e: float = E,
    sigma: float = 1.0,
) -> float:
    """Sum of the multipliers of example 15.2, from the speed [m/s] and phase [rad] of its impact."""
    return float(np.trace(impact_matrix(e, A * cos(phase) - sigma, V) @ flow_matrix(c, 2 * pi)))


def impact_matrix(e: float, force: float, V: float) -> np.ndarray:
    """S of an impact with the speed V [m/s] under the force A cos(phase) - sigma [N] on 1 kg."""
    return np.array([[-e, 0.0], [(1 + e) * force / V, -e]])


def flow_matrix(c: float, T: float) -> np.ndarray:
    """exp(B T) of x'' + c x' + x = 0, c < 2."""
    a = c / 2
    w = sqrt(1 - a * a)
    s = sin(w * T) / w
    return exp(-a * T) * np.array([[cos(w * T) + a * s, s], [-s, cos(w * T) - a * s]])


def moved_by(number: Callable[..., float], **values: float) -> float:
    """Sum of |p dq/dp| of a number over what it depends on, |dq/dp| of p = 0, by difference quotients."""
    total = 0.0
    for name, value in values.items():
        step = STEP * (abs(value) or 1.0)
        ahead, behind = (number(**{**values, name: value + sign * step}) for sign in (1, -1))
        total += abs(ahead - behind) / (2 * STEP)
    return total


def blur_of(size: float) -> float:
    """What rounding may do to a derivative of some size (Frobenius norm).

    STATE_UNITS each of the flow before the impact, the impact and the flow behind, twice that for flows that
    are no pure rotations.
    """
    return 2 * 3 * STATE_UNITS * UNIT * size


def multiplier_points(orbit: Orbit, trace: float, product: float, bound: float, where: str) -> list[Point]:
    """Sum and product of the two multipliers; bound: of the sum, but for rounding of the derivative.

    The product changes with the derivative by no more than its size.
    """
    first, second = orbit.multipliers
    size = float(np.linalg.norm(orbit.end.derivative))
    total, both, blur = float((first + second).real), float((first * second).real), blur_of(size)
    return [
        compared(f"sum of the multipliers {where}", trace, total, bound + 2 * blur),
        compared(f"product of the multipliers {where}", product, both, size * blur),
    ]


def orbits(engine: str) -> Iterator[Row]:
    """Multipliers along the family, and those printed for sigma = 0."""
    points: list[Point] = []
    for sigma in (0.0, *SIGMAS):
        values = {"k": 1.0, "m": 1.0, "A": 1.0, "omega": OMEGA, "e": E, "sigma": sigma}
        bound = settled_bound(moved_by(trace_of, **values), PERIOD, 1, OMEGA)
        computed = orbit_at(sigma, engine)
        points += multiplier_points(computed, trace_of(sigma=sigma), E * E, bound, f"at sigma = {sigma:g} m")
    yield worst_row("V13/orbit", points, BECAUSE)
    upper = max(orbit_at(0.0, engine).multipliers, key=lambda one: float(one.imag))
    printed = [
        compared("real part of a multiplier, printed", PRINTED.real, float(upper.real), last_digit(PLACES)),
        compared("imaginary part of it, printed", PRINTED.imag, float(upper.imag), last_digit(PLACES)),
    ]
    yield worst_row("V13/orbit", printed, "the last digit printed")


def orbit_at(sigma: float, engine: str) -> Orbit:
    """The orbit with the stop at sigma [m], which meets the section between its impacts."""
    case = made_case(CASE, "Budd and Dux", **between_impacts(sigma))
    start = {f"{name}_mass": case.number(f"initial.mass.{name}") for name in "xv"}
    return orbit(case, start=start, period=2, engine=engine)


def fold(engine: str) -> Iterator[Row]:
    """The family followed from sigma = 0.3 m through its fold and back: where that is, and the product of the
    multipliers of every orbit on the way.
    """
    family = continue_branch(orbit_at(SIGMAS[-1], engine), "stops.wall.gap", SPAN, engine=engine)
    turn = float(family.special("F1").parameter)
    values = {"k": 1.0, "m": 1.0, "A": 1.0, "omega": OMEGA, "e": E}
    bound = settled_bound(moved_by(fold_of, **values), PERIOD, 1, OMEGA) + NEWTON * SIGMAS[-1]
    points = [
        compared("sigma at the fold, printed", FOLD, turn, bound + last_digit(FOLD_PLACES), "m"),
        compared("sigma at the fold, closed form", fold_of(), turn, bound, "m"),
    ]
    for point in points:
        yield number_row("V13/fold", point, BECAUSE_FOLD)
    products = []
    for sigma, multipliers in zip(family["parameter"], family["multipliers"], strict=True):
        total = float(multipliers.sum().real)
        off_diagonal = (total + 2 * E * cos(PERIOD)) / sin(PERIOD)  # of S, by the trace of S exp(B T)
        size = float(np.hypot(sqrt(2) * E, off_diagonal))
        product = float(multipliers.prod().real)
        what = f"product of the multipliers at sigma = {sigma:g} m"
        products.append(compared(what, E * E, product, size * blur_of(size)))
    yield worst_row("V13/fold", products, BECAUSE)


def recipes_orbit(engine: str) -> Iterator[Row]:
    """Multipliers at A = 1 from the printed speed and phase of the impact, and their product as printed."""
    computed = orbit(made_case(CASE, "example 15.2", **RECIPES), engine=engine)
    values = {"V": RECIPES_SPEED, "phase": RECIPES_PHASE, "A": 1.0, "c": DAMPING, "e": E, "sigma": 1.0}
    digits = last_digit(15) * moved_by(recipes_trace, V=RECIPES_SPEED) / RECIPES_SPEED
    digits += last_digit(13) * moved_by(recipes_trace, phase=RECIPES_PHASE) / RECIPES_PHASE
    bound = settled_bound(moved_by(recipes_trace, **values), 2 * pi, 1) + digits
    closed = E * E * exp(-2 * pi * DAMPING)
    points = multiplier_points(computed, recipes_trace(), closed, bound, "at A = 1 N")
    yield worst_row("V14/orbit", points, BECAUSE)
    what = "product of the multipliers, printed"
    bound = points[1].bound + last_digit(PRODUCT_PLACES)
    yield number_row("V14/orbit", compared(what, RECIPES_PRODUCT, points[1].obtained, bound), BECAUSE)
