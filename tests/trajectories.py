"""Whole runs for tests, and their comparison bit by bit."""

from dataclasses import dataclass

import numpy as np

from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_NAMES
from vibsim.physics.two_blocks import TwoBlocks


@dataclass(frozen=True)
class Run:
    """A finished run: samples and events by column, totals."""

    samples: dict
    events: dict
    totals: dict

    @property
    def kinds(self):
        """Names of the events, without start and end."""
        return [EVENT_NAMES[code] for code in self.events["kind"][1:-1].tolist()]

    @property
    def times(self):
        """Times of the events [s], without start and end."""
        return self.events["t"][1:-1]

    def final(self, name):
        """State `name` at the end of the run."""
        return float(self.events[name][-1])

    def row(self, i):
        """Row i of the event table by column name."""
        return {name: column[i] for name, column in self.events.items()}


def opened(scene, resume=None, **options):
    """A run of `scene`, of two blocks or made of parts, not yet computed."""
    parts = scene.as_parts() if isinstance(scene, TwoBlocks) else scene
    return open_trajectory(parts, resume=resume, **options)


def run(scene, resume=None):
    """Run `scene` to its end."""
    return collect(opened(scene, resume))


def collect(trajectory):
    """All blocks of a trajectory as one Run."""
    blocks = list(trajectory.blocks())
    samples = {name: np.concatenate([block.samples[name] for block in blocks]) for name in blocks[0].samples}
    events = {name: np.concatenate([block.events[name] for block in blocks]) for name in blocks[0].events}
    return Run(samples, events, trajectory.totals)


def bits(array):
    """The array as integers: equal where every bit is (so 0.0 differs from -0.0, and NaN equals itself)."""
    return array.view("i8") if array.dtype == np.float64 else array


def assert_same_columns(got, expected):
    assert list(got) == list(expected)
    for name in expected:
        np.testing.assert_array_equal(bits(got[name]), bits(expected[name]), err_msg=name)
