"""Random scenes whose whole runs are held against another way to compute them."""

import random
from dataclasses import replace

import numpy as np
import pytest

from tests.engine.runs import Run, whole
from tests.engine.test_no_room import is_jammed
from tests.engine.whole_truth import faults
from tests.events.true_events import MOST_STEPS, Crawling
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory

ALIKE = 1e-8  # of displacements, or m: far less than what an event more or fewer does


def finished(scene):
    """The run of the C engine; raises Crawling where it takes too long or goes on no further, None where
    bodies are caught between rigid stops.
    """
    trajectory, blocks = open_trajectory(scene, "c"), []
    try:
        for block in trajectory.blocks():
            blocks.append(block)
            if trajectory.totals["steps"] > MOST_STEPS:
                raise Crawling
    except EngineError as error:
        if error.reason != "crushed":
            raise Crawling from error
        assert is_jammed(scene, error.state), scene
        return None
    tables = [whole([getattr(block, name) for block in blocks]) for name in ("samples", "events", "section")]
    return Run(*tables, trajectory.totals)


def certified(run):
    return run is not None and run.totals["uncertified"] == 0


def alike(one, other):
    """Whether two runs have the same events, and displacements that agree; or no motion is possible."""
    if one is None or other is None:
        return one is other
    same = all(one.events[name].tolist() == other.events[name].tolist() for name in ("kind", "part"))
    return same and all(
        np.abs(column - other.samples[name]).max() < ALIKE * max(1.0, np.abs(column).max())
        for name, column in one.samples.items()
        if name.startswith("x_")
    )


def wrong_by_series(scene):
    """[(a certified run by closed form or by Taylor series, its faults)] where both are not alike."""
    runs = [finished(replace(scene, method=method)) for method in ("auto", "taylor")]
    if alike(*runs):
        return []
    judged = [(run, faults(scene, run, ALIKE)) for run in runs if certified(run)]
    return [(run, found) for run, found in judged if found]


def wrong_by_digits(scene):
    """The faults of a certified run."""
    run = finished(scene)
    return faults(scene, run, ALIKE) if certified(run) else []


def in_batches(seeds, size):
    """A parameter `seeds` of a test: those of a range, so many at a time."""
    return pytest.mark.parametrize(
        "seeds", [seeds[i : i + size] for i in range(0, len(seeds), size)], ids=str
    )


def judge(wrong, make, seeds):
    """No scene that `make` draws by a random.Random of the seeds is `wrong`; one in fifty at most takes too
    long or ends with an error.
    """
    given_up = 0
    for seed in seeds:
        scene = make(random.Random(seed))
        try:
            assert wrong(scene) == [], scene
        except Crawling:
            given_up += 1
    assert given_up <= len(seeds) / 50
