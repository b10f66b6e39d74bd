"""Going on from a stored event row: the state, status and known zeros that the engine had there."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from math import isfinite

import numpy as np

from vibsim.engine.columns import flags_of_parts, part_columns, state_columns, stored_columns
from vibsim.engine.errors import State
from vibsim.engine.events.departures import released_parts, zeros_of_touch
from vibsim.engine.events.impacts.simultaneous import coincident_stops_of
from vibsim.engine.events.relative_motion import RelativeMotion
from vibsim.engine.flows.base_motion import NO_SIDES, belt_velocity
from vibsim.engine.modes.formula_rows import ZERO_UNIT, FormulaRows
from vibsim.engine.modes.mode_table import mode_table, switching_formulas
from vibsim.engine.modes.rows import CLEARANCE, GAP, PUSH, SLIDE, STRIKE, SWITCH, Known
from vibsim.engine.modes.status import LIFTED, OPEN, STICK, Status
from vibsim.physics.connections import event_parts
from vibsim.physics.formulas import Node
from vibsim.physics.numbers import TWO_PI, Doubles, N
from vibsim.physics.parts import EVENT_NAMES, RIGID_KINDS, Friction, Scene, Stop

Point = tuple[State[N], Status, Known]  # what a run goes on from: state, mode, known zeros
Row = Mapping[str, float]  # of a table of events, by column

IMPACTS = ("impact", "transmitted", "chatter")
JUMPS = (*IMPACTS, "rest_begin", "stick_begin", "reversal", "switch")
OF_PLACES = (GAP, STRIKE, CLEARANCE)  # event functions of displacements, by kind
ROUNDING = 2.0**-40  # of a velocity, above which its change is a jump [-]
HIGHEST_ORDER = 100  # of a zero that a row may tell, above all that series have


def resume_point(scene: Scene, row: Row | Sequence[Row]) -> Point:
    """State, status and known zeros of an event row. An order below zero is that of a zero which an event
    before another one at the same instant left: the run has looked at it once more behind that one. What
    moves no velocity leaves a displacement that passes zero as it was.

    row: values by column name (t, kind, part, states, phase, part states, sides of switches), or several rows
    of one instant in their order. The turns of the rotor are the whole ones between phi and phase. Raises
    ValueError for a row that no run of the scene has.
    """
    rows = [row] if isinstance(row, Mapping) else list(row)
    known: Known = {}
    formulas = switching_formulas(scene)
    for one in rows:
        _check(scene, one, formulas)
    for event in _events_of(scene, rows):
        jumps = any(_makes_forces_jump(scene, one) for one in event)
        kinds = {EVENT_NAMES[int(one["kind"])] for one in event}
        struck = not kinds.isdisjoint(IMPACTS)
        forced, moved = struck or "switch" in kinds, struck or "rest_begin" in kinds
        known = {
            key: order if order == 1 and key[0] in OF_PLACES and not moved else -abs(order)
            for key, order in known.items()
        }
        for one in event:
            state, status = _state(scene, one), _status(scene, one)
            whole, zeros, sides = _with_switches(formulas, one, status)
            known |= _zeros(scene, one, state, status, jumps, struck, forced, sides)
        known |= _zeros_of_parted(scene, event, state, status, 2 if jumps else 3)
    return state, whole, known | zeros


def _with_switches(
    formulas: FormulaRows[float] | None, row: Row, status: Status
) -> tuple[Status, Known, Mapping[Node, int]]:
    """The mode with the sides of its switches as a row tells them; the zeros that they are known to be at, at
    the lower end of a side or at the upper one; the sides. Raises ValueError for a side that there is not.
    """
    if formulas is None:
        return status, {}, NO_SIDES
    names = formulas.event_columns
    switches: list[int | None] = [None] * len(names)
    sides: dict[Node, int] = {}
    known: Known = {}
    for node, i, sign in formulas.awake(status, sides):
        side = round(row[names[i]])
        order = round((row[names[i]] - side) / ZERO_UNIT)
        if not formulas.has_side(i, side) or abs(order) > HIGHEST_ORDER:
            raise ValueError(f"event row: {names[i]} must be a side of that switch, got {row[names[i]]:g}")
        switches[i], sides[node] = side, sign * side
        if order != 0:
            end = 0 if formulas.switches[i][0] == "choose" else side + (order < 0)
            known[SWITCH, i, end] = abs(order)
    return status._replace(switches=tuple(switches)), known, sides


def rows_to_resume(scene: Scene, events: Mapping[str, np.ndarray], i: int) -> list[Row] | None:
    """The rows of the last instant of a table of events, up to its row `i`, from which a run goes on bit for
    bit, see `resume_point`; None for its start, and where the table does not tell the sides of switches, as
    that of an older file.
    """
    rows, formulas = rows_of_instant(events, i), switching_formulas(scene)
    told = formulas is None or all(name in events for name in formulas.event_columns)
    return rows if told and EVENT_NAMES[int(rows[0]["kind"])] != "start" else None


def _makes_forces_jump(scene: Scene, row: Row) -> bool:
    """Whether forces jump at the event of a row: a friction that drops where it begins to slip, turns or
    begins to stick, a damped stop, an impact.
    """
    kind, part = EVENT_NAMES[int(row["kind"])], int(row["part"])
    if kind in JUMPS:
        return True
    if kind == "stick_end":
        friction = part - len(scene.stops)
        return scene.frictions[friction].drops(_status(scene, row).frictions[friction])
    if kind not in ("contact_begin", "contact_end"):
        return False
    stop = dict(scene.elastic_stops)[part]
    return stop.jumps and RelativeMotion(scene, Doubles).closing(stop, _state(scene, row)) != 0


def _events_of(scene: Scene, rows: Sequence[Row]) -> list[list[Row]]:
    """The rows of one instant, event by event: those of one event are of one state and one mode."""
    columns = ("t", *state_columns(scene), *part_columns(scene))
    return [list(group) for _, group in groupby(rows, key=lambda row: [row[name] for name in columns])]


def rows_of_instant(events: Mapping[str, np.ndarray], i: int, earlier: Sequence[Row] = ()) -> list[Row]:
    """The rows of the instant of row `i` of a table of events up to it, values by column name; what
    `resume_point` takes.

    earlier: rows that went before the table, of one instant, which may be the same
    """
    times = events["t"]
    first = i
    while first > 0 and times[first - 1] == times[i]:
        first -= 1
    rows: list[Row] = [
        {name: column[k].item() for name, column in events.items()} for k in range(first, i + 1)
    ]
    return [*earlier, *rows] if first == 0 and earlier and earlier[-1]["t"] == times[i] else rows


def _check(scene: Scene, row: Row, formulas: FormulaRows[float] | None) -> None:
    phase = ("phase",) if scene.motor else ()
    for name in ("t", *state_columns(scene), *phase, *(formulas.event_columns if formulas else ())):
        if name not in row:
            raise ValueError(f"event row: {name} is missing")
        if not isfinite(row[name]):
            raise ValueError(f"event row: {name} must be finite, got {row[name]}")
    if not 0 <= row["t"] <= scene.t_end:
        raise ValueError(f"event row: t must be 0 to {scene.t_end:g} s, got {row['t']:g} s")
    names = part_columns(scene)
    allowed = {"kind": tuple(EVENT_NAMES), "part": tuple(range(-1, len(event_parts(scene))))}
    codes = [tuple(flags.values()) for flags in flags_of_parts(scene)]
    for name, values in (allowed | dict(zip(names, codes, strict=True))).items():
        if row[name] not in values:
            raise ValueError(
                f"event row: {name} must be one of {', '.join(map(str, values))}, got {row[name]}"
            )


def _state(scene: Scene, row: Row) -> State:
    values = [0.0 if name is None else float(row[name]) for name in stored_columns(scene)]
    n = 2 * len(scene.bodies)
    phase = turns = w = 0.0
    if scene.motor is not None:
        phase, w = float(row["phase"]), values[n + 1]
        turns = float(round((values[n] - phase) / TWO_PI))
    return State(float(row["t"]), values[0:n:2], values[1:n:2], phase, turns, w)


def status_of(scene: Scene, codes: Sequence[int]) -> Status:
    """The mode of the states of all parts, in the order of `Status.codes`."""
    first, second = len(scene.stops), len(scene.stops) + len(scene.frictions)
    return Status(tuple(codes[:first]), tuple(codes[first:second]), tuple(codes[second:]))


def _status(scene: Scene, row: Row) -> Status:
    return status_of(scene, [int(row[name]) for name in part_columns(scene)])


def _zeros(
    scene: Scene,
    row: Row,
    state: State,
    status: Status,
    jumps: bool,
    struck: bool,
    forced: bool,
    sides: Mapping[Node, int],
) -> Known:
    """Orders of the zeros that the event of a row leaves, by key; jumps: whether forces jump at its instant;
    struck: whether a rigid stop is struck then; forced: whether that, or the turn of a switch, may have made
    a force jump through zero; sides: of the switches behind the event.

    What a tie held for long enough parts with a zero of one order more where no force jumps.
    """
    kind, part = EVENT_NAMES[int(row["kind"])], int(row["part"])
    friction = part - len(scene.stops)
    clearance = friction - len(scene.frictions)
    if kind in ("contact_begin", "contact_end"):
        if forced and _deep(scene, dict(scene.elastic_stops)[part], state):
            return {}
        return {(_watched(scene, kind, part, state, status), part): 1}
    if kind in ("violation_begin", "violation_end"):
        return {(CLEARANCE, clearance): 1}
    if kind in RIGID_KINDS:
        parted = kind == "rest_end" and not struck  # no faster than rounding of velocities
        released = 2 if jumps else 3
        known: Known = {}
        for one in coincident_stops_of(scene, part):
            if status.stops[one] == OPEN:
                rate = 0.0 if parted else RelativeMotion(scene, Doubles).closing(scene.stops[one], state)
                known[STRIKE, one] = released if rate == 0 else 1
        return known
    if kind in ("reversal", "stick_end"):
        dry = scene.frictions[friction]
        if _struck(scene, dry, row) or (forced and _slips(scene, dry, state, sides)):
            return {}
    released = 1 if jumps else 2
    if kind in ("reversal", "stick_end"):
        return {(SLIDE, friction): 1 if kind == "reversal" else released}
    return {}


def _deep(scene: Scene, stop: Stop, state: State) -> bool:
    """Whether a stop that lets go by force is pressed to a depth, where no zero of that ends contact."""
    return stop.lets_go and not RelativeMotion(scene, Doubles).met(stop, state)


def _zeros_of_parted(scene: Scene, rows: Sequence[Row], state: State, status: Status, order: int) -> Known:
    """Orders of the zeros of what the ends touched of ties that let go at the instant of `rows`."""
    names = [(EVENT_NAMES[int(row["kind"])], int(row["part"])) for row in rows]
    count = len(scene.stops)
    ties = [part - count for kind, part in names if kind == "stick_end"]
    ties += [len(scene.frictions) + part for kind, part in names if kind == "rest_end"]
    if not ties:
        return {}
    maker = mode_table(scene).maker
    stops, clearances = released_parts(maker, status.with_ties(dict.fromkeys(ties, STICK)), status)
    stops, clearances = RelativeMotion(scene, Doubles).touched(state, stops, clearances)
    known: Known = {(CLEARANCE, i): order for i in clearances}
    for i in stops:
        known |= zeros_of_touch(maker, status, i, order)
    return known


def _struck(scene: Scene, friction: Friction, row: Row) -> bool:
    """Whether an impact moved the ends of a friction against each other."""
    ends = [scene.bodies[end].columns[1] for end in (friction.P, friction.Q) if end >= 0]
    jumps = [abs(row[name] - row.get(f"before_{name}", row[name])) for name in ends]
    sizes = [abs(row[name]) for name in ends]
    return any(jump > ROUNDING * (max(sizes) + abs(friction.belt)) for jump in jumps)


def _slips(scene: Scene, friction: Friction, state: State, sides: Mapping[Node, int]) -> bool:
    """Whether the ends of a friction slip by more than rounding: the base or its belt has jumped."""
    vP, vQ = RelativeMotion(scene, Doubles).ends(friction, state, "v")
    belt = belt_velocity(friction, Doubles, state.t, sides)
    return abs(vP - vQ - belt) > ROUNDING * (abs(vP) + abs(vQ) + abs(belt))


def _watched(scene: Scene, kind: str, part: int, state: State, status: Status) -> int:
    """Whether a contact began or ended at zero depth, or at zero force, which begins it while it shrinks."""
    stop = dict(scene.elastic_stops)[part]
    if not stop.lets_go:
        return GAP
    if kind == "contact_end":
        return PUSH if status.stops[part] == LIFTED else GAP
    return GAP if RelativeMotion(scene, Doubles).closing(stop, state) > 0 else PUSH
