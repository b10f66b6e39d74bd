"""Scenes made of parts from the text of a case, and whole runs of them, for comparison."""

from dataclasses import dataclass

import numpy as np

from vibsim.cases.case import load_case_text
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_NAMES
from vibsim.physics.two_blocks import TwoBlocks


def scene_of(text, changes=None, **run):
    """The scene of a case as a user writes it, with other values and other settings of its run."""
    settings = {f"run.{key}": value for key, value in run.items()}
    return load_case_text(text, {**(changes or {}), **settings}).scene()


@dataclass
class Run:
    samples: dict[str, np.ndarray]
    events: dict[str, np.ndarray]
    section: dict[str, np.ndarray]
    totals: dict[str, float]

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


def opened(scene, **options):
    """A run of `scene`, of two blocks or made of parts, not yet computed."""
    return open_trajectory(scene.as_parts() if isinstance(scene, TwoBlocks) else scene, **options)


def run(scene, most=None, **options):
    """The run of a scene as whole columns, up to its end or to the block with event number `most`; options as
    of `open_trajectory`.
    """
    trajectory, blocks, events = opened(scene, **options), [], 0
    for block in trajectory.blocks():
        blocks.append(block)
        events += len(block.events["t"])
        if most is not None and events >= most:
            break
    tables = [whole([getattr(block, name) for block in blocks]) for name in ("samples", "events", "section")]
    return Run(*tables, trajectory.totals)


def whole(tables):
    """Tables of columns one behind the other."""
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


AT_ONCE = 1e-14  # s: events no further apart are at one instant


def by_instant(events):
    """(kind, part) of events; those at one instant, such as of two stops at one place, sorted: which of them
    comes first is rounding.
    """
    groups, since = [], -1.0
    for t, *told in zip(events["t"].tolist(), events["kind"].tolist(), events["part"].tolist(), strict=True):
        if not groups or t - since > AT_ONCE:
            groups.append([])
            since = t
        groups[-1].append(tuple(told))
    return [one for group in groups for one in sorted(group)]


def outcome(scene, **options):
    """The run, or the sentence with which it failed."""
    try:
        return run(scene, **options)
    except EngineError as error:
        return str(error)


def same_bits(a, b):
    """Whether two arrays are equal in every bit but the sign of zero."""
    return np.array_equal(np.asarray(a) + 0, np.asarray(b) + 0, equal_nan=True)


def differences(one, other):
    """Names of columns and totals in which two runs differ by any bit."""
    found = [name for name in one.samples if not same_bits(one.samples[name], other.samples[name])]
    found += [
        f"section/{name}" for name in one.section if not same_bits(one.section[name], other.section[name])
    ]
    found += [f"events/{name}" for name in one.events if not same_bits(one.events[name], other.events[name])]
    return found + [name for name in one.totals if not same_bits(one.totals[name], other.totals[name])]
