"""Stored truths: states and events of a hard case to 25 digits, and what rounding does to them.

One JSON file per case, made by `make truths` (vibsim.evidence.verification.truth_making). It knows the
fingerprint of its case: a case that has changed since has no truth.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from importlib import resources
from math import inf
from pathlib import Path
from typing import Any

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
    for kind in {kind for kind, _ in truth}:
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
    """Where the truth of a case is stored: hard/stiff-stop in stiff-stop.json."""
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
