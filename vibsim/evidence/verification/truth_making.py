"""Make the stored truths: `make truths`, or python -m vibsim.evidence.verification.truth_making [CASE...].

Each is a run of 40 digits, confirmed by one of 30 digits with the other flow where there is one, and judged
by runs that are kicked as doubles round. Takes half a minute.
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from random import Random
from typing import Any

import numpy as np

from vibsim.cases import Case, hard_case_names, load_case
from vibsim.cases.problems import counted
from vibsim.engine.c_engine import CRun
from vibsim.engine.columns import state_columns
from vibsim.engine.number_forms import WordsForm
from vibsim.evidence.verification.catalogue import CASE_I, SPANS, judged_case
from vibsim.evidence.verification.checks import (
    Event,
    StoredTruth,
    Window,
    flows_of,
    kicked_scene,
    match_events,
    outside,
    reach,
    truth_path,
    write_truth,
)
from vibsim.evidence.verification.hard_cases import CLOSED_FORMS, PERIOD, PERIODIC, REPORTED, SETTLED
from vibsim.physics.numbers import Number
from vibsim.physics.parts import EVENT_NAMES
from vibsim.physics.precision import number_kit

# Runs of many digits for the stored truths, kicked or not.


INSTANTS = 10  # at which states are kept, besides the start


@dataclass(frozen=True)
class TruthRun:
    """A finished run: time [s] and states of its samples, its events."""

    time: list[float]
    states: dict[str, list[Decimal]]
    events: list[Event]


@dataclass(frozen=True)
class TruthPlan:
    """Instructions for a truth: case to run, samples per instant kept, whether events are kept.

    settled, period : where only one period [s] after a settled start [s] is kept
    """

    case: Case
    stride: int
    with_events: bool = True
    settled: float | None = None
    period: float | None = None


def plan(name: str) -> TruthPlan:
    """The plan for a hard case, or for one of the paper's."""
    if name == PERIODIC:
        case = load_case(name, {"run.t_end": f"{SETTLED + PERIOD:g} s", "run.every": f"{PERIOD / 16:g} s"})
        return TruthPlan(case, 1, True, SETTLED, PERIOD)
    case = load_case(name) if name.startswith("hard/") else judged_case(name)
    stride = max(1, (case.two_blocks().sample_count - 1) // INSTANTS)
    return TruthPlan(case, stride, name.startswith("hard/"))


def form_of(digits: int) -> WordsForm[Any]:
    """The numbers of the engine for so many digits."""
    return WordsForm(number_kit(digits))


def run_digits(how: TruthPlan, flow: str, digits: int, seed: int | None = None) -> TruthRun:
    """A run of many digits, kicked where a seed is given."""
    form = form_of(digits)
    kit = form.kit
    doubles = how.case.two_blocks()
    scene = how.case.exact_two_blocks(kit.number, kit.pi)
    scene = replace(scene, t_end=kit.number(doubles.t_end), every_num=scene.every_num * how.stride)
    if seed is not None:
        scene = kicked_scene(scene, kit, Random(seed))
    parts = replace(scene.as_parts(), method=flow)
    run = CRun(parts, form=form, kick=0 if seed is None else seed + 1)
    blocks = zip(*(block[:4] for block in run.blocks()), strict=True)
    samples, _, events, event_codes = (np.concatenate(rows, axis=1) for rows in blocks)
    kinds = [EVENT_NAMES[code] for code in event_codes[0].tolist()]
    finished = TruthRun(
        form.doubles(samples[0]).tolist(),
        {name: _decimals(form, row) for name, row in zip(state_columns(parts), samples[1:], strict=False)},
        list(zip(kinds, _decimals(form, events[0]), strict=True))[1:-1],
    )
    return _kept_part(finished, how)


def _decimals(form: WordsForm[Number], row: np.ndarray) -> list[Decimal]:
    return [Decimal(text) for text in form.texts(row).astype(str).tolist()]


def _kept_part(run: TruthRun, how: TruthPlan) -> TruthRun:
    """The run as its truth keeps it: without events, or one settled period with times from its start."""
    if not how.with_events:
        return replace(run, events=[])
    if how.settled is None:
        return run
    late = [i for i, t in enumerate(run.time) if t >= how.settled]
    return TruthRun(
        [run.time[i] - how.settled for i in late[:-1]],  # the last one is the first of the next period
        {name: [column[i] for i in late[:-1]] for name, column in run.states.items()},
        [(kind, t - Decimal(how.settled)) for kind, t in run.events if t >= how.settled],
    )


DIGITS, FEWER_DIGITS = 40, 30
KICKED_RUNS = 8
CONFIRMED = 1e-6  # of what rounding does: so much the two runs that make a truth may differ at most
NOTHING = 1e-24  # relative to a number: likewise where rounding does nothing


def make_truth(name: str) -> StoredTruth:
    """Compute the truth of a case. Raises ValueError where its two runs do not confirm each other."""
    how = plan(name)
    flows = flows_of(how.case)
    truth = run_digits(how, flows[0], DIGITS)
    other = run_digits(how, flows[-1], FEWER_DIGITS)
    kicked = {
        flow: [run_digits(how, flow, FEWER_DIGITS, seed) for seed in range(KICKED_RUNS)] for flow in flows
    }
    undecided = undecided_spans(truth.events, [other, *(run for runs in kicked.values() for run in runs)])
    events = outside(truth.events, undecided)
    stray = {flow: states_apart(truth, runs) for flow, runs in kicked.items()}
    event_stray = {flow: times_apart(events, runs) for flow, runs in kicked.items()}
    confirm(name, truth, other, stray, (events, event_stray))
    provenance = {
        "digits": DIGITS,
        "numbers": f"{form_of(DIGITS).kit.name} of the engine",
        "flow": flows[0],
        "confirmed_by": f"{flows[-1]}, {FEWER_DIGITS} digits",
        "kicked_runs": KICKED_RUNS,
    }
    return StoredTruth(
        name,
        load_case(name).sha256 if how.period else how.case.sha256,
        provenance,
        truth.time,
        {name: [stored_digits(value) for value in column] for name, column in truth.states.items()},
        stray,
        [(kind, stored_digits(t)) for kind, t in events],
        event_stray,
        undecided,
        how.period,
        how.settled,
    )


def confirm(
    name: str, truth: TruthRun, other: TruthRun, stray: Mapping[str, Any], timing: tuple[Any, Any]
) -> None:
    """ValueError where two runs differ by more than a small part of what rounding does in doubles."""
    for column, apart in states_apart(truth, [other]).items():
        allowed = [min(flow[column][i] for flow in stray.values()) for i in range(len(apart))]
        _confirm(f"{name}: {column}", truth.states[column], apart, allowed)
    events, event_stray = timing
    allowed = [min(flow[i] for flow in event_stray.values()) for i in range(len(events))]
    _confirm(f"{name}: events", [t for _, t in events], times_apart(events, [other]), allowed)


def _confirm(what: str, values: list[Decimal], apart: list[float], allowed: list[float]) -> None:
    for value, distance, rounding in zip(values, apart, allowed, strict=True):
        if distance > max(CONFIRMED * rounding, NOTHING * abs(float(value))):
            raise ValueError(f"{what}: {value:.6g} is known to {distance} only")


def stored_names() -> list[str]:
    """Names of the cases whose truth is stored; the other hard cases have closed forms."""
    hard = [name for name in hard_case_names() if name not in (*CLOSED_FORMS, *REPORTED)]
    return [*CASE_I, *SPANS, *hard]


def main(names: list[str], say: Callable[[str], object] = print) -> None:
    """Make the truths of the cases named, or of all."""
    for name in names or stored_names():
        truth = make_truth(name)
        write_truth(truth, truth_path(name))
        events, spans = counted(len(truth.events), "event"), counted(len(truth.undecided), "span")
        say(f"{name}: {events}, {spans} undecided")


if __name__ == "__main__":
    main(sys.argv[1:])


# How far runs lie apart: their states, the times of their events, and where they disagree about events.


KEPT = 25  # digits of a stored number
WIDENED = 4  # a touch may last some times as long as in the runs that showed it


def states_apart(truth: TruthRun, runs: list[TruthRun]) -> dict[str, list[float]]:
    """Largest distance of the runs from the truth, by column and instant."""
    return {
        name: [
            rounded(max(abs(run.states[name][i] - value) for run in runs)) for i, value in enumerate(column)
        ]
        for name, column in truth.states.items()
    }


def times_apart(events: list[Event], runs: list[TruthRun]) -> list[float]:
    """Largest distance in time [s] of the runs' events from those of the truth."""
    apart, near = [Decimal(0)] * len(events), reach(events)
    for run in runs:
        for i, j in match_events(events, near, run.events).pairs:
            apart[i] = max(apart[i], abs(run.events[j][1] - events[i][1]))
    return [rounded(value) for value in apart]


def undecided_spans(truth: list[Event], runs: list[TruthRun]) -> list[Window]:
    """Spans [s] around the touches, pairs of events, that the truth has and some run has not, or the reverse.

    Every span is as wide as the longest touch asks for: which of them are seen, and how long, is luck.
    """
    late = times_apart(truth, runs)
    touches, longest = [], Decimal(0)
    for run in runs:
        matching = match_events(truth, reach(truth), run.events)
        alone = [(truth[i][1], late[i]) for i in matching.missed]
        alone += [(run.events[j][1], 0.0) for j in matching.spurious]
        if len(alone) % 2:
            raise ValueError(f"an event without its counterpart among those at {alone}")
        alone.sort()
        for (begin, before), (end, behind) in zip(alone[::2], alone[1::2], strict=True):
            touches.append((begin, end))
            longest = max(longest, end - begin + Decimal(max(before, behind)))
    return merged([(begin - WIDENED * longest, end + WIDENED * longest) for begin, end in touches])


def merged(spans: list[Window]) -> list[Window]:
    """The same spans, those that overlap made one."""
    windows: list[Window] = []
    for low, high in sorted(spans):
        if windows and low <= windows[-1][1]:
            windows[-1] = windows[-1][0], max(high, windows[-1][1])
        else:
            windows.append((low, high))
    return [(stored_digits(low), stored_digits(high)) for low, high in windows]


def stored_digits(value: Decimal) -> Decimal:
    """`value` to the digits that are stored."""
    return Decimal(f"{value:.{KEPT - 1}e}")


def rounded(value: Decimal) -> float:
    """A distance to two digits."""
    return float(f"{value:.1e}")
