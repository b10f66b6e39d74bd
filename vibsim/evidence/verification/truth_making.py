"""Make the stored truths: `make truths`, or python -m vibsim.evidence.verification.truth_making [CASE...].

Each is a run of 40 digits, confirmed by one of 30 digits with the other flow where there is one, and judged
by runs that are kicked as doubles round. Takes minutes; needs python-flint.
"""

import sys
from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Any

from vibsim.cases import hard_case_names, load_case
from vibsim.evidence.verification.digits_runs import Run, plan, run_digits
from vibsim.evidence.verification.hard.hard_cases import CLOSED_FORMS, REPORTED
from vibsim.evidence.verification.hard.paper_cases import CASE_I, SPANS
from vibsim.evidence.verification.runs import flows_of
from vibsim.evidence.verification.stray import states_apart, stored_digits, times_apart, undecided_spans
from vibsim.evidence.verification.truths.event_matching import outside
from vibsim.evidence.verification.truths.truth_file import Truth, truth_path, write_truth
from vibsim.physics.arithmetic.number_kits import number_kit

DIGITS, FEWER_DIGITS = 40, 30
KICKED_RUNS = 8
CONFIRMED = 1e-6  # of what rounding does: so much the two runs that make a truth may differ at most
NOTHING = 1e-24  # relative to a number: likewise where rounding does nothing


def make_truth(name: str) -> Truth:
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
        "library": number_kit(DIGITS).library,
        "flow": flows[0],
        "confirmed_by": f"{flows[-1]}, {FEWER_DIGITS} digits",
        "kicked_runs": KICKED_RUNS,
    }
    return Truth(
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


def confirm(name: str, truth: Run, other: Run, stray: Mapping[str, Any], timing: tuple[Any, Any]) -> None:
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
        say(f"{name}: {len(truth.events)} events, {len(truth.undecided)} spans undecided")


if __name__ == "__main__":
    main(sys.argv[1:])
