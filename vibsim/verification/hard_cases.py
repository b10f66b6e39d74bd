"""The hard cases against their stored truths: states at several instants, and every event."""

from collections.abc import Iterator
from decimal import Decimal
from functools import partial
from math import isfinite

import numpy as np

from vibsim.cases import hard_case_names, load_case
from vibsim.physics.modes import EVENT_NAMES
from vibsim.results import Result
from vibsim.verification.check import Check
from vibsim.verification.event_matching import Event, match_events, outside
from vibsim.verification.row import Point, Row, compared, counted_row, worst_row
from vibsim.verification.runs import flows_of, run
from vibsim.verification.truth_file import Truth, read_truth

PERIODIC = "hard/a-million-seconds"  # judged in million_seconds
CLOSED_FORMS = ("hard/a-million-seconds-linear", "hard/tiny-amplitude", "hard/conservative")
# the largest stray of eight kicked runs lies below half its standard deviation once in 2,000 sets
LUCK = 2.0
TELLING = 1e-3  # beyond this part of the motion the bound says nothing: chaos has taken over
UNITS = {"x1": "m", "x2": "m", "v1": "m/s", "v2": "m/s", "phi": "rad", "phidot": "rad/s"}
BECAUSE = "twice the stray of runs of 30 digits that are kicked as doubles round"


def checks() -> list[Check]:
    """One check per case and flow."""
    return [
        Check(f"{name}/{flow}", case.title, partial(rows, name, flow))
        for name, case in ((name, load_case(name)) for name in judged_names())
        for flow in flows_of(case)
    ]


def judged_names() -> list[str]:
    """Names of the hard cases that are judged here."""
    return [name for name in hard_case_names() if name not in (PERIODIC, *CLOSED_FORMS)]


def rows(name: str, flow: str, engine: str) -> Iterator[Row]:
    """States and events of a hard case against its truth."""
    case = load_case(name)
    truth = read_truth(name, case.sha256)
    result = run(case, engine, flow)
    yield worst_row(f"{name}/{flow}", state_points(truth, result, flow), BECAUSE)
    yield event_row(f"{name}/{flow}", truth, result, flow)


def state_points(truth: Truth, result: Result, flow: str) -> Iterator[Point]:
    """Every stored state that rounding leaves something of."""
    at = np.searchsorted(result.time, truth.time)
    for name, column in truth.states.items():
        size = float(max(map(abs, column)))
        values = result[name][at].tolist()
        for t, value, expected, stray in zip(
            truth.time, values, column, truth.stray[flow][name], strict=True
        ):
            bound = LUCK * stray + 2.0**-53 * float(abs(expected))
            if bound <= TELLING * size or size == 0:
                yield compared(
                    f"{name} at {t:g} s",
                    float(expected),
                    value,
                    bound,
                    UNITS[name],
                    distance(value, expected),
                )


def distance(value: float, expected: Decimal) -> float:
    """How far a double is from a decimal, not rounded before the subtraction."""
    return float(abs(Decimal(value) - expected)) if isfinite(value) else value


def event_row(name: str, truth: Truth, result: Result, flow: str) -> Row:
    """All events: the one that comes nearest to its bound, or how many are missed or spurious."""
    found = outside(events_of(result), truth.undecided)
    stray = truth.event_stray[flow]
    bounds = [LUCK * stray[i] + np.spacing(float(t)) for i, (_, t) in enumerate(truth.events)]
    matching = match_events(truth.events, bounds, found)
    points = [
        compared(
            f"{truth.events[i][0]} at {truth.events[i][1]:.6g} s",
            float(truth.events[i][1]),
            float(found[j][1]),
            bounds[i],
            "s",
            float(abs(found[j][1] - truth.events[i][1])),
        )
        for i, j in matching.pairs
    ]
    wrong = len(matching.missed) + len(matching.spurious)
    if wrong or not points:
        row = counted_row(name, "events missed or spurious", 0, wrong, "every event once")
        because, points = row.because, [*row.points]
    else:
        row = worst_row(name, points, BECAUSE)
        because = row.because
    return Row(
        name,
        "events",
        f"{len(truth.events)} events{_open(len(truth.undecided))}",
        f"{len(found)} events{_flaws(matching.missed, matching.spurious)}, {certificate(result)}",
        row.error,
        row.bound,
        row.unit,
        because,
        tuple(points),
    )


def _flaws(missed: list[int], spurious: list[int]) -> str:
    return f", {len(missed)} missed, {len(spurious)} spurious" if missed or spurious else ""


def _open(touches: int) -> str:
    return f", {touches} touches open" if touches else ""


def certificate(result: Result) -> str:
    """What the run says of its own event search."""
    uncertified = int(result.attrs["uncertified"])
    return "certified" if uncertified == 0 else f"{uncertified} stretches without proof"


def events_of(result: Result) -> list[Event]:
    """Kind and time of every event of a run, without start and end."""
    kinds, times = result.events["kind"].tolist(), result.events["t"].tolist()
    return [(EVENT_NAMES[kind], Decimal(t)) for kind, t in zip(kinds, times, strict=True)][1:-1]
