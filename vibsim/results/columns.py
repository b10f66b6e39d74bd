"""The columns of a trajectory: what each is called, its unit and its meaning, the same in every file."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.columns import before_columns, flags_of_parts, part_columns
from vibsim.engine.modes.mode_table import switching_formulas
from vibsim.engine.resume import Row, rows_to_resume
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.connections import event_parts, switching_parts
from vibsim.physics.elementary import sine_cosine_of_arrays
from vibsim.physics.parts import (
    ANGLE,
    BASE,
    COMPRESSION,
    EVENT_KINDS,
    EXTENSION,
    GROUND,
    IMPACTS,
    MOTOR,
    RIGID_KINDS,
    ROTOR,
    SPEED,
    STATE,
    SWITCH,
    Body,
    RigidStop,
    Scene,
    Stop,
    columns_of,
)
from vibsim.physics.rates import fastest_rate
from vibsim.results.file_contents import Column

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.results.result import Result


TIMES = {
    "time": Column("s", "time"),
    "t": Column("s", "time of the event"),
}
ROTOR_COLUMNS = {
    ANGLE: Column("rad", "rotor angle"),
    SPEED: Column("rad s-1", "rotor speed"),
}
PHASE = {
    "phase": Column("rad", "rotor angle reduced to one turn"),
}
JUDGEMENTS = {
    "error_estimate": Column("m", "estimated error of the displacements"),
}
SIDES = {
    "comment": "1 where its argument is positive, -1 where it is negative; of tables and mod the number of "
    "the piece; 0 where the mode does not read it. 2^-20 more for each order of a zero at the lower end of "
    "the side that the motion leaves, as much less for one at the upper end"
}
NO_PART = "none"  # to which an event belongs: start, end


@dataclass(frozen=True)
class Tables:
    """The columns of the samples and of the events of a run, by name in file order.

    states : names of the sampled states; displacements, velocities : those of them that are of bodies on the
    line
    """

    samples: dict[str, Column]
    events: dict[str, Column]
    states: tuple[str, ...]
    displacements: tuple[str, ...]
    velocities: tuple[str, ...]

    @property
    def deciding(self) -> tuple[str, ...]:
        """Names of the states whose errors decide how good a run is: the displacements; where no body is on
        the line, all states but speeds of rotors.
        """
        return self.displacements or tuple(
            name for name in self.states if self.samples[name].units != "rad s-1"
        )

    @property
    def error_unit(self) -> str:
        """The unit of the errors that decide."""
        return self.samples[self.deciding[0]].units or "1"

    @property
    def flags(self) -> tuple[str, ...]:
        """Names of the sampled columns that say the state of a part."""
        return tuple(name for name, column in self.samples.items() if column.flags)

    def judged(self, judgements: Iterable[str] = JUDGEMENTS) -> "Tables":
        """These, and columns that judge the samples."""
        judging = {name: JUDGEMENTS[name] for name in judgements}
        if self.error_unit != "m":
            judging = {name: replace(column, units=self.error_unit) for name, column in judging.items()}
        return replace(self, samples=self.samples | judging)


def tables_of(scene: Scene) -> Tables:
    """The columns of a run of `scene`."""
    states: dict[str, Column] = {}
    for body in scene.bodies:
        states |= _states_of(scene, body)
    if scene.has_motor:
        states |= ROTOR_COLUMNS
    parts = dict(zip(part_columns(scene), _part_states(scene), strict=True))
    kinds = {"kind": Column(None, "kind of the event", dtype="i1", flags=_kinds(scene))}
    in_full = {**states, **(PHASE if scene.has_motor else {})}
    in_full |= {name: _before(states[name.removeprefix("before_")]) for name in before_columns(scene)}
    return Tables(
        {"time": TIMES["time"], **states, **parts},
        {"t": TIMES["t"], **kinds, "part": _part_of_event(scene), **in_full, **parts, **_sides(scene)},
        tuple(states),
        tuple(columns_of(body.name)[0] for body in scene.line),
        tuple(columns_of(body.name)[1] for body in scene.line),
    )


def _states_of(scene: Scene, body: Body) -> dict[str, Column]:
    """The columns of a body, rotor or state by name."""
    if body.kind == STATE:
        unit = dict(scene.state_units).get(body.name, "")
        return {body.name: Column(written_unit(unit), f"state {body.name}")}
    x, v = body.columns
    assert x is not None
    if body.kind == ROTOR:
        if body.name == MOTOR:
            return ROTOR_COLUMNS
        return {
            x: Column("rad", f"angle of the rotor {body.name}"),
            v: Column("rad s-1", f"speed of the rotor {body.name}"),
        }
    return {
        x: Column(scene.unit_of(body), f"displacement of {_called(body.name)}"),
        v: Column(f"{scene.unit_of(body)} s-1", f"velocity of {_called(body.name)}"),
    }


def starts_of(scene: Scene, is_long: bool) -> dict[str, tuple[str, str]]:
    """By column of a state: the key of its start value in a case of the long form or the short one, and its
    unit there.
    """
    starts: dict[str, tuple[str, str]] = {}
    for body in scene.bodies:
        x, v = body.columns
        if body.kind == STATE:
            starts[v] = f"states.{body.name}.start", dict(scene.state_units).get(body.name, "")
            continue
        assert x is not None
        names = ("phi", "phidot" if body.name == MOTOR else "w") if body.kind == ROTOR else ("x", "v")
        keys = [f"{body.name}.{name}" for name in names] if is_long else (x, v)
        unit = scene.unit_of(body)
        starts |= {x: (f"initial.{keys[0]}", unit), v: (f"initial.{keys[1]}", f"{unit}/s")}
    if scene.has_motor:
        where = "initial.motor" if is_long else "initial"
        starts |= {ANGLE: (f"{where}.phi", "rad"), SPEED: (f"{where}.phidot", "rad/s")}
    return starts


def written_unit(unit: str) -> str:
    """A unit of a case as files write it: N s/m^2 as N s m-2; 1 for none."""
    over, *under = unit.split("/")
    factors = [factor for factor in over.replace("*", " ").split() if factor != "1"]
    for part in under:
        for factor in part.strip("()").replace("*", " ").split():
            name, _, power = factor.partition("^")
            factors.append(f"{name}^-{power or 1}")
    return " ".join(factor.replace("^", "") for factor in factors) or "1"


def _kinds(scene: Scene) -> dict[str, int]:
    """The kinds of events that a scene may have, with their codes."""
    left_out = () if scene.rigid_stops else RIGID_KINDS
    left_out = left_out if has_switches(scene) else (*left_out, SWITCH)
    return {name: code for name, code in EVENT_KINDS.items() if name not in left_out}


def has_switches(scene: Scene) -> bool:
    """Whether any formula of a scene has several sides, so that its jumps are events."""
    if not scene.has_formulas:
        return False
    return bool(switching_parts(scene))


def _called(body: str) -> str:
    return f"block {body}" if body.isdigit() else body


def _before(column: Column) -> Column:
    return replace(column, long_name=f"{column.long_name} in front of the event")


def _part_states(scene: Scene) -> Iterable[Column]:
    """A column of flags for each part that has states, in the order of `part_columns`."""
    words = ["stop"] * len(scene.stops) + ["friction"] * len(scene.frictions)
    words += ["clearance"] * len(scene.clearances)
    parts: tuple[Any, ...] = (*scene.stops, *scene.frictions, *scene.clearances)
    for word, part, flags in zip(words, parts, flags_of_parts(scene), strict=True):
        called = word if part.name == word else f"{word} {part.name}"
        ends = f"{_called(scene.end_name(part.P))} and {_called(scene.end_name(part.Q))}"
        yield Column(None, f"state of the {called} between {ends}", dtype="i1", flags=flags)


def _sides(scene: Scene) -> dict[str, Column]:
    """A column of events for each switch of a formula."""
    formulas = switching_formulas(scene)
    if formulas is None:
        return {}
    return {
        name: Column("1", f"side of a switch in the formula of {owner}", besides=SIDES)
        for name, owner in zip(formulas.event_columns, formulas.owners, strict=True)
    }


def _part_of_event(scene: Scene) -> Column:
    """The part that an event is of, by its number among `event_parts`."""
    flags = {NO_PART: -1} | {name: i for i, name in enumerate(event_parts(scene))}
    dtype = "i1" if len(flags) < 128 else "i2"
    return Column(None, "part that the event is of", dtype=dtype, flags=flags)


# The digits of a truth run: decimal texts beside the doubles.


Table = Mapping[str, np.ndarray]


class Digits(Mapping[str, np.ndarray]):
    """Columns of decimal texts (numpy str, 1-D), read and decoded when they are asked for.

    `digits["x1"]` holds the sampled displacements of block 1, `digits.events["t"]` the times of the events,
    each to all the digits carried: str(digits["x1"][-1]) can be given to Decimal or mpmath.mpf.
    """

    def __init__(self, table: Table, events: Table | None = None):
        self.table = table
        self.event_table = {} if events is None else events

    def in_memory(self) -> "Digits":
        """The same, read from its file."""
        return Digits(dict(self.table), dict(self.event_table))

    @property
    def events(self) -> "Digits":
        """The digits of the table of events."""
        return Digits(self.event_table)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.table:
            raise KeyError(f"no digits of {name}; there are those of {', '.join(self.table)}")
        return np.char.decode(self.table[name], "ascii")

    def __iter__(self) -> Iterator[str]:
        return iter(self.table)

    def __len__(self) -> int:
        return len(self.table)


# States between samples: the engine restarted from stored events.


def states_at(
    scene: Scene, events: Mapping[str, np.ndarray], t: float | np.ndarray, t_reached: float
) -> dict[str, np.ndarray]:
    """Columns at the instants `t` [s], each computed from the last of the `events` that is not after it.

    Returns name -> array of the shape of `t`. Raises ValueError for times before 0 or after `t_reached`.
    """
    try:
        times = np.asarray(t, dtype="f8")
    except (TypeError, ValueError):
        raise TypeError(f"times must be numbers [s], got {t!r:.60}") from None
    flat = times.ravel()
    if not np.all((flat >= 0) & (flat <= t_reached)):
        raise ValueError(f"times must lie between 0 and {t_reached:g} s, the span of the run")
    order = np.argsort(flat, kind="stable")
    ascending = flat[order]
    starts = events["t"][events["kind"] != EVENT_KINDS["end"]]  # nothing starts at the end
    last_event = np.searchsorted(starts, ascending, side="right") - 1
    times_behind: dict[float, tuple[list[Row] | None, list[np.ndarray]]] = {}
    for event in np.unique(last_event):
        rows = rows_to_resume(scene, events, int(event))
        since = -1.0 if rows is None else rows[-1]["t"]
        times_behind.setdefault(since, (rows, []))[1].append(ascending[last_event == event])
    pieces = [
        open_trajectory(scene, resume=rows).state_at(np.concatenate(behind))
        for rows, behind in times_behind.values()
    ]
    columns = {name: [piece[name] for piece in pieces] for name in tables_of(scene).samples}
    return {name: _in_order(parts, order, times.shape) for name, parts in columns.items()}


def _in_order(pieces: list[np.ndarray], order: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    ascending = np.concatenate(pieces) if pieces else np.empty(0)
    values = np.empty_like(ascending)
    values[order] = ascending
    return values.reshape(shape)


# The motion of one end of a part against the other, from the columns of a run.


ROUNDING = 1e-12  # of displacements and velocities: what two that are equal may differ by after 1e4 turns


class PairMotion:
    """x_P - x_Q [m] and v_P - v_Q [m/s] of a part of `scene` with the ends P and Q."""

    def __init__(self, scene: Scene, part: Any):
        self._scene, self._ends = scene, (part.P, part.Q)

    def __call__(self, rows: Mapping[str, np.ndarray], clock: str) -> np.ndarray:
        """Rows t, x_P - x_Q, v_P - v_Q (shape 3 x n); `clock` : name of the column of times [s]."""
        motion, _ = self._with_ends(rows, clock)
        return motion

    def above_rounding(self, rows: Mapping[str, np.ndarray], clock: str) -> np.ndarray:
        """The same with zeros where a difference is all within ROUNDING of what it is the difference of: ends
        that rest on each other move together, and what the subtraction leaves of that is no motion.
        """
        motion, ends = self._with_ends(rows, clock)
        for values, both in zip(motion[1:], zip(*ends, strict=True), strict=True):
            if np.abs(values).max(initial=0) <= ROUNDING * np.abs(both).max(initial=0):
                values[:] = 0
        return motion

    def _with_ends(
        self, rows: Mapping[str, np.ndarray], clock: str
    ) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
        """Rows t, x_P - x_Q, v_P - v_Q, and (x, v) of both ends."""
        time = np.asarray(rows[clock])
        ends = [self._motion(end, rows, time) for end in self._ends]
        (x, v), (other_x, other_v) = ends
        return np.stack([time, x - other_x, v - other_v]), ends

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of states that it needs."""
        bodies = [self._scene.bodies[end].name for end in self._ends if end >= 0]
        return tuple(name for body in bodies for name in columns_of(body))

    def _motion(
        self, end: int, rows: Mapping[str, np.ndarray], time: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        if end == GROUND:
            return np.zeros_like(time), np.zeros_like(time)
        if end == BASE:
            return base_motion(self._scene, time)
        x, v = columns_of(self._scene.bodies[end].name)
        return rows[x], rows[v]


def base_motion(scene: Scene, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement [m] and velocity [m/s] of the base of a scene at times [s]."""
    if scene.base_formula is not None:
        from vibsim.physics.formula_values import motion_of_base

        place, rate, _ = motion_of_base(scene, time)
        return np.full_like(time, place), np.full_like(time, rate)
    x, v = np.zeros_like(time), np.zeros_like(time)
    for term in scene.base:
        angle = 2 * np.pi * np.fmod(term.cycles * time, 1.0) + term.phase
        sine, cosine = sine_cosine_of_arrays(angle)
        x += term.amplitude * sine
        v += term.amplitude * term.omega * cosine
    return x, v


# How fast the ends of a stop approach each other where it is struck.


IMPACT_CODES = [EVENT_KINDS[kind] for kind in IMPACTS]


def closing_velocities(scene: Scene, events: Mapping[str, np.ndarray]) -> np.ndarray:
    """Rate of the depth of the stop at each impact [m/s], > 0; NaN for all other events; shape (n).

    events : columns of the table of events by name, each (n). Contact with an elastic stop begins with the
    velocities of its row, an impact at a rigid one turns those before it round.
    """
    kind, values = events["kind"], np.full(len(events["kind"]), np.nan)
    struck, rigid = np.isin(kind, IMPACT_CODES), kind == EVENT_KINDS["impact"]
    for number, stop in enumerate(scene.stops):
        rows, motion = struck & (events["part"] == number), PairMotion(scene, stop)
        states = {"t": events["t"][rows]}
        for name in motion.columns:
            before = events.get(f"before_{name}", events[name])
            states[name] = np.where(rigid, before, events[name])[rows]
        values[rows] = -stop.sense * motion(states, "t")[2]
    return values


# How often what happened to each part of a run.


COUNTED = {
    "impacts": IMPACTS,
    "transmitted": ("transmitted",),
    "chatters": ("chatter",),
    "rests": ("rest_begin",),
    "sticks": ("stick_begin",),
    "reversals": ("reversal",),
    "violations": ("violation_begin",),
    "jumps": (SWITCH,),
}


def part_counts(result: "Result", scene: Scene) -> dict[str, dict[str, int]]:
    """By name of the part: numbers of impacts, stick phases, reversals and so on; those that are 0 left out
    but for the impacts of a stop and the sticks of a friction.
    """
    names = event_parts(scene)
    kind, part = np.asarray(result.events["kind"]), np.asarray(result.events["part"])
    counts: dict[str, dict[str, int]] = {name: {} for name in names}
    counts |= {stop.name: {"impacts": 0} for stop in scene.stops}
    counts |= {friction.name: {"sticks": 0} for friction in scene.frictions}
    for word, events in COUNTED.items():
        of_kind: Any = part[np.isin(kind, [EVENT_KINDS[event] for event in events]) & (part >= 0)]
        for name, count in zip(names, np.bincount(of_kind, minlength=len(names)).tolist(), strict=True):
            if count:
                counts[name][word] = count
    return {name: counts[name] for name in names}


# The distances that a run needs: the largest x1 - x2, or x_P - x_Q of each clearance, in continuous time.
#
# The blocks do not overlap as long as x1 - x2 stays below their distance at rest. The paper gives none, so a
# run reports what it needs. Between two rows (samples and events in time order) x1 - x2 is the cubic that has
# the displacements and velocities of both; so a maximum between samples is not missed.


REST_DISTANCE = "rest_distance"
Relative = Callable[[Mapping[str, np.ndarray], str], np.ndarray]

# A cubic over h misses at most h^4/384 max|y''''| (Hermite remainder), that is (w h)^4/384 of an amplitude at
# w rad/s: 0.5 % at w h = 1.18. Rows further apart say nothing about the maximum between them.
LARGEST_STEP = 1.18


class Largest:
    """Running maximum of a relative displacement over blocks of samples and events.

    relative : (rows by column name, name of their clock) -> rows t, y, v (shape 3 x n)
    known : whether the samples are close enough to tell
    """

    def __init__(self, relative: Relative, known: bool):
        self._relative, self._known = relative, known
        self._largest = -math.inf
        self._last: np.ndarray | None = None

    @property
    def needed(self) -> float | None:
        """Largest relative displacement so far [m], or None if not known."""
        return self._largest if self._known and math.isfinite(self._largest) else None

    def update(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take the next block of samples (`time`, states) and events (`t`, states)."""
        if not self._known:
            return
        rows = _merge(self._relative(samples, "time"), self._relative(events, "t"))
        if self._last is not None:
            rows = np.concatenate([self._last, rows], axis=1)
        if rows.shape[1]:
            self._largest = max(self._largest, largest_of_cubics(*rows))
            self._last = rows[:, -1:]


class Distances:
    """The distances that a run of `case` needs: those of its clearances, and x1 - x2 of the short form."""

    def __init__(self, case: "Case", scene: Scene):
        watched = {clearance.name: clearance for clearance in scene.clearances}
        pair = {} if case.is_long else {REST_DISTANCE: scene.links[0]}
        self._distances = {name: _largest(scene, part) for name, part in {**pair, **watched}.items()}
        self._clearances = tuple(watched) if case.is_long else ()

    def update(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take the next block of samples and events."""
        for distance in self._distances.values():
            distance.update(samples, events)

    @property
    def attrs(self) -> dict[str, Any]:
        """Attributes of the file, in m: rest_distance_needed of the short form; clearances_needed of the
        long one, in the order of its clearances, all or none.
        """
        if REST_DISTANCE in self._distances and not self._clearances:
            needed = self._distances[REST_DISTANCE].needed
            return {} if needed is None else {"rest_distance_needed": needed}
        all_needed = [self._distances[name].needed for name in self._clearances]
        known = bool(all_needed) and None not in all_needed
        return {"clearances_needed": np.array(all_needed, dtype="f8")} if known else {}


def _largest(scene: Scene, part: Any) -> Largest:
    """The largest x_P - x_Q of a part; stops that it opens are open near it."""
    opened = [stop for stop in scene.stops if _acts_against(stop, part)]
    rate = fastest_rate(scene, [stop for stop in scene.stops if stop not in opened])
    return Largest(PairMotion(scene, part), scene.every_num / scene.every_den * rate <= LARGEST_STEP)


def _acts_against(stop: Stop | RigidStop, part: Any) -> bool:
    """Whether the stop is in contact where x_P - x_Q of the part is small."""
    same, mirrored = (stop.P, stop.Q) == (part.P, part.Q), (stop.Q, stop.P) == (part.P, part.Q)
    return (same and stop.sense == EXTENSION) or (mirrored and stop.sense == COMPRESSION)


def largest_of_cubics(t: np.ndarray, y: np.ndarray, v: np.ndarray) -> float:
    """Maximum of the piecewise cubic through `y` with slopes `v` at the ascending times `t` (1-D)."""
    largest = float(y.max())
    h = np.diff(t)
    # a cubic lies below the largest of its four Bezier ordinates: solve only where these are above all rows
    ordinates = np.maximum(y[:-1] + h * v[:-1] / 3, y[1:] - h * v[1:] / 3)
    for i in np.flatnonzero(ordinates > largest):
        largest = max(largest, _largest_inside(y[i], y[i + 1], h[i] * v[i], h[i] * v[i + 1]))
    return largest


def _largest_inside(y0: float, y1: float, d0: float, d1: float) -> float:
    """Maximum of y(s) = y0 + d0 s + b s^2 + a s^3 on 0 <= s <= 1 with y(1) = y1 and y'(1) = d1."""
    rise = y1 - y0
    a, b = d0 + d1 - 2 * rise, 3 * rise - 2 * d0 - d1
    root = b * b - 3 * a * d0
    if root < 0:
        return max(y0, y1)
    # highest where d0 + 2 b s + 3 a s^2 falls through zero; of the two forms, the one without cancellation
    above, below = (d0, math.sqrt(root) - b) if b <= 0 else (-b - math.sqrt(root), 3 * a)
    if not below or not 0 < above / below < 1:
        return max(y0, y1)
    s = above / below
    return float(max(y0, y1, y0 + s * (d0 + s * (b + s * a))))


def _merge(samples: np.ndarray, events: np.ndarray) -> np.ndarray:
    """Rows t, y, v of both, each ascending, in the order of time; a sample before the events there."""
    places = np.searchsorted(samples[0], events[0], side="right") + np.arange(events.shape[1])
    of_sample = np.ones(samples.shape[1] + events.shape[1], dtype=bool)
    of_sample[places] = False
    rows = np.empty((3, len(of_sample)))
    for row, sampled, happened in zip(rows, samples, events, strict=True):
        row[of_sample] = sampled
        row[places] = happened
    return rows
