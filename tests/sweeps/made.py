"""Short sweeps for the tests, and their comparison bit by bit."""

from contextlib import contextmanager

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.sweeps import sweeping
from vibsim.sweeps.quantities import DONE, NOT_REPRODUCIBLE
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweeping import make_plan
from vibsim.sweeps.workers import LocalWorkers

OMEGA0 = "excitation.Omega0"


def short_case(name="II-B", t_end="4 s", **changes):
    """A shipped case, run for a short while; changes with __ for the point of a key."""
    named = {key.replace("__", "."): value for key, value in changes.items()}
    return load_case(name, {"run.t_end": t_end, **named})


def short_plan(axes=None, case=None, **settings):
    """A plan of a few points of II-B."""
    axes = axes or {OMEGA0: "3:5:0.5 Hz"}
    return make_plan(case or short_case(), [(key, text, "") for key, text in axes.items()], **settings)


SECTIONS = 7


def sweep_of_motors(path):
    """The file of a sweep over motor constants and gaps, carried up and down; and its result."""
    axes, how = {OMEGA0: "3:4:0.5 Hz", "G": "1, 2 mm"}, {"carry_state": True, "direction": "both"}
    result, _ = run_stored(SweepStore(short_plan(axes, section=SECTIONS, **how), path), 2)
    return path, result


def assert_same_points(got, expected):
    """Two tables agree in every bit of what can be reproduced."""
    assert list(got.numbers) == list(expected.numbers)
    for name, array in expected.numbers.items():
        if name not in NOT_REPRODUCIBLE:
            np.testing.assert_array_equal(got.numbers[name].view("i8"), array.view("i8"), err_msg=name)
    for name in ("status", "sha256", "error"):
        np.testing.assert_array_equal(getattr(got, name), getattr(expected, name), err_msg=name)


def run_stored(store, jobs, watch=None):
    """Complete a store on this machine; the result, and whether every point was reached."""
    with LocalWorkers(store.plan.point_settings, jobs) as workers:
        return sweeping.complete(store, workers, watch)


def until(points):
    """A watch that stops a sweep once so many points are there."""
    return lambda table: table.count(DONE) < points


@contextmanager
def batches_of_one():
    """However long this process waits for its turn: a sweep of two workers that is to stop at so many points
    has no more than eight others then, four that came back at once and four under way.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibsim.sweeps.workers.Backlog._batch_size", lambda backlog, workers: 1)
        yield


def complete(plan, path, **options):
    """Run what is missing in a file; the indices computed by this call."""
    store = SweepStore(plan, path, **options)
    before = store.table.status.copy()
    result, finished = run_stored(store, 2)
    assert finished
    return result, [tuple(index) for index in np.argwhere(before != DONE).tolist()]


def swept(plan, path=None, jobs=2):
    """The result of a plan, every point of which is reached; nothing on file unless a path is given."""
    result, finished = run_stored(SweepStore(plan, path), jobs)
    assert finished
    return result


def in_memory(plan):
    """All points of a plan, nothing on file."""
    return swept(plan).table
