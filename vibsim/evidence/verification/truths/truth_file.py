"""Stored truths: states and events of a hard case to 25 digits, and what rounding does to them.

One JSON file per case, made by `make truths` (vibsim.evidence.verification.truth_making). It knows the
fingerprint of its case: a case that has changed since has no truth.
"""

import json
from dataclasses import dataclass
from decimal import Decimal
from importlib import resources
from pathlib import Path
from typing import Any

from vibsim.evidence.verification.truths.event_matching import Event, Window


class TruthError(Exception):
    """A truth that is missing, or that belongs to another version of its case."""


@dataclass(frozen=True)
class Truth:
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
    return Path(str(resources.files("vibsim.evidence.verification.truths")))


def truth_path(case_name: str) -> Path:
    """Where the truth of a case is stored: hard/stiff-stop in stiff-stop.json."""
    return truths_folder() / f"{case_name.rpartition('/')[2]}.json"


def read_truth(case_name: str, sha256: str) -> Truth:
    """The stored truth of a case with this fingerprint. Raises TruthError."""
    path = truth_path(case_name)
    if not path.is_file():
        raise TruthError(f"{case_name}: no truth is stored; make truths computes it")
    truth = _from_json(json.loads(path.read_text(encoding="utf-8")))
    if truth.sha256 != sha256:
        raise TruthError(f"{case_name}: the case has changed since its truth was computed; make truths")
    return truth


def write_truth(truth: Truth, path: Path) -> None:
    """Write a truth, one list a line."""
    path.write_text(_text(_to_json(truth)) + "\n", encoding="utf-8")


def _text(value: Any, indent: str = "") -> str:
    """JSON with the keys of an object below one another."""
    if not isinstance(value, dict):
        return json.dumps(value)
    inner = indent + " "
    lines = [f"{inner}{json.dumps(name)}: {_text(part, inner)}" for name, part in value.items()]
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"


def _to_json(truth: Truth) -> dict[str, Any]:
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


def _from_json(values: dict[str, Any]) -> Truth:
    edges = [Decimal(text) for text in values["undecided"]]
    return Truth(
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
