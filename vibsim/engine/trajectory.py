"""Runs of scenes made of parts: one contract, two engines that agree bit for bit on doubles.

trajectory = open_trajectory(scene, engine="auto")
for block in trajectory.blocks(): ...
trajectory.totals
"""

from dataclasses import dataclass
from importlib.util import find_spec
from math import inf, nan

import numpy as np

from vibsim.engine.columns import event_columns, part_columns, sample_columns, state_columns
from vibsim.engine.driver import Driver
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.numbers import Doubles

STRETCHES = 512  # of the Python engine between two blocks
ENGINES = ("auto", "c", "python")
OFFSETS = {
    "contact_begin": "stops",
    "contact_end": "stops",
    "violation_begin": "clearances",
    "violation_end": "clearances",
}


@dataclass(frozen=True)
class Block:
    """Samples and events by column name, 1-D arrays; `t_reached` [s]."""

    samples: dict[str, np.ndarray]
    events: dict[str, np.ndarray]
    t_reached: float


def compiled():
    """Whether the C engine was built with this installation."""
    return find_spec("vibsim.engine._engine") is not None


def open_trajectory(scene, engine="auto"):
    """A run of `scene` (a `vibsim.physics.parts.Scene`) from its start, not yet computed.

    engine : "auto" (C where it was built, else Python), "c" or "python"

    Returns an object with `engine`, `blocks()` (an iterator of `Block`s; raises EngineError when the run
    fails) and `totals`. Raises ValueError for another engine, RuntimeError for "c" where it was not built.
    """
    if engine not in ENGINES:
        raise ValueError(f"engine must be one of {', '.join(ENGINES)}, got {engine!r}")
    if engine == "c" and not compiled():
        raise RuntimeError("the C engine was not built; install with a C compiler, or use engine python")
    if engine == "python" or not compiled():
        return PythonTrajectory(scene)
    return CTrajectory(scene)


class Trajectory:
    """What both engines share: how rows of numbers become columns by name."""

    engine = ""

    def __init__(self, scene):
        self.scene = scene
        self.names = sample_columns(scene)
        self.first_part = part_offsets(scene)

    def block(self, samples, sample_codes, events, event_codes):
        """A block from rows: (time, states), part states; (t, states, phase), (kind, part, part states)."""
        states, parts = state_columns(self.scene), part_columns(self.scene)
        table = dict(zip(("time", *states), samples, strict=False))
        table |= dict(zip(parts, sample_codes, strict=True))
        happened = dict(zip(("t", *states), events, strict=False)) | {"phase": events[-1]}
        happened |= {"kind": event_codes[0], "part": self._parts(event_codes[0], event_codes[1])}
        happened |= dict(zip(parts, event_codes[2:], strict=True))
        times = [float(column[-1]) for column in (table["time"], happened["t"]) if len(column)]
        return Block(
            {name: table[name] for name in self.names},
            {name: happened[name] for name in event_columns(self.scene)},
            max(times, default=0.0),
        )

    def _parts(self, kinds, parts):
        """Index among `part_columns`, from the index among parts of its sort; -1 for none."""
        return np.where(parts < 0, -1, parts + self.first_part[kinds]).astype("i1")

    @staticmethod
    def totals_of(counts, certificate, work, first_violation):
        """Counts and margins by name; certificate: (doubts, time of the first, grazing margin, its time)."""
        by_kind = dict(zip(EVENT_KINDS, counts, strict=True))
        uncertified, first_doubt, margin, margin_time = certificate
        return {
            "impacts": by_kind["contact_begin"],
            "sticks": by_kind["stick_begin"],
            "reversals": by_kind["reversal"],
            "events": sum(counts) - by_kind["start"] - by_kind["end"],
            "steps": int(work[0]),
            "evaluations": int(work[1]),
            "uncertified": int(uncertified),
            "first_uncertified_time": first_doubt if uncertified else nan,
            "grazing_margin": margin if margin != inf else nan,
            "grazing_time": margin_time if margin != inf else nan,
            "violations": by_kind["violation_begin"],
            "first_violation_time": first_violation,
        }


def part_offsets(scene):
    """By kind of event: index among `part_columns` of the first part of its sort."""
    first = {"stops": 0, "frictions": len(scene.stops)}
    first["clearances"] = first["frictions"] + len(scene.frictions)
    return np.array([first[OFFSETS.get(kind, "frictions")] for kind in EVENT_KINDS])


class PythonTrajectory(Trajectory):
    """A run on the Python engine."""

    engine = "python"

    def __init__(self, scene):
        super().__init__(scene)
        self.driver = Driver(scene, Doubles)

    def blocks(self):
        """Yield `Block`s until the run ends."""
        while True:
            self.driver.run(STRETCHES)
            samples, events = self.driver.take()
            yield self.block(
                self._states([state for state, _ in samples], phase=False),
                self._codes([status for _, status in samples]),
                self._states([state for _, _, state, _ in events], phase=True),
                np.vstack(
                    [
                        np.array([[kind, part] for kind, part, _, _ in events], dtype="i1").reshape(-1, 2).T,
                        self._codes([status for *_, status in events]),
                    ]
                ),
            )
            if self.driver.finished:
                return

    def _states(self, states, phase):
        rows = []
        for s in states:
            moving = [value for pair in zip(s.x, s.v, strict=True) for value in pair]
            rows.append((s.t, *moving, Doubles.unwind(s.phase, s.turns), s.w, *([s.phase] if phase else [])))
        width = 3 + 2 * len(self.scene.bodies) + phase
        return np.array(rows, dtype="f8").reshape(-1, width).T

    def _codes(self, statuses):
        parts = len(part_columns(self.scene))
        return np.array([status.codes for status in statuses], dtype="i1").reshape(len(statuses), parts).T

    @property
    def totals(self):
        """Counts and margins so far."""
        driver, kept = self.driver, self.driver.flow.certificate
        violated = driver.first_violation
        return self.totals_of(
            driver.counts,
            (kept.uncertified, kept.first_doubt, kept.margin, kept.margin_time),
            (driver.flow.taylor.steps + driver.flow.closed.steps, driver.flow.closed.evaluations),
            nan if violated is None else violated,
        )


class CTrajectory(Trajectory):
    """A run on the C engine."""

    engine = "c"

    def __init__(self, scene):
        super().__init__(scene)
        from vibsim.engine.c_engine import CRun

        self.run = CRun(scene)

    def blocks(self):
        """Yield `Block`s until the run ends; raises EngineError when it fails."""
        for rows in self.run.blocks():
            yield self.block(*rows)

    @property
    def totals(self):
        """Counts and margins so far."""
        tally = self.run.tally
        return self.totals_of(
            tally["counts"],
            tally["certificate"],
            (tally["steps"], tally["evaluations"]),
            tally["first_violation"] if tally["violated_once"] else nan,
        )
