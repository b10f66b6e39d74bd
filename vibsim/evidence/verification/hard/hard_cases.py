"""The hard cases against their stored truths: states at several instants, and every event."""

from collections.abc import Iterator
from decimal import Decimal
from functools import partial
from math import isfinite, ulp

import numpy as np

from vibsim.cases import hard_case_names, load_case
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Point, Row, compared, worst_row
from vibsim.evidence.verification.runs import flows_of, run
from vibsim.evidence.verification.truths.event_matching import Event, Matching, match_events, outside, reach
from vibsim.evidence.verification.truths.truth_file import Truth, read_truth
from vibsim.physics.modes import EVENT_NAMES
from vibsim.results import Result

PERIODIC = "hard/a-million-seconds"  # judged in million_seconds
CLOSED_FORMS = ("hard/a-million-seconds-linear", "hard/tiny-amplitude", "hard/conservative")
# of named parts: judged in reported_failures and spool
REPORTED = (
    "hard/spool-between-stops",
    "hard/zeno-ball",
    "hard/pressed-on-a-stop",
    "hard/held-by-friction",
    "hard/touch-within-a-step",
)
# the largest stray of eight kicked runs lies below half its standard deviation once in 2,000 sets
LUCK = 2.0
TELLING = 1e-2  # of the motion: where the bound is wider, chaos has taken over and nothing is compared
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
    return [name for name in hard_case_names() if name not in (PERIODIC, *CLOSED_FORMS, *REPORTED)]


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
    sizes: dict[str, float] = {}
    for name, column in truth.states.items():
        sizes[UNITS[name]] = max(sizes.get(UNITS[name], 0.0), *(float(abs(value)) for value in column))
    for name, column in truth.states.items():
        size = sizes[UNITS[name]]
        values = result[name][at].tolist()
        for t, value, expected, stray in zip(
            truth.time, values, column, truth.stray[flow][name], strict=True
        ):
            bound = LUCK * stray + 2.0**-53 * float(abs(expected))
            if bound <= TELLING * size:
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
    events = outside(events_of(result), truth.undecided)
    matching = match_events(truth.events, reach(truth.events), events)
    points = [
        event_point(truth.events[i], events[j], LUCK * truth.event_stray[flow][i]) for i, j in matching.pairs
    ]
    wrong = len(matching.missed) + len(matching.spurious)
    shown, because = compared("events", 0.0, wrong, 0.0), "every event once"
    if points and not wrong:
        shown, because = max(points, key=lambda point: point.share), BECAUSE
    return Row(
        name,
        shown.what if shown.what == "events" else f"events, {shown.what}",
        f"{len(truth.events)} events{_open(len(truth.undecided))}",
        f"{len(events)} events{_flaws(matching)}, {certificate(result)}",
        shown.error,
        shown.bound,
        shown.unit,
        because,
        tuple(points),
    )


def event_point(truth: Event, event: Event, bound: float) -> Point:
    """The time of one event, which lies on the grid of doubles."""
    kind, t = truth
    late = float(abs(event[1] - t))
    what = f"{kind} at {t:.6g} s"
    return compared(what, float(t), float(event[1]), bound + ulp(float(t)), "s", late)


def _flaws(matching: Matching) -> str:
    missed, spurious = len(matching.missed), len(matching.spurious)
    return f", {missed} missed, {spurious} spurious" if missed or spurious else ""


def _open(touches: int) -> str:
    return f", {touches} touches open" if touches else ""


def certificate(result: Result) -> str:
    """What the run says of its own event search."""
    uncertified = int(result.attrs["uncertified"])
    return "certified" if uncertified == 0 else f"{uncertified} stretches in doubt"


def events_of(result: Result) -> list[Event]:
    """Kind and time of every event of a run, without start and end."""
    kinds, times = result.events["kind"].tolist(), result.events["t"].tolist()
    return [(EVENT_NAMES[kind], Decimal(t)) for kind, t in zip(kinds, times, strict=True)][1:-1]
