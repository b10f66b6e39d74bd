"""Derivatives of a motion by its start and by numbers of its case."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from fractions import Fraction
from itertools import pairwise
from math import inf, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.quantities import any_unit_named, in_own_unit, number, si_unit
from vibsim.engine.errors import EngineError
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.orbits.coordinates import OrbitError, component_names, components_of
from vibsim.orbits.stability import eigenvalues, modulus
from vibsim.physics.precision import MultiprecisionMissing, number_kit
from vibsim.results.labelled import Shown

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.cases.case import CaseLike


# What becomes of small changes of a state, and of numbers of a case, after a time.
#
# Changes of the state are carried along by the motion, exact to rounding. Those of numbers are differences of
# motions in many digits, of which some thirty are left. Without a library of many digits, or where such a
# motion fails, they are difference quotients of motions in doubles, of two widths, whose leading error
# cancels (Richardson), of four widths on one side where the range of the number ends.


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
    error : estimated of each where it is a difference quotient in doubles, 0 where it is exact but for
        rounding
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
    case: "CaseLike",
    overrides: Mapping[str, object] | None = None,
    *,
    state: Mapping[str, float] | Sequence[float],
    T: float,
    parameters: Sequence[str] = (),
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

    From a `state` exactly where a stop or a friction changes (a gap of 0, a slip of 0) it is the derivative
    to one side: of disturbances that leave open, in contact, sliding or sticking what is so at the start.

    Between its reversals a damped oscillator of mass 1 kg contracts areas by exp(-c T):

    >>> import numpy as np, vibsim
    >>> matrix = vibsim.monodromy("gallery/friction-oscillator", state={"v_mass": 5}, T=1.0).matrix
    >>> bool(abs(np.linalg.det(matrix) - np.exp(-0.1)) < 1e-14)
    True
    """
    from vibsim.cases.case import load_case

    case = load_case(case, overrides)
    scene = case.scene()
    components = component_names(scene)
    shown = [i for i, name in enumerate(components) if name is not None]
    columns = [name for name in components if name is not None]
    start, T = components_of(state, components, left_out=0.0), time_after_start(T)
    carrier = Carrier(scene)
    carried = carrier.carry(start, T)
    if not np.isnan(carried.undefined_at):
        raise OrbitError(
            f"at {carried.undefined_at:.6g} s the motion grazes a rigid stop or strikes several at one"
            " instant, or the derivative of a formula is infinite there and has no integral: it has no"
            " derivative"
        )
    in_digits = _slopes_in_digits(case, parameters, start, T)
    quotients = {
        key: (in_digits[key], np.zeros(len(start))) if key in in_digits else _quotient(case, key, start, T)
        for key in parameters
    }
    return Monodromy(
        tuple(columns),
        carried.matrix[np.ix_(shown, shown)],
        dict(zip(columns, carried.state[shown].tolist(), strict=True)),
        dict(zip(columns, carried.rate[shown].tolist(), strict=True)),
        carried.events,
        {key: quotient[shown] for key, (quotient, _) in quotients.items()},
        {key: error[shown] for key, (_, error) in quotients.items()},
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


# Motions in many digits beside that of the case.


DIGITS = 70  # of motions a share of 1e-40 of the number apart: 30 are left of their difference
SHARE = Fraction(1, 10**40)  # of the number, or of its unit where it is 0
KNOWN = 1e-65  # of the largest component: what rounding leaves of a motion, with some to spare
ALIKE = 1e-12  # of the largest component: so far quotients on two sides may lie apart


def _slopes_in_digits(
    case: "Case", keys: Sequence[str], start: Sequence[float], T: float
) -> dict[str, np.ndarray]:
    """d state(T) / d number of each key, right to the rounding of doubles; without those whose motions fail,
    and none where the engine was not built on words. Raises OrbitError.
    """
    slopes = dict[str, np.ndarray]()
    with suppress(EngineError, MultiprecisionMissing):
        if not keys:
            return slopes
        here = _state_in_digits(case, start, T)
        for key in keys:
            beside = _beside(case, key)
            with suppress(EngineError):
                there = [(_state_in_digits(one, start, T), shift) for one, shift in beside]
                slopes[key] = _slope(key, here, there)
    return slopes


def _state_in_digits(case: "Case", start: Sequence[float], T: float) -> np.ndarray:
    """The components at `T` of the motion from `start`, whose doubles stand for their shortest decimals, as
    those of a case do: what just touches there does so here.
    """
    kit: Any = number_kit(DIGITS)
    *components, end = (kit.number(Fraction(repr(float(value)))) for value in (*start, T))
    carrier = Carrier(case.exact_scene(kit.number, kit.pi), WordsForm(kit))
    return carrier.carried(components, end, []).state


def _slope(key: str, here: np.ndarray, there: Sequence[tuple[np.ndarray, Fraction]]) -> np.ndarray:
    """The derivative by the states of two motions, each with how far its number is off: the mean of their
    quotients, which agree where there is a derivative.
    """
    kit: Any = number_kit(DIGITS)
    one, other = (
        np.array([float((b - a) / kit.number(shift)) for a, b in zip(here, state, strict=True)])
        for state, shift in there
    )
    noise = KNOWN * max(abs(float(a)) for a in here) / min(abs(float(shift)) for _, shift in there)
    if not np.abs(one - other).max() <= ALIKE * np.abs([one, other]).max() + noise:
        raise OrbitError(
            f"the motion has no derivative by {key}: it changes with a little more of it in another way than"
            " with a little less, as where it is tangent to an event"
        )
    mean = (one + other) / 2
    return np.where(np.abs(mean) <= noise, 0.0, mean)


def _beside(case: "Case", key: str) -> "list[tuple[Case, Fraction]]":
    """Two cases with the number a little changed, and by how much in SI units: on both of its sides, or on
    the only one that its range leaves. Raises CaseError where there is none, OrbitError where parts come or
    go with it.
    """
    from vibsim.cases import CaseError

    own, exact, found = case.quantity(key), case.exact_scene(Fraction), list[tuple["Case", Fraction]]()
    for share in (SHARE, -SHARE, SHARE / 2, -SHARE / 2):
        value = own.value * (1 + share) if own.value else share
        try:
            beside = case.with_values({key: in_own_unit(own, value)})
        except CaseError as error:
            refused = error
            continue
        if not _same_parts(exact, beside.exact_scene(Fraction)):
            raise OrbitError(f"{key} is where a part comes or goes, so the motion has no derivative by it")
        found.append((beside, (value - own.value) * Fraction(2 * pi) ** own.per_turn))
        if len(found) == 2:
            return found
    raise refused


def _same_parts(one: Any, other: Any) -> bool:
    """Whether two scenes have the same parts, whatever their numbers and formulas are."""
    if is_dataclass(one):
        pairs = ((getattr(one, each.name), getattr(other, each.name, None)) for each in fields(one))
        return type(one) is type(other) and all(_same_parts(*pair) for pair in pairs)
    if isinstance(one, tuple) and not (one and isinstance(one[0], str)):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(_same_parts, one, other))
    return (one is None) == (other is None)


# Motions in doubles beside that of the case.


def _quotient(case: "Case", key: str, start: Sequence[float], T: float) -> tuple[np.ndarray, np.ndarray]:
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
        return changed.number(key), Carrier(changed.scene()).carry(start, T, []).state

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

    unit = any_unit_named(case.quantity(key).text.partition(" ")[2])
    return "" if unit is None else si_unit(unit.dimension).name
