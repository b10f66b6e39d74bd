"""What becomes of small changes of a state, and of numbers of a case, after a time.

Changes of the state, and of numbers of the case, are carried along by the motion, exact to rounding. Where
the motion rests on a rigid stop, strikes several at one instant or strikes one with a body that sticks,
changes of numbers are difference quotients of motions beside it, of two widths, whose leading error cancels
(Richardson), of four widths on one side where the range of the number ends: of infinitely many impacts in
front of a rest no closed form is known here. Behind the rest of a chattering oscillator they are right to
1e-13 by its force and mass, to 1e-9 by its frequency.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.number import number
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.labelled.shown import Shown
from vibsim.orbits.errors import OrbitError
from vibsim.orbits.matrices import eigenvalues, modulus
from vibsim.orbits.returns.coordinates import component_names, components_of
from vibsim.orbits.slopes.parameter_slopes import NotFollowed, parameter_slopes
from vibsim.orbits.slopes.scene_slopes import sloped_scene

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.physics.parts import Scene

ROUNDINGS = 8  # of each state behind a motion that has been at rest and forgotten what came before
WIDTH = 2.0**-10  # of the number: rounding 2^-53 / 2^-10 and what is left out, 2^-40, are both 1e-12 about


@dataclass(frozen=True, repr=False)
class Monodromy(Shown):
    """The derivative of a motion over a time.

    columns : names of the components of the state: x of each body, v of each body, phi and phidot
    matrix : d state(T) / d state(0), (N, N) in the order of `columns`
    state : the state at the end by name of the column; rate : its rates of change
    events : (kind, number of the part) on the way
    by_parameter : d state(T) / d number, (N) by key, per SI unit, rad/s for rates
    error : estimated of each where it is a difference quotient, 0 where it is exact but for rounding
    """

    columns: tuple[str, ...]
    matrix: np.ndarray
    state: dict[str, float]
    rate: dict[str, float]
    events: tuple[tuple[str, int], ...]
    by_parameter: dict[str, np.ndarray]
    error: dict[str, np.ndarray]

    def heading(self) -> str:
        """Its size, and by what the motion is differentiated."""
        by = ", ".join(["the state at its start", *self.by_parameter])
        return f"{len(self.columns)} x {len(self.columns)}, by {by}"

    def lines(self) -> list[tuple[str, str]]:
        """Components, magnitudes of the multipliers, events on the way, errors of difference quotients."""
        multipliers = sorted(map(modulus, eigenvalues(self.matrix)), reverse=True)
        quotients = [
            f"{key} {number(np.max(error), 1)}" for key, error in self.error.items() if np.any(error)
        ]
        lines = [
            ("components", ", ".join(self.columns)),
            ("multipliers", f"magnitudes {', '.join(number(each, 5) for each in multipliers)}"),
            ("events", str(len(self.events))),
        ]
        return [*lines, ("errors", ", ".join(quotients))] if quotients else lines


def monodromy(
    case: "Case | str | PathLike[str]",
    state: Mapping[str, float] | Sequence[float],
    T: float,
    parameters: Sequence[str] = (),
    engine: str = "auto",
    overrides: Mapping[str, object] | None = None,
) -> Monodromy:
    """The derivative of the motion of a case from `state` at t = 0 over the time `T` [s].

    Parameters
    ----------
    case, overrides : as of `load_case`
    state : by name of the column, e.g. {"x1": 0.001, "v1": 0.2, ...} [m, m/s, rad, rad/s], those left out 0;
        or all components: displacements, velocities, then angle and speed of a motor
    parameters : keys of numbers of the case by which the motion is differentiated too, e.g. ("c", "omega")

    Raises OrbitError for a column that is not one of the case's, a number at which a part comes or goes and a
    motion that has no derivative, UnknownKeyError for keys, EngineError where the run fails.

    Between its reversals a damped oscillator of mass 1 kg contracts areas by exp(-c T):

    >>> import numpy as np, vibsim
    >>> matrix = vibsim.monodromy("gallery/friction-oscillator", {"v_mass": 5}, 1.0).matrix
    >>> bool(abs(np.linalg.det(matrix) - np.exp(-0.1)) < 1e-14)
    True
    """
    from vibsim.cases.loading import load_case

    case = load_case(case, overrides)
    scene = case.scene()
    columns = component_names(scene)
    start, T = components_of(state, columns, left_out=0.0), time_after_start(T)
    carrier = Carrier(scene, engine)
    carried = carrier.carry(start, T)
    if not np.isnan(carried.undefined_at):
        raise OrbitError(
            f"at {carried.undefined_at:.6g} s the motion grazes a rigid stop or strikes several at one"
            " instant, where it has no derivative"
        )
    slopes = _slopes(case, parameters, carrier.started(start, T))
    if slopes is None:
        quotients = {key: _quotient(case, key, start, T, engine) for key in parameters}
    else:
        quotients = {key: (row, np.zeros(len(row))) for key, row in zip(parameters, slopes, strict=True)}
    return Monodromy(
        tuple(columns),
        carried.matrix,
        dict(zip(columns, carried.state.tolist(), strict=True)),
        dict(zip(columns, carried.rate.tolist(), strict=True)),
        carried.events,
        {key: quotient for key, (quotient, _) in quotients.items()},
        {key: error for key, (_, error) in quotients.items()},
    )


def time_after_start(T: Any) -> float:
    """A time [s] as an argument. Raises OrbitError."""
    try:
        time = float(T)
    except (TypeError, ValueError):
        time = 0.0
    if not 0 < time < inf:
        raise OrbitError(f"T must be a number of seconds above 0, got {T!r:.60}")
    return time


def _slopes(case: "Case", parameters: Sequence[str], started: "Scene") -> np.ndarray | None:
    """d state(T) / d number of each of the numbers, one per row; None where they cannot be followed."""
    if not parameters:
        return np.zeros((0, 0))
    try:
        return parameter_slopes(started, sloped_scene(case, parameters), len(parameters))
    except NotFollowed:
        return None


def _quotient(
    case: "Case", key: str, start: Sequence[float], T: float, engine: str
) -> tuple[np.ndarray, np.ndarray]:
    """d state(T) / d number of the case, and the estimate of its error: central where the case allows both
    sides of the number, one-sided where the range of the number ends at it.
    """
    value = case.number(key)
    if value == 0 and _si(case, key):
        raise OrbitError(f"{key} is 0, which leaves open how far to change it; give it a small value")

    def motion(share: float) -> tuple[float, np.ndarray]:
        """The number changed by a share of it, of 1 where it is 0, and the state at the end."""
        number = value * (1 + share) if value else share
        changed = case.with_values({key: f"{number!r} {_si(case, key)}".strip()}) if share else case
        return changed.number(key), Carrier(changed.scene(), engine).carry(start, T, []).state

    sides = _sides(case, key, value)
    if len(sides) == 2:
        pairs = [(motion(share), motion(-share)) for share in (WIDTH, WIDTH / 2)]
        return _extrapolated(pairs, (2,))
    here = motion(0.0)
    pairs = [(motion(sides[0] * WIDTH / 2**i), here) for i in range(4)]
    return _extrapolated(pairs, (1, 2, 3))


def _sides(case: "Case", key: str, value: float) -> list[int]:
    """The sides of a number that the case allows. Raises CaseError where it allows none."""
    from vibsim.cases import CaseError

    sides, refused = [], None
    for side in (1, -1):
        number = value * (1 + side * WIDTH) if value else side * WIDTH
        try:
            case.with_values({key: f"{number!r} {_si(case, key)}".strip()})
            sides.append(side)
        except CaseError as error:
            refused = error
    if refused and not sides:
        raise refused
    return sides


Motion = tuple[float, np.ndarray]  # a number of the case, and the state at the end


def _extrapolated(
    pairs: Sequence[tuple[Motion, Motion]], powers: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Difference quotients of pairs of motions, each half as far apart as those before, with what is left out
    of them in these powers of the width taken away; and what is left and rounding make of it.
    """
    rows = [(end - other) / (number - there) for (number, end), (there, other) in pairs]
    (number, end), (there, other) = pairs[-1]
    rounding = 2 * ROUNDINGS * 2.0**-52 * float(np.abs([end, other]).max()) / abs(number - there)
    for power in powers:
        halves, apart = 2**power, np.abs(rows[-1] - rows[-2])
        rows = [(halves * narrow - wide) / (halves - 1) for wide, narrow in pairwise(rows)]
        rounding *= (halves + 1) / (halves - 1)
    return rows[-1], apart * WIDTH + rounding


def _si(case: "Case", key: str) -> str:
    """The SI unit of a number of the case."""
    from vibsim.cases.values.units import find_unit, si_unit

    unit = find_unit(case.quantity(key).text.partition(" ")[2])
    return "" if unit is None else si_unit(unit.dimension).name
