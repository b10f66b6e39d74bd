"""hard/a-million-seconds: impacts, periodic from early on, so that the truth of one period is that of all."""

from collections.abc import Iterator
from functools import partial
from math import ulp
from typing import Any

import numpy as np

from vibsim.cases import load_case
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.hard.hard_cases import BECAUSE, LUCK, PERIODIC, UNITS, certificate, distance
from vibsim.evidence.verification.row import Row, compared, counted_row, worst_row
from vibsim.evidence.verification.runs import bare_run, flows_of
from vibsim.evidence.verification.truths.truth_file import Truth, read_truth
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results import Result

PERIOD = 8.0  # of the force [s]
SETTLED = 1600.0  # errors fall by exp(-c 8 s / (2 m1)) = 0.2 in each period: to 1e-139 in 200 of them


def checks() -> list[Check]:
    """The case by both flows."""
    case = load_case(PERIODIC)
    return [
        Check(f"{PERIODIC}/{flow}", case.title, partial(rows, flow), long=True) for flow in flows_of(case)
    ]


def rows(flow: str, engine: str) -> Iterator[Row]:
    """States and events of all settled periods."""
    name = f"{PERIODIC}/{flow}"
    case = load_case(PERIODIC)
    truth = read_truth(PERIODIC, case.sha256)
    result = bare_run(case.two_blocks(), engine, flow)
    yield worst_row(name, state_points(truth, result, flow), BECAUSE)
    yield from event_rows(name, truth, result, flow)


def state_points(truth: Truth, result: Result, flow: str) -> Iterator[Any]:
    """Every settled sample against the truth at its phase."""
    phases = {t: i for i, t in enumerate(truth.time)}
    for k in np.flatnonzero(result.time >= SETTLED):
        t = float(result.time[k])
        i = phases[t % PERIOD]
        for column, values in truth.states.items():
            value, bound = float(result[column][k]), LUCK * truth.stray[flow][column][i]
            yield compared(
                f"{column} at {t:g} s",
                float(values[i]),
                value,
                bound + 2.0**-53 * abs(value),
                UNITS[column],
                distance(value, values[i]),
            )


def event_rows(name: str, truth: Truth, result: Result, flow: str) -> Iterator[Row]:
    """Number of the settled events, and how far they are from where the period has them."""
    kinds, times = result.events["kind"][1:-1], result.events["t"][1:-1]
    late, each = times >= SETTLED, len(truth.events)
    expected = round((result.time[-1] - SETTLED) / PERIOD) * each
    what = f"settled events ({certificate(result)})"
    yield counted_row(name, what, expected, int(late.sum()), "all periods are alike")
    if late.sum() != expected:
        return
    known = [EVENT_KINDS[kind] for kind, _ in truth.events]
    wrong = int(np.count_nonzero(kinds[late].reshape(-1, each) != known))
    yield counted_row(name, "events of another kind", 0, wrong, "all periods are alike")
    phases = np.fmod(times[late], PERIOD).reshape(-1, each)
    points = []
    for i, (kind, t) in enumerate(truth.events):
        far = phases[np.argmax(np.abs(phases[:, i] - float(t))), i]
        bound = LUCK * truth.event_stray[flow][i] + ulp(result.t_reached)
        points.append(compared(f"{kind} within a period", float(t), float(far), bound, "s"))
    yield worst_row(name, points, f"{BECAUSE}; the grid of time is 1.2e-10 s at the end")
