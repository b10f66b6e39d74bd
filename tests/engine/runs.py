"""Whole runs of scenes made of parts, for comparison."""

from dataclasses import dataclass

import numpy as np

from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory


@dataclass
class Run:
    samples: dict[str, np.ndarray]
    events: dict[str, np.ndarray]
    totals: dict[str, float]


def run(scene, engine="auto"):
    """The run of a scene as whole columns."""
    trajectory = open_trajectory(scene, engine)
    blocks = list(trajectory.blocks())
    samples = {name: np.concatenate([b.samples[name] for b in blocks]) for name in blocks[0].samples}
    events = {name: np.concatenate([b.events[name] for b in blocks]) for name in blocks[0].events}
    return Run(samples, events, trajectory.totals)


def outcome(scene, engine):
    """The run, or the sentence with which it failed."""
    try:
        return run(scene, engine)
    except EngineError as error:
        return str(error)


def same_bits(a, b):
    """Whether two arrays are equal in every bit but the sign of zero."""
    return np.array_equal(np.asarray(a) + 0, np.asarray(b) + 0, equal_nan=True)


def differences(one, other):
    """Names of columns and totals in which two runs differ by any bit."""
    found = [name for name in one.samples if not same_bits(one.samples[name], other.samples[name])]
    found += [f"events/{name}" for name in one.events if not same_bits(one.events[name], other.events[name])]
    return found + [name for name in one.totals if not same_bits(one.totals[name], other.totals[name])]
