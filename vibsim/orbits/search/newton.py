"""Newton's method for orbits, guarded: damped where a step makes it worse, and T never far from what it was.

The step solves (I - dP/dX) s = P(X) - X. The next start is taken as P(X) + dP/dX s, which is X + s: so what
the motion has forgotten, as behind a stick, comes from the image, and a body that sticks across the section
sticks there to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, isnan

import numpy as np

from vibsim.cases.number import number
from vibsim.engine.errors import EngineError
from vibsim.orbits.errors import NotConverged, OrbitError
from vibsim.orbits.matrices import dot, least_squares, product, solved_by_pivots
from vibsim.orbits.returns.return_map import Return, ReturnMap

STEPS, HALVINGS = 40, 12
EPS = 2.0**-53
# A motion of some hundred operations per event, each rounded to EPS of its size, and what the derivative
# makes of them: rounding of P(X) - X.
OPERATIONS = 128
SINGULAR = 1e-9  # of the largest singular value of I - dP/dX: below, the equation says nothing on a direction
NEARLY, GOOD = 1e-3, 0.1  # the same, but for what is left of it nearby; by so much a step must help
CLOSE = 1e-6  # of the size of the motion at its end: no rounding is as large
STAGNANT = 16  # times the tolerance: a residual that no step makes smaller is rounding still


@dataclass(frozen=True)
class Solution:
    """A fixed point of a return map.

    end : the motion from it over one period of the orbit
    steps : Newton steps that it took
    tolerance : rounding of the residual [m/s, as weighed]; `end.residual` is not far above it
    """

    end: Return
    steps: int
    tolerance: float

    @property
    def X(self) -> np.ndarray:
        return self.end.X

    @property
    def T(self) -> float:
        return self.end.T


def solve(return_map: ReturnMap, X: np.ndarray, T: float | None = None, steps: int = STEPS) -> Solution:
    """The fixed point of `return_map` near the unknowns X, and near the time of return T [s] where it
    is free.

    Returns a `Solution`. Raises NotConverged, OrbitError.
    """
    end = _first(return_map, X, T)
    for taken in range(steps + 1):
        bound = _bound(end)
        if end.residual <= bound:
            return Solution(end, taken, bound)
        nearer = _next(return_map, end)
        if nearer is None and end.residual <= STAGNANT * tolerance(end):
            return Solution(end, taken, tolerance(end))
        if nearer is None:
            break
        end = nearer
    raise _failure(return_map, end, taken)


def _first(return_map: ReturnMap, X: np.ndarray, T: float | None) -> Return:
    """The motion from the start."""
    try:
        end = return_map(X, T)
    except EngineError as error:
        raise NotConverged(f"the motion from the start of Newton's method fails: {error}", np.inf) from error
    if end.stands_still:
        raise NotConverged(
            "the start of Newton's method does not come back to the section: what should turn round there "
            f"stands still after {end.T:.6g} s; {_remedy(end)}",
            np.inf,
        )
    if not _has_derivative(end):
        raise NotConverged(
            "the motion from the start of Newton's method has no derivative: at "
            f"{end.carried.undefined_at:.6g} s it grazes a rigid stop or strikes several at one instant; "
            "start a little beside it",
            end.residual,
        )
    return end


def _remedy(end: Return) -> str:
    """What to do where a motion has come to rest."""
    if any(friction.belt for friction in end.coordinates.scene.frictions):
        return "start from a run that has settled more"
    return "nothing feeds this scene, which comes to rest in the end; drive it, or take its losses out"


def _has_derivative(end: Return) -> bool:
    """Whether small disturbances of the start make small ones of the end."""
    return not end.stands_still and isfinite(end.residual) and isnan(end.carried.undefined_at)


def _bound(end: Return) -> float:
    """The tolerance; 0 for a motion so far from closing that it does not matter."""
    return tolerance(end) if end.residual <= CLOSE * end.coordinates.size(end.image) else 0.0


def _failure(return_map: ReturnMap, end: Return, steps: int) -> NotConverged:
    periods = f"{return_map.n} period{'s' * (return_map.n > 1)}"
    return NotConverged(
        f"no orbit of {periods} near the start: Newton's method came to a residual of "
        f"{number(end.residual, 2)} m/s after {steps} steps; start from a run that has settled more, "
        "or an orbit at a parameter nearby",
        end.residual,
    )


def tolerance(end: Return) -> float:
    """Rounding of the residual of a motion [m/s, as weighed]."""
    at = end.coordinates
    gain = max(1.0, float(np.abs(end.flow_matrix * at.ratios).max()))
    size = max(at.size(end.X), at.size(end.image), at.travel(end.carried))
    return OPERATIONS * EPS * gain * size


def newton_step(end: Return, cut: float | None = None) -> tuple[np.ndarray, float]:
    """(change of X, change of T) that make the linearised map a fixed point.

    cut : leave out directions whose singular value is below so much of the largest, where it is given
    """
    at, tilt = end.coordinates, end.tilt
    matrix, right = at.one - end.derivative, end.difference
    if tilt is not None:
        right = right - end.rate * (end.ahead / tilt[1])
    scaled = matrix * at.ratios
    if cut is None:
        change = _solved(scaled, right * at.weights) / at.weights
    else:
        change = least_squares(scaled, right * at.weights, cut) / at.weights
    if tilt is None:
        return change, 0.0
    slopes, rate = tilt
    return change, -(end.ahead + dot(slopes, change)) / rate


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solution of matrix x = right; the shortest one where the matrix is singular."""
    change, pivots = solved_by_pivots(matrix, right)
    return change if pivots else least_squares(matrix, right, SINGULAR)


def _next(return_map: ReturnMap, end: Return) -> Return | None:
    """The motion after one step, damped where it must be; None where no step makes it better.

    A step far along a direction that is nearly singular, as beside a family of orbits, is tried without that
    direction first.
    """
    change, longer = newton_step(end)
    if end.coordinates.size(change) * NEARLY > end.residual:
        short, later = newton_step(end, NEARLY)
        after = _motion(return_map, _moved(end, short, later), end.T + later) if later > -end.T else None
        if after is not None and after.residual < GOOD * end.residual:
            return after
        change, longer = newton_step(end, SINGULAR)
    share = 1.0 if longer == 0 else min(1.0, end.T / (2 * abs(longer)))
    for _ in range(HALVINGS):
        X = _moved(end, change, longer) if share == 1.0 else end.X + share * change
        after = _motion(return_map, X, end.T + share * longer)
        if after is not None and after.residual < (1 - share / 4) * end.residual:
            return after
        share /= 2
    return None


def _moved(end: Return, change: np.ndarray, longer: float) -> np.ndarray:
    """X + change, as the image of the linearised map."""
    moved = product(end.flow_matrix, change)
    return np.asarray(end.image + (moved if end.tilt is None else moved + end.rate * longer))


def _motion(return_map: ReturnMap, X: np.ndarray, T: float) -> Return | None:
    """The motion from X, None where it fails, is asked for no time or has no derivative."""
    try:
        end = return_map(X, T)
    except (EngineError, OrbitError):
        return None
    return end if _has_derivative(end) else None
