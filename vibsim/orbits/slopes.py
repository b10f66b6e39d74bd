"""Derivatives of the return map by the numbers of a scene."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import inf, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.quantities import any_unit_named, in_own_unit, number, si_unit
from vibsim.engine.blocks import part_offsets
from vibsim.engine.errors import State
from vibsim.engine.events.impacts.newton_moreau import Contact, impact, masses
from vibsim.engine.events.records import Certificate
from vibsim.engine.flows.motion import value_and_rate
from vibsim.engine.flows.taylor import Taylor
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import GAP, HOLD, PUSH, SLIDE, STRIKE
from vibsim.engine.resume import Row, state_and_status
from vibsim.engine.tangent.carried import started
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.coordinates import OrbitError, component_names, components_of
from vibsim.orbits.stability import eigenvalues, modulus
from vibsim.physics.parts import EVENT_NAMES, Scene
from vibsim.physics.rates import fastest_rate
from vibsim.physics.traced_numbers import Sloped, SlopedNumbers, slope_of
from vibsim.results.labelled import Shown

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.cases.case import CaseLike


# What changes of a scene's numbers make of a motion: its derivative by them, through events.
#
# Between events the Taylor flow carries derivatives along (`vibsim.physics.traced_numbers`), at
# fixed times. Where an event function h depends on the numbers too, the event moves by dt = -dh / h', and
# with the vector fields f- and f+ on both sides
#
#     d(behind) = d(before) + (f- - f+) dt,
#     at an impact R:  d(behind) = dR(state, numbers at t + dt) - f+ dt,
#
# which is the saltation matrix with what the numbers add to it (Aizerman & Gantmakher 1958; Mueller 1995).


STEP_SHARE = 0.5  # of the step that the flow itself would take: derivatives ask for more terms than values
OF_EVENTS = {
    "contact_begin": (GAP, PUSH),
    "contact_end": (GAP, PUSH),
    "reversal": (SLIDE,),
    "stick_begin": (SLIDE,),
    "stick_end": (HOLD,),
    "impact": (STRIKE,),
}
NOT_FOLLOWED = ("transmitted", "chatter", "rest_begin", "rest_end")


class NotFollowed(Exception):
    """An event, or a mode, whose derivative by the numbers is not known in closed form."""


def parameter_slopes(started: "Scene", sloped: Any, count: int) -> np.ndarray:
    """Derivatives of the components at the end of a motion by `count` numbers, (count, components).

    started : the scene in doubles, from its start to its end; sloped : the same with derivatives
    engine : that finds the motion, as of `open_trajectory`

    Raises NotFollowed for several rigid stops at one instant, rest on a rigid stop, impacts on what sticks,
    and what holds on ground and base at once while the derivative is by an amplitude of 0; OrbitError at a
    tangency; EngineError where the run fails.
    """
    followed, first_part = _Followed(sloped, started, count), part_offsets(started)
    start, *rows = _event_rows(started)
    state, status = state_and_status(started, start)
    for row in rows:
        there, behind = state_and_status(started, row)
        code = int(row["kind"])
        kind, part = EVENT_NAMES[code], int(row["part"]) - int(first_part[code])
        state = followed.carried(state, status, there.t)
        if behind != status or kind == "impact":
            state = followed.crossed(state, status, behind, kind, part)
        state, status = _with_slopes(there, state, count), behind
    return _components(state, count, started.motor is not None)


def _event_rows(scene: "Scene") -> list[Row]:
    """Start, events and end of the run of a scene by column."""
    tables = [block.events for block in open_trajectory(scene).blocks()]
    return [
        dict(zip(table, values, strict=True))
        for table in tables
        for values in zip(*(column.tolist() for column in table.values()), strict=True)
    ]


class _Followed:
    """Follows derivatives along a motion that is known."""

    def __init__(self, scene: Any, started: Any, count: int):
        self.scene, self.count, self.kit = scene, count, SlopedNumbers
        varied = any(isinstance(term.amplitude, Sloped) for term in scene.base)
        self.maker = RowMaker(scene, SlopedNumbers, started.base_moves or varied)
        damping = [
            part.c / started.bodies[end].m
            for part in (*started.links, *started.stops)
            if getattr(part, "c", 0)
            for end in (part.P, part.Q)
            if end >= 0
        ]
        rate = max([fastest_rate(started), *damping])
        self.longest = 1 / rate if rate else np.inf

    def flow(self, state: Any, status: Any) -> Any:
        """The Taylor flow at a state in a mode."""
        rows, ground = self.maker.rows(status), self.maker.n
        if rows.leader[ground + 1] == ground:
            raise NotFollowed("bodies that hold on to the ground and to a base that is about to move")
        flow: Any = Taylor(self.scene, self.kit, Certificate(self.kit))
        flow.enter(state, rows, {})
        return flow

    def carried(self, state: Any, status: Any, end: float) -> Any:
        """The state at the time `end` [s] in one mode."""
        while state.t < end:
            flow = self.flow(state, status)
            h = min(STEP_SHARE * float(flow.h), self.longest)
            state = flow.state_at(end if state.t + 1.25 * h >= end else state.t + h)
        return state

    def crossed(self, state: Any, before: Any, after: Any, kind: str, part: int) -> Any:
        """The state, and its derivatives at the same time, behind an event."""
        if kind in NOT_FOLLOWED:
            raise NotFollowed(kind)
        if kind not in OF_EVENTS:  # a limit that is watched exerts no force
            return state
        flow = self.flow(state, before)
        event = self._event(flow, kind, part)
        if kind == "impact":
            return self._struck(flow, event, state, before, after)
        jump = self._rates(self.flow(state, after)) - self._rates(flow)
        if not jump.any():
            return state
        later = self._later(flow, event)
        return _moved(state, -(jump[:, None] * later), self.count)

    def _event(self, flow: Any, kind: str, part: int) -> Any:
        """The event function that has come to zero."""
        events = []
        for event in flow.rows.events:
            ties = [tie for tie, _ in flow.rows.cuts[event.part].ties] if event.kind == HOLD else [event.part]
            if event.kind in OF_EVENTS[kind] and part in ties:
                events.append((abs(float(flow.derivatives(event, 0)[0])) / (float(event.size) or 1.0), event))
        return min(events, key=lambda pair: pair[0])[1]

    def _later(self, flow: Any, event: Any) -> np.ndarray:
        """Delay of the event per unit of each number [s]."""
        h, rate = flow.derivatives(event, 1)
        if float(rate) == 0:
            raise OrbitError(f"at {float(flow.t0):.6g} s the motion is tangent to an event: no derivative")
        return -slope_of(h, self.count) / float(rate)

    def _rates(self, flow: Any) -> np.ndarray:
        """Rates of velocities, and of the rotor's speed where there is a motor."""
        speeds = flow.v[: flow.n] if flow.rotor is None else [*flow.v[: flow.n], flow.rotor.w]
        return np.array([float(series[1]) for series in speeds])

    def _struck(self, flow: Any, event: Any, state: Any, before: Any, after: Any) -> Any:
        """Behind an impact on one rigid stop."""
        if before.tied or after.tied:
            raise NotFollowed("impact")
        later, rates, n = self._later(flow, event), self._rates(flow), flow.n
        meeting = _shifted(state, rates, later, self.count)
        stop = self.scene.stops[event.part]
        _, V = value_and_rate(self.kit, self.scene.base, Sloped(float(state.t), later))
        bodies = masses(self.scene, self.kit, meeting.phase)
        contact = Contact(event.part, *self.maker.ends(stop), stop.sense, stop.e)
        v, w, _ = impact(self.kit, bodies, [contact], [*meeting.v, 0.0, V], meeting.w)
        struck = State(state.t, meeting.x, v[:n], meeting.phase, state.turns, w)
        return _shifted(struck, self._rates(self.flow(struck, after)), -later, self.count)


def _shifted(state: Any, rates: np.ndarray, later: np.ndarray, count: int) -> Any:
    """The state at a time that depends on the numbers: dx = v dt, dv = a dt."""
    n = len(state.x)
    x = [_plus(x, float(v) * later, count) for x, v in zip(state.x, state.v, strict=True)]
    v = [_plus(v, a * later, count) for v, a in zip(state.v, rates.tolist(), strict=False)]
    phase, w = _plus(state.phase, float(state.w) * later, count), state.w
    if len(rates) > n:
        w = _plus(w, float(rates[n]) * later, count)
    return State(state.t, x, v, phase, state.turns, w)


def _moved(state: Any, change: np.ndarray, count: int) -> Any:
    """The state with changed derivatives of its velocities, and of the rotor's speed."""
    n = len(state.x)
    v = [_plus(one, row, count) for one, row in zip(state.v, change, strict=False)]
    w = _plus(state.w, change[n], count) if len(change) > n else state.w
    return State(state.t, state.x, v, state.phase, state.turns, w)


def _plus(number: Any, slope: np.ndarray, count: int) -> Sloped:
    return Sloped(float(number), slope_of(number, count) + slope)


def _with_slopes(there: Any, state: Any, count: int) -> Any:
    """The state of the run, with the derivatives of what was carried to it."""

    def lifted(value: Any, carried: Any) -> Sloped:
        return Sloped(float(value), slope_of(carried, count))

    x = [lifted(*pair) for pair in zip(there.x, state.x, strict=True)]
    v = [lifted(*pair) for pair in zip(there.v, state.v, strict=True)]
    return State(there.t, x, v, lifted(there.phase, state.phase), there.turns, lifted(there.w, state.w))


def _components(state: Any, count: int, motor: bool) -> np.ndarray:
    parts: Sequence[Any] = [*state.x, *state.v, *((state.phase, state.w) if motor else ())]
    return np.transpose([slope_of(part, count) for part in parts])


# The scene of a case with the derivatives of all its numbers by some numbers of the case.
#
# A number of the case may stand in several places, multiplied with others and rounded once. Exact scenes, in
# fractions, for the case and for one a share of 1e-40 beside it give the derivatives to 40 digits.


EXACT_STEP_SHARE = Fraction(1, 10**40)  # of the number, or of its unit where it is 0


def sloped_scene(case: "Case", keys: Sequence[str]) -> Scene[Any]:
    """The scene whose numbers carry derivatives by the numbers of `keys`, per SI unit (rad/s for rates).

    Raises OrbitError for a number that cannot be changed without adding or removing a part, and what
    `Case.quantity` raises for keys.
    """
    exact, sides, shifts = case.exact_scene(Fraction), [], []
    for key in keys:
        beside, shift = _beside(case, key)
        sides.append(beside.exact_scene(Fraction))
        shifts.append(shift)
        if not _same_parts(exact, sides[-1]):
            raise OrbitError(f"{key} is where a part comes or goes, so the motion has no derivative by it")
    sloped: Scene[Any] = _joined(case.scene(), exact, sides, shifts)
    return sloped


def _beside(case: "Case", key: str) -> tuple["Case", Fraction | float]:
    """The case with one number a little changed, and by how much in SI units."""
    from vibsim.cases import CaseError

    own = case.quantity(key)
    for share in (EXACT_STEP_SHARE, -EXACT_STEP_SHARE):
        value = own.value * (1 + share) if own.value else share
        try:
            beside = case.with_values({key: in_own_unit(own, value)})
        except CaseError as error:
            refused = error
            continue
        shift = value - own.value
        return beside, shift * Fraction(2 * pi) ** own.per_turn if own.per_turn else shift
    raise refused


def _same_parts(one: Any, other: Any) -> bool:
    if is_dataclass(one):
        pairs = ((getattr(one, each.name), getattr(other, each.name, None)) for each in fields(one))
        return type(one) is type(other) and all(_same_parts(*pair) for pair in pairs)
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(_same_parts, one, other))
    return (one is None) == (other is None)


def _joined(part: Any, exact: Any, sides: Sequence[Any], shifts: Sequence[Any]) -> Any:
    """A part of a scene, its numbers with their derivatives where these are not all 0."""
    if is_dataclass(part) and not isinstance(part, type):
        values = {
            each.name: _joined(
                getattr(part, each.name),
                getattr(exact, each.name),
                [getattr(side, each.name) for side in sides],
                shifts,
            )
            for each in fields(part)
        }
        return replace(part, **values)
    if isinstance(part, tuple):
        rows = zip(part, exact, *sides, strict=True)
        return tuple(_joined(one, there, besides, shifts) for one, there, *besides in rows)
    if not isinstance(part, float):
        return part
    slopes = [float((side - exact) / shift) for side, shift in zip(sides, shifts, strict=True)]
    return Sloped(part, np.array(slopes)) if any(slopes) else part


# What becomes of small changes of a state, and of numbers of a case, after a time.
#
# Changes of the state, and of numbers of the case, are carried along by the motion, exact to rounding. Where
# the motion rests on a rigid stop, strikes several at one instant or strikes one with a body that sticks,
# changes of numbers are difference quotients of motions beside it, of two widths, whose leading error cancels
# (Richardson), of four widths on one side where the range of the number ends: of infinitely many impacts in
# front of a rest no closed form is known here. Behind the rest of a chattering oscillator they are right to
# 1e-13 by its force and mass, to 1e-9 by its frequency.


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
    slopes = _slopes(case, parameters, started(carrier.scene, start, T))
    if slopes is None:
        quotients = {key: _beside_motions(case, key, start, T) for key in parameters}
    else:
        quotients = {key: (row, np.zeros(len(row))) for key, row in zip(parameters, slopes, strict=True)}
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


def _slopes(case: "Case", parameters: Sequence[str], started: "Scene") -> np.ndarray | None:
    """d state(T) / d number of each of the numbers, one per row; None where they cannot be followed, as in
    formulas.
    """
    if not parameters:
        return np.zeros((0, 0))
    if started.has_formulas:
        return None
    try:
        return parameter_slopes(started, sloped_scene(case, parameters), len(parameters))
    except NotFollowed:
        return None


def _beside_motions(
    case: "Case", key: str, start: Sequence[float], T: float
) -> tuple[np.ndarray, np.ndarray]:
    """d state(T) / d number of the case by motions beside it, and the estimate of its error. With formulas
    the motions have many digits, where a library of many digits is installed.
    """
    from vibsim.orbits.orbit_digits import slope_in_digits

    if case.scene().has_formulas:
        slope = slope_in_digits(case, *_beside(case, key), start, T)
        if slope is not None:
            return slope, np.zeros(len(slope))
    return _quotient(case, key, start, T)


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
