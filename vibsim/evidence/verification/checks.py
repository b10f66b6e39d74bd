"""A check: a named piece of the verification that computes its rows afresh; stored truths to compare with.

A stored truth holds states and events of a hard case to 25 digits, and what rounding does to them: one JSON
file per case, made by `make truths` (vibsim.evidence.verification.truth_making). It knows the fingerprint of
its case: a case that has changed since has no truth.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from importlib import resources
from math import inf, ulp
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from vibsim.cases import Case, load_case
from vibsim.cases.case import load_case_text
from vibsim.cases.quantities import number
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.numbers import Kit, Number
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.results import Result, simulate

# One row of the verification: a number as expected and as obtained, its error and the bound of it.


@dataclass(frozen=True)
class CheckPoint:
    """A number of a run held against what it should be; the bound is on the absolute error.

    what : which number, such as "x1 at 4 s"; unit : of all four
    """

    what: str
    expected: float
    obtained: float
    error: float
    bound: float
    unit: str = ""

    @property
    def share(self) -> float:
        """Error as a part of the bound; infinite where the error is no number."""
        if self.error == 0:
            return 0.0
        share = self.error / self.bound if self.bound else inf
        return share if share == share else inf


@dataclass(frozen=True)
class CheckRow:
    """One row of the table.

    check, what : the check that it belongs to, and the number; because : where the bound comes from
    points : everything that was compared, where it was more than one number

    An error that is not within the bound, NaN included, falls short.
    """

    check: str
    what: str
    expected: str
    obtained: str
    error: float
    bound: float
    unit: str
    because: str
    points: tuple[CheckPoint, ...] = ()

    @property
    def name(self) -> str:
        return f"{self.check}: {self.what}"

    @property
    def passed(self) -> bool:
        return bool(self.error <= self.bound)


def number_row(check: str, point: CheckPoint, because: str, points: Iterable[CheckPoint] = ()) -> CheckRow:
    """The row of one number."""
    unit = f" {point.unit}" if point.unit else ""
    return CheckRow(
        check,
        point.what,
        f"{number(point.expected, 10)}{unit}",
        f"{number(point.obtained, 10)}{unit}",
        point.error,
        point.bound,
        point.unit,
        because,
        tuple(points),
    )


def compared(
    what: str, expected: float, obtained: float, bound: float, unit: str = "", error: float | None = None
) -> CheckPoint:
    """A point; the error is the difference unless it is known better."""
    return CheckPoint(
        what, expected, obtained, abs(obtained - expected) if error is None else error, bound, unit
    )


def worst_row(check: str, points: Iterable[CheckPoint], because: str) -> CheckRow:
    """The row of many numbers: it shows the one that comes nearest to its bound, or is furthest beyond it."""
    listed = list(points)
    return number_row(check, max(listed, key=lambda point: point.share), because, listed)


def counted_row(check: str, what: str, expected: int, obtained: int, because: str) -> CheckRow:
    """The row of a whole number, which must be right."""
    return number_row(check, compared(what, expected, obtained, 0.0), because)


@dataclass(frozen=True)
class Check:
    """One check.

    name : such as V3/closed_form or hard/stiff-stop/taylor; title : one line on what it shows
    rows : runs it and yields its rows
    """

    name: str
    title: str
    rows: Callable[[], Iterator[CheckRow]]


# The runs that are verified: through the Python interface, as a user has them.


BOTH = ("closed_form", "taylor")


def run(case: Case, flow: str | None = None) -> Result:
    """Run a case, by one flow where it is named."""
    own_case = case if flow is None else case.with_values({"run.method": flow})
    return simulate(own_case, trust=False)


def bare_run(scene: TwoBlocks, flow: str) -> Result:
    """Run a scene by one flow, without energy ledger: a million seconds of it take longer than the run."""
    trajectory = open_trajectory(replace(scene.as_parts(), method=flow))
    blocks = list(trajectory.blocks())
    samples, events = (_joined([getattr(block, name) for block in blocks]) for name in ("samples", "events"))
    attrs = {**trajectory.totals, "method": flow, "t_reached_s": float(scene.t_end)}
    return Result(attrs, samples, events)


def _joined(tables: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def made_case(text: str, name: str, **values: Any) -> Case:
    """A case from YAML text; values as excitation__A=0.1, where a float stands for all its digits."""
    return load_case_text(text, overrides(values), name)


def named_case(name: str, **values: Any) -> Case:
    """A shipped case, changed likewise."""
    return load_case(name, overrides(values))


def overrides(values: Mapping[str, Any]) -> dict[str, object]:
    """Dotted keys for those of a call."""
    return {key.replace("__", "."): value for key, value in values.items()}


def flows_of(case: Case) -> tuple[str, ...]:
    """The flows that a case can be run by."""
    return ("taylor",) if case.two_blocks().has_motor else BOTH


# Rounding, imitated where it can be seen: runs of many digits that are kicked as a run in doubles is.
#
# A run in doubles rounds every number of its scene, and the state behind every event, for Taylor series
# behind every step. Here the very same is done to a run of many digits, by random signs and known amounts:
# to its numbers by `kicked_scene`, to its states by the engine (`CRun(..., kick=seed)`).
# How far its states and event times then stray tells what an algorithm without faults of its own may be off
# by in doubles: the conditioning of the motion, amplification by impacts and chaos included.


UNIT = 2.0**-53  # unit round-off of doubles
# a number of the scene is rounded once, and what follows from several (k1 + k2, 1/m1 + 1/m2, w0) twice more
SCENE_UNITS = 4
# a state is made of responses right to 6, 8 and 16 units (tests/flows/test_responses.py); KICK of driver.c
STATE_UNITS = 16
NUMBERS = ("m1", "m2", "k1", "c", "k2", "G", "N", "A", "F0", "omega", "m3", "e", "J", "M0", "Omega0")
START = ("x1", "v1", "x2", "v2", "phi", "phidot")


def kicked_scene(scene: TwoBlocks, kit: Kit[Number], rng: Random) -> TwoBlocks:
    """`scene` with every number of it off by SCENE_UNITS, up or down.

    The frequency in Hz stays: both flows reduce the phase with twice the digits of a double.
    """
    numbers = {name: getattr(scene, name) for name in NUMBERS + START}
    return replace(
        scene,
        **{
            name: value * _factor(kit, rng, SCENE_UNITS)
            for name, value in numbers.items()
            if value is not None
        },
    )


def _factor(kit: Kit[Number], rng: Random, units: int) -> Number:
    return 1 + kit.number(rng.choice((-1, 1)) * units * UNIT)


# What rounding may do to a motion that does not amplify errors: the bounds of the cases with a closed form.
#
# Every number of the scene is off by SCENE_UNITS of round-off, which moves the result by as much times its
# conditioning; every event, and every Taylor step, adds STATE_UNITS of the size of the motion. Bounds add the
# absolute values, as if no two errors ever cancelled.


REASON = "rounding: 4 units per number of the scene x conditioning, 16 per event or Taylor step"


def roundings(result: Result, memory: float = inf) -> float:
    """Number of rounded states of the run: one at each event and Taylor step, and the one asked for.

    memory : time [s] in which the motion forgets an error but for the part 1/e; older ones do not count
    """
    steps = result.attrs["steps"] if result.attrs["method"] == "taylor" else 0
    return float(1 + (result.attrs["events"] + steps) * min(1.0, memory / result.t_reached))


def relative_rounding(result: Result, conditioning: float = 1.0, memory: float = inf) -> float:
    """Bound of the error relative to the size of the motion."""
    return UNIT * (SCENE_UNITS * conditioning + STATE_UNITS * roundings(result, memory))


def time_rounding(result: Result, t: float, conditioning: float = 1.0, rate: float = 1.0) -> float:
    """Bound of the error of an event's time t [s], with errors of states turned into time by `rate` [1/s].

    The time itself is a double; numbers of the scene scale it.
    """
    return ulp(t) + UNIT * (SCENE_UNITS * conditioning * t + STATE_UNITS * roundings(result) / rate)


# What rounding may do to a number of a periodic motion that attracts: the bounds of V12 to V17.
#
# A change of 1 of all numbers of the scene moves the number by `conditioning`, the sum of |p dq/dp| over
# them. A rounding at each event, or Taylor step, of a period does no more than as large a change of the
# scene: either persists from period to period and is forgotten as fast. Event times are doubles: half a unit
# in the last place of t each, as much as a shift of the drive by the motion's rate times that.


BECAUSE = (
    "rounding: (4 units of the scene, 16 per event or step of a period, half a unit of t) x conditioning"
)


def settled_bound(conditioning: float, t: float, roundings: float, rate: float = 1.0) -> float:
    """Bound of a number read at t [s]; `roundings` states of a period are rounded; rate [1/s] of motion."""
    return conditioning * (UNIT * (SCENE_UNITS + STATE_UNITS * roundings) + rate * ulp(t) / 2)


def last_digit(places: int) -> float:
    """Half a unit of the last of `places` decimals: how far a printed number may be off."""
    return 0.5 * 10.0**-places


# Stored truths: states and events of a hard case to 25 digits, and what rounding does to them.


# Which events of a run are those of the truth, which are missed and which are spurious.


Event = tuple[str, Decimal]  # kind, time [s]
Window = tuple[Decimal, Decimal]


@dataclass(frozen=True)
class Matching:
    """Result of matching two sequences of events.

    pairs : (index in the truth, index in the run); missed, spurious : indices of those without counterpart
    """

    pairs: list[tuple[int, int]]
    missed: list[int]
    spurious: list[int]


def match_events(truth: Sequence[Event], within: Sequence[float], events: Sequence[Event]) -> Matching:
    """Pair each event of the truth with one of its kind, at most `within` [s] of its own away.

    Both sequences ascend in time. Kinds are matched one by one: two events at one instant have no order.
    """
    pairs: list[tuple[int, int]] = []
    for kind in dict.fromkeys(kind for kind, _ in truth):
        ours = [i for i, event in enumerate(truth) if event[0] == kind]
        theirs = [j for j, event in enumerate(events) if event[0] == kind]
        while ours and theirs:
            i, j = ours[0], theirs[0]
            late = events[j][1] - truth[i][1]
            if abs(late) <= within[i]:
                pairs.append((i, j))
            if late >= -within[i]:
                del ours[0]
            if late <= within[i]:
                del theirs[0]
    missed = set(range(len(truth))).difference(i for i, _ in pairs)
    spurious = set(range(len(events))).difference(j for _, j in pairs)
    return Matching(sorted(pairs), sorted(missed), sorted(spurious))


def reach(events: Sequence[Event]) -> list[float]:
    """Half the time [s] from each event to the nearest other one of its kind; infinite where it is alone."""
    near = [inf] * len(events)
    last: dict[str, int] = {}
    for i, (kind, t) in enumerate(events):
        if kind in last:
            half = float(t - events[last[kind]][1]) / 2
            near[last[kind]], near[i] = min(near[last[kind]], half), half
        last[kind] = i
    return near


def outside(events: Sequence[Event], windows: Sequence[Window]) -> list[Event]:
    """The events that lie in none of the windows."""
    return [event for event in events if not any(low <= event[1] <= high for low, high in windows)]


class TruthError(Exception):
    """A truth that is missing, or that belongs to another version of its case."""


@dataclass(frozen=True)
class StoredTruth:
    """The truth of one case.

    Attributes
    ----------
    case, sha256 : name and fingerprint of the case
    provenance : how it was made: digits, library, flow, what confirmed it
    time : instants of the states [s], doubles
    states : columns at these instants, SI
    stray : per flow and column, how far runs that are kicked as doubles round stray from the truth, likewise
    events : kind and time [s] of every event, without start and end
    event_stray : per flow, the same for the times of the events [s]
    undecided : spans of time in which rounding decides whether there is a pair of events or none [s]
    period : where the motion is periodic after `settled` [s]: its period [s]; times then count from there
    settled : see period; None where all of the run is stored
    """

    case: str
    sha256: str
    provenance: dict[str, Any]
    time: list[float]
    states: dict[str, list[Decimal]]
    stray: dict[str, dict[str, list[float]]]
    events: list[Event]
    event_stray: dict[str, list[float]]
    undecided: list[Window]
    period: float | None = None
    settled: float | None = None


def truths_folder() -> Path:
    """The folder of the stored truths."""
    return Path(str(resources.files("vibsim.evidence.verification") / "truths"))


def truth_path(case_name: str) -> Path:
    """Path of the stored truth of a case: hard/stiff-stop in stiff-stop.json."""
    return truths_folder() / f"{case_name.rpartition('/')[2]}.json"


def read_truth(case_name: str, sha256: str) -> StoredTruth:
    """The stored truth of a case with this fingerprint. Raises TruthError."""
    path = truth_path(case_name)
    if not path.is_file():
        raise TruthError(f"{case_name}: no truth is stored; make truths computes it")
    truth = _from_json(json.loads(path.read_text(encoding="utf-8")))
    if truth.sha256 != sha256:
        raise TruthError(f"{case_name}: the case has changed since its truth was computed; make truths")
    return truth


def write_truth(truth: StoredTruth, path: Path) -> None:
    """Write a truth, one list a line."""
    path.write_text(_text(_to_json(truth)) + "\n", encoding="utf-8")


def _text(value: Any, indent: str = "") -> str:
    """JSON with the keys of an object below one another."""
    if not isinstance(value, dict):
        return json.dumps(value)
    inner = indent + " "
    lines = [f"{inner}{json.dumps(name)}: {_text(part, inner)}" for name, part in value.items()]
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"


def _to_json(truth: StoredTruth) -> dict[str, Any]:
    return {
        "case": truth.case,
        "case_sha256": truth.sha256,
        "made": truth.provenance,
        "time": truth.time,
        "states": {name: [str(value) for value in column] for name, column in truth.states.items()},
        "stray": truth.stray,
        "event_kinds": [kind for kind, _ in truth.events],
        "event_times": [str(t) for _, t in truth.events],
        "event_stray": truth.event_stray,
        "undecided": [str(t) for window in truth.undecided for t in window],
        "period": truth.period,
        "settled": truth.settled,
    }


def _from_json(values: dict[str, Any]) -> StoredTruth:
    edges = [Decimal(text) for text in values["undecided"]]
    return StoredTruth(
        values["case"],
        values["case_sha256"],
        values["made"],
        values["time"],
        {name: [Decimal(text) for text in column] for name, column in values["states"].items()},
        values["stray"],
        list(zip(values["event_kinds"], map(Decimal, values["event_times"]), strict=True)),
        values["event_stray"],
        list(zip(edges[::2], edges[1::2], strict=True)),
        values["period"],
        values["settled"],
    )
