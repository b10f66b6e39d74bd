"""V13 and V14: orbits with one impact, their multipliers, and the fold of their family.

Between impacts the mass obeys x'' + c x' + x = A cos(w t), at the stop x = sigma its speed V is multiplied
by -e. A disturbance (dx, dv) is turned by exp(B T), with B = [[0, 1], [-1, -c]] and T from impact to impact,
and multiplied at the impact by S = [[-e, 0], [(1 + e) (A cos(phase) - sigma) / V, -e]]. So the multipliers
are the eigenvalues of S exp(B T), and their product is e^2 exp(-c T). The speed of Budd and Dux
(`oscillators`) is real as far as sigma = |gamma| sqrt(1 + (cs / r)^2): there the family turns back.
"""

from collections.abc import Callable, Iterator
from math import acos, cos, exp, hypot, pi, sin, sqrt, ulp

import numpy as np

from vibsim.evidence.verification.checks import (
    BECAUSE,
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
    worst_row,
)
from vibsim.evidence.verification.oscillators import (
    CASE,
    RECIPES,
    RECIPES_PHASE,
    RECIPES_SPEED,
    SIGMAS,
    speed_of,
)
from vibsim.evidence.verification.oscillators import OMEGA as impact_oscillators_OMEGA
from vibsim.evidence.verification.oscillators import PERIOD as impact_oscillators_PERIOD
from vibsim.evidence.verification.oscillators import STEP as impact_oscillators_STEP
from vibsim.evidence.verification.oscillators import E as impact_oscillators_E
from vibsim.evidence.verification.oscillators import orbit as impact_oscillators_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.search import orbit
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results import Result

FOLD, FOLD_PLACES = 0.34514712445281, 14  # printed
SPAN = "0.3:0.35 m"
NEWTON = 1e-13  # length of a Newton step, over the parameter at the start, that continuation stops at
RECIPES_PRODUCT, PRODUCT_PLACES = 0.341432378298, 12  # printed
DAMPING = 0.1
BOUND_OF_ORBITS = (
    "rounding of the scene x conditioning; 16 units for each factor of the derivative; digits printed"
)
BECAUSE_FOLD = "rounding of the scene x conditioning; Newton's method stops at steps of 1e-13"


def impact_orbit_checks() -> list[Check]:
    """Orbits of both oscillators, and the family of Budd and Dux."""
    return [
        Check("V13/orbit", "Budd and Dux: multipliers of orbits", orbits),
        Check("V13/fold", "Budd and Dux: the fold of the family", fold),
        Check("V14/orbit", "Recipes for Continuation 15.2: multipliers of the orbit", recipes_orbit),
    ]


def fold_of(
    k: float = 1.0,
    m: float = 1.0,
    A: float = 1.0,
    omega: float = impact_oscillators_OMEGA,
    e: float = impact_oscillators_E,
) -> float:
    """Place of the stop at the fold of the family [m], in closed form; numbers in SI."""
    w = omega / sqrt(k / m)
    T = 4 * pi / w
    cs, r = sin(T) * (1 + e) / (1 - cos(T)), (1 - e) / w
    return A / k / abs(1 - w * w) * sqrt(1 + (cs / r) ** 2)


def trace_of(
    k: float = 1.0,
    m: float = 1.0,
    A: float = 1.0,
    omega: float = impact_oscillators_OMEGA,
    e: float = impact_oscillators_E,
    sigma: float = 0.0,
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
    e: float = impact_oscillators_E,
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
        step = impact_oscillators_STEP * (abs(value) or 1.0)
        ahead, behind = (number(**{**values, name: value + sign * step}) for sign in (1, -1))
        total += abs(ahead - behind) / (2 * impact_oscillators_STEP)
    return total


def rounding_bound(size: float) -> float:
    """Rounding bound of a derivative of some size (Frobenius norm).

    STATE_UNITS each of the flow before the impact, the impact and the flow behind, twice that for flows that
    are no pure rotations.
    """
    return 2 * 3 * STATE_UNITS * UNIT * size


def multiplier_points(
    orbit: Orbit, trace: float, product: float, bound: float, where: str
) -> list[CheckPoint]:
    """Sum and product of the two multipliers; bound: of the sum, but for rounding of the derivative.

    The product changes with the derivative by no more than its size.
    """
    first, second = orbit.multipliers
    size = float(np.linalg.norm(orbit.end.derivative))
    total, both, rounding = float((first + second).real), float((first * second).real), rounding_bound(size)
    return [
        compared(f"sum of the multipliers {where}", trace, total, bound + 2 * rounding),
        compared(f"product of the multipliers {where}", product, both, size * rounding),
    ]


def orbits() -> Iterator[CheckRow]:
    """Multipliers along the family, and those printed for sigma = 0."""
    points: list[CheckPoint] = []
    for sigma in (0.0, *SIGMAS):
        values = {
            "k": 1.0,
            "m": 1.0,
            "A": 1.0,
            "omega": impact_oscillators_OMEGA,
            "e": impact_oscillators_E,
            "sigma": sigma,
        }
        bound = settled_bound(
            moved_by(trace_of, **values), impact_oscillators_PERIOD, 1, impact_oscillators_OMEGA
        )
        computed = orbit_at(sigma)
        points += multiplier_points(
            computed,
            trace_of(sigma=sigma),
            impact_oscillators_E * impact_oscillators_E,
            bound,
            f"at sigma = {sigma:g} m",
        )
    yield worst_row("V13/orbit", points, BOUND_OF_ORBITS)
    upper = max(orbit_at(0.0).multipliers, key=lambda one: float(one.imag))
    printed = [
        compared("real part of a multiplier, printed", PRINTED.real, float(upper.real), last_digit(PLACES)),
        compared("imaginary part of it, printed", PRINTED.imag, float(upper.imag), last_digit(PLACES)),
    ]
    yield worst_row("V13/orbit", printed, "the last digit printed")


def orbit_at(sigma: float) -> Orbit:
    """The orbit with the stop at sigma [m], which meets the section between its impacts."""
    case = made_case(CASE, "Budd and Dux", **between_impacts(sigma))
    start = {f"{name}_mass": case.number(f"initial.mass.{name}") for name in "xv"}
    return orbit(case, start=start, period=2)


def fold() -> Iterator[CheckRow]:
    """The family followed from sigma = 0.3 m through its fold and back: where that is, and the product of the
    multipliers of every orbit on the way.
    """
    family = continue_branch(orbit_at(SIGMAS[-1]), "stops.wall.gap", SPAN)
    turn = float(family.special("F1").parameter)
    values = {"k": 1.0, "m": 1.0, "A": 1.0, "omega": impact_oscillators_OMEGA, "e": impact_oscillators_E}
    bound = (
        settled_bound(moved_by(fold_of, **values), impact_oscillators_PERIOD, 1, impact_oscillators_OMEGA)
        + NEWTON * SIGMAS[-1]
    )
    points = [
        compared("sigma at the fold, printed", FOLD, turn, bound + last_digit(FOLD_PLACES), "m"),
        compared("sigma at the fold, closed form", fold_of(), turn, bound, "m"),
    ]
    for point in points:
        yield number_row("V13/fold", point, BECAUSE_FOLD)
    products = []
    for sigma, multipliers in zip(family["parameter"], family["multipliers"], strict=True):
        total = float(multipliers.sum().real)
        off_diagonal = (total + 2 * impact_oscillators_E * cos(impact_oscillators_PERIOD)) / sin(
            impact_oscillators_PERIOD
        )  # of S, by the trace of S exp(B T)
        size = float(np.hypot(sqrt(2) * impact_oscillators_E, off_diagonal))
        product = float(multipliers.prod().real)
        what = f"product of the multipliers at sigma = {sigma:g} m"
        products.append(
            compared(what, impact_oscillators_E * impact_oscillators_E, product, size * rounding_bound(size))
        )
    yield worst_row("V13/fold", products, BOUND_OF_ORBITS)


def recipes_orbit() -> Iterator[CheckRow]:
    """Multipliers at A = 1 from the printed speed and phase of the impact, and their product as printed."""
    computed = orbit(made_case(CASE, "example 15.2", **RECIPES))
    values = {
        "V": RECIPES_SPEED,
        "phase": RECIPES_PHASE,
        "A": 1.0,
        "c": DAMPING,
        "e": impact_oscillators_E,
        "sigma": 1.0,
    }
    digits = last_digit(15) * moved_by(recipes_trace, V=RECIPES_SPEED) / RECIPES_SPEED
    digits += last_digit(13) * moved_by(recipes_trace, phase=RECIPES_PHASE) / RECIPES_PHASE
    bound = settled_bound(moved_by(recipes_trace, **values), 2 * pi, 1) + digits
    closed = impact_oscillators_E * impact_oscillators_E * exp(-2 * pi * DAMPING)
    points = multiplier_points(computed, recipes_trace(), closed, bound, "at A = 1 N")
    yield worst_row("V14/orbit", points, BOUND_OF_ORBITS)
    what = "product of the multipliers, printed"
    bound = points[1].bound + last_digit(PRODUCT_PLACES)
    yield number_row("V14/orbit", compared(what, RECIPES_PRODUCT, points[1].obtained, bound), BOUND_OF_ORBITS)


# V15: a ball on a floor, and on a table s = a sin(w t), restitution e, g = 9.81 m/s^2: closed forms.
#
# Dropped from h it rests after sqrt(2 h / g) (1 + e) / (1 - e). On the table it bounces once a period,
# w T = 2 pi, with (g T / 2) (1 - e) / (1 + e) = a w cos(w t) at the impact; these motions are born at
# a w^2 / g = pi (1 - e) / (1 + e) and double their period at
# a w^2 / g = sqrt((pi (1 - e) / (1 + e))^2 + (2 (1 + e^2) / (1 + e)^2)^2), which Holmes (1982) gives for a
# table that hardly moves; with e = 0.8 at 1.070836468247907.


GRAVITY = 9.81
DROPPED = """
bodies: {ball: 1 kg}
forces: {weight: {on: ball, A: 0 N, omega: 1 Hz, F0: -9.81 N}}
stops: {floor: {between: [ground, ball], gap: 0 m, acts: compression, law: rigid, e: 0.8}}
initial: {ball: {x: 1 m}}
run: {t_end: 5 s, every: 0.1 s}
"""
TABLE = """
bodies: {ball: 1 kg}
forces: {weight: {on: ball, A: 0 N, omega: 1 Hz, F0: -9.81 N}}
stops: {table: {between: [base, ball], gap: 0 m, acts: compression, law: rigid, e: 0.8}}
base: {a: 1 mm, omega: 10 Hz}
run: {t_end: 20 s, every: 1 s}
"""
E, OMEGA = 0.8, 20 * pi
PERIOD = 2 * pi / OMEGA
BORN = pi * (1 - E) / (1 + E)  # a w^2 / g
DOUBLED = hypot(BORN, 2 * (1 + E * E) / (1 + E) ** 2)
BOUNCES = 60


def bouncing_ball_checks() -> list[Check]:
    """The ball that comes to rest, and the one that bounces once a period."""
    return [
        Check("V15/rest", "A dropped ball comes to rest", rest),
        Check("V15/bounces", "A ball bounces once a period of the table", bounces),
        Check("V15/doubling", "Where bounces of one period become those of two", doubling),
    ]


def rest() -> Iterator[CheckRow]:
    """Time of rest, speeds of the impacts on the way, and rest itself."""
    ends, speeds, moves = [], [], []
    for e in (0.2, 0.5, 0.8):
        end = sqrt(2 / GRAVITY) * (1 + e) / (1 - e)
        result = run(made_case(DROPPED, "dropped ball", stops__floor__e=e))
        rested = result.events["t"][result.events["kind"] == EVENT_KINDS["rest_begin"]]
        bound = rest_bound(result, end, e)
        ends.append(compared(f"rest with e = {e:g}", end, float(rested[0]), bound, "s"))
        speeds += speed_points(result, e, end)
        after = result["x_ball"][result.time > rested[0]]
        moves.append(compared(f"height after rest with e = {e:g}", 0.0, float(np.abs(after).max()), 0.0, "m"))
    because = (
        "half a unit of t per impact and 1 / (1 - e) of it by the speed, 16 units of speed, what was cut off"
    )
    yield worst_row("V15/rest", ends, because)
    yield worst_row("V15/rest", speeds, "16 units and g half a unit of t per impact")
    yield worst_row("V15/rest", moves, "it stays: its height does not change in one bit")


def rest_bound(result: Result, end: float, e: float) -> float:
    """An impact late by half a unit of t strikes g times that faster, and all flights behind it with it."""
    grid = ulp(end) * (0.5 + 1 / (1 - e)) * result.attrs["impacts"]
    rounding = SCENE_UNITS * (1 + 2 / (1 - e * e)) + STATE_UNITS / (1 - e)
    return float(grid + end * UNIT * rounding + result.attrs["chatter_time"])


def speed_points(result: Result, e: float, end: float) -> list[CheckPoint]:
    """Impact n = 0, 1, ... at e^n sqrt(2 g h)."""
    hits = result.events["before_v_ball"][result.events["kind"] == EVENT_KINDS["impact"]]
    first, late = sqrt(2 * GRAVITY), GRAVITY * ulp(end) / 2
    return [
        compared(
            f"speed of impact {n + 1} with e = {e:g}",
            first * e**n,
            -float(v),
            (n + 1) * first * e**n * UNIT * (SCENE_UNITS + STATE_UNITS) + late / (1 - e),
            "m/s",
        )
        for n, v in enumerate(hits)
    ]


def start_on_orbit(strength: float, push: float = 0.0) -> dict[str, object]:
    """A run that starts behind an impact of the motion of one bounce a period, a w^2 / g = `strength`.

    push : relative change of the velocity at the start
    """
    a, phase = strength * GRAVITY / OMEGA**2, acos(BORN / strength)
    return {
        "base__a": a,
        "base__phase": phase,
        "initial__ball__x": a * sin(phase),
        "initial__ball__v": GRAVITY * PERIOD / 2 * (1 + push),
        "run__t_end": (BOUNCES + 0.5) * PERIOD,
        "run__every": "0.1 s",
    }


def intervals(result: Result) -> np.ndarray:
    """Times between impacts [s]."""
    return np.diff(result.events["t"][result.events["kind"] == EVENT_KINDS["impact"]])


def bounces() -> Iterator[CheckRow]:
    """Between birth and doubling the ball meets the table with g T / 2 in each period."""
    points, counts = [], 0
    for strength in (0.5, 0.8, 1.0):
        result = run(made_case(TABLE, "ball on a table", **start_on_orbit(strength)))
        hits = result.events["before_v_ball"][result.events["kind"] == EVENT_KINDS["impact"]]
        counts += len(hits)
        speed, bound = GRAVITY * PERIOD / 2, orbit_bound(strength, result)
        points += [
            compared(f"speed at a w^2 / g = {strength:g}", -speed, float(v), bound, "m/s") for v in hits
        ]
    yield worst_row("V15/bounces", points, BECAUSE)
    yield counted_row("V15/bounces", "bounces in 3 x 60 periods", 3 * BOUNCES, counts, "one in each period")


def orbit_bound(strength: float, result: Result) -> float:
    """Bound of the speed; the orbit depends on the phase, cos = BORN / strength, by 1 / sin of it.

    A change of the scene moves the speed by as much times the numbers g, a, w, e, of which e counts
    2 e / (1 - e^2), and the phase by cot; what is moved is forgotten like e^n: det of the multipliers is e^2.
    """
    steep = 1 / sin(acos(BORN / strength))
    conditioning = GRAVITY * PERIOD / 2 * (4 + 2 * E / (1 - E * E)) * steep / (1 - E)
    return settled_bound(conditioning, result.t_reached, 1, OMEGA)


def doubling() -> Iterator[CheckRow]:
    """A small push dies out below the doubling, and grows above it as jumps to and fro."""
    wrong = 0
    for part in (0.03, 0.01):
        for sign in (-1, 1):
            settings = start_on_orbit(DOUBLED * (1 + sign * part), push=1e-4)
            settings["run__t_end"] = 200.5 * PERIOD
            apart = intervals(run(made_case(TABLE, "ball on a table", **settings))) - PERIOD
            first, last = np.abs(apart[20:30]).max(), np.abs(apart[-10:]).max()
            wrong += int((last > first) != (sign > 0))
            wrong += int(sign > 0 and not np.all(apart[-10:-1] * apart[-9:] < 0))
    because = f"a w^2 / g 1 % and 3 % below and above {DOUBLED:.15g}: closed form"
    yield counted_row("V15/doubling", "runs that go the wrong way", 0, wrong, because)


# V13: multipliers of the motion of Budd and Dux, from runs that start beside it.
#
# The derivative of the state after two periods by the state at the start, by difference quotients: in it,
# impacts count as they happen in runs. Its determinant is e^2, whatever sigma: no damping, one impact.


PRINTED, PLACES = 0.44251655 + 0.66646763j, 8  # at sigma = 0
AWAY = 0.4 * impact_oscillators_PERIOD  # from the impact to the start [s]
STEP = 1e-4  # of the start [m], [m/s]
BOUND_OF_MULTIPLIERS = (
    "third of what half the step changes, 16 units per event over the step, the last digit printed"
)


def impact_multiplier_checks() -> list[Check]:
    """One check."""
    return [Check("V13/multipliers", "Budd and Dux: multipliers", multipliers)]


def multipliers() -> Iterator[CheckRow]:
    """Both multipliers at sigma = 0, as printed, and their product along the family."""
    points = []
    for sigma in (0.0, *SIGMAS):
        coarse, fine = (monodromy(sigma, step) for step in (STEP, STEP / 2))
        best = fine + (fine - coarse) / 3  # the error of the fourth order in the step is left
        rounding = float(np.abs(fine - coarse).max()) / 3 + 4 * STATE_UNITS * UNIT / STEP
        multiplier = max(np.linalg.eigvals(best), key=lambda one: one.imag)
        if sigma == 0:
            bound = 2 * rounding / abs(2 * multiplier.imag) + last_digit(PLACES)
            for what, expected, value in (
                ("real part of the multipliers", PRINTED.real, multiplier.real),
                ("imaginary part of the multipliers", PRINTED.imag, multiplier.imag),
            ):
                points.append(compared(what, expected, float(value), bound))
        bound = 4 * float(np.abs(best).max()) * rounding
        what = f"product of the multipliers at sigma = {sigma:g} m"
        points.append(
            compared(what, impact_oscillators_E * impact_oscillators_E, float(np.linalg.det(best)), bound)
        )
    yield worst_row("V13/multipliers", points, BOUND_OF_MULTIPLIERS)


def monodromy(sigma: float, step: float) -> np.ndarray:
    """d (x, v) two periods later / d (x, v), by central differences."""
    columns = []
    for direction in np.eye(2):
        ahead, behind = (carried(sigma, sign * step * direction) for sign in (1, -1))
        columns.append((ahead - behind) / (2 * step))
    return np.transpose(columns)


def carried(sigma: float, push: np.ndarray) -> np.ndarray:
    """x [m] and v [m/s] two periods after a start `push` beside the motion, AWAY behind an impact."""
    result = run(made_case(CASE, "Budd and Dux", **between_impacts(sigma, *push.tolist())))
    return np.array([result.events["x_mass"][-1], result.events["v_mass"][-1]])


def between_impacts(sigma: float, dx: float = 0.0, dv: float = 0.0) -> dict[str, object]:
    """A run of two periods that starts AWAY behind an impact, dx [m] and dv [m/s] beside the motion."""
    a, b, gamma, phase = impact_oscillators_orbit(sigma)
    turned = impact_oscillators_OMEGA * AWAY + phase
    x = a * cos(AWAY) + b * sin(AWAY) + gamma * cos(turned)
    v = -a * sin(AWAY) + b * cos(AWAY) - gamma * impact_oscillators_OMEGA * sin(turned)
    return {
        "stops__wall__gap": sigma,
        "initial__mass__x": x + dx,
        "initial__mass__v": v + dv,
        "forces__drive__phase": turned + pi / 2,
        "run__t_end": impact_oscillators_PERIOD,
        "run__every": "1 s",
    }
