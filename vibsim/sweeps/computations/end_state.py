"""What a motion without a source that changes comes to: rest, or vibration that goes on.

Judged on the time after the transient, in two halves. Where stops or frictions go on to change their states
in the second half, the motion is a vibration (stick-slip, impacts): events are exact, so no threshold
decides. Where they do not, it is smooth, and rests if its kinetic energy falls from one half to the other.
"""

from typing import Any

import numpy as np

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.physics.modes import EVENT_KINDS, IMPACTS
from vibsim.physics.parts import columns_of
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

TITLE = "rest or vibration, without a source that changes"
NAME = "end_state"
VERDICTS = {"undecided": 0, "rest": 1, "vibration": 2}
OF_FRICTION = ("reversal", "stick_begin", "stick_end")
CHANGES = (*OF_FRICTION, *IMPACTS, "contact_end", "rest_begin", "rest_end")
FALLS = 0.99  # of the greatest kinetic energy in the first half: samples meet its peaks to a hundredth


def columns(of: Quantities) -> Columns:
    """The verdict; none with a source, whose motions have a regime."""
    return {} if of.has_source else {NAME: Column("1", "what the motion comes to", flags=VERDICTS)}


class EndState:
    """What one run comes to. Memory grows with its samples and events after the transient."""

    def __init__(self, task: Task):
        self._begin, bodies = task.begin, task.scene.bodies
        self._half_masses = {columns_of(body.name)[1]: float(body.m) / 2 for body in bodies}
        self._codes = [EVENT_KINDS[kind] for kind in CHANGES]
        self._changes: list[np.ndarray] = []
        self._times: list[np.ndarray] = []
        self._energies: list[np.ndarray] = []

    def update(self, block: Block) -> None:
        """Take the next block."""
        events, samples = block.events, block.samples
        self._changes.append(events["t"][np.isin(events["kind"], self._codes)])
        self._times.append(samples["time"])
        energy = np.zeros(len(samples["time"]))
        for v, half in self._half_masses.items():
            energy = energy + half * samples[v] ** 2
        self._energies.append(energy)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The verdict on the window."""
        middle = (window[0] + window[1]) / 2
        times, energies = np.concatenate(self._times), np.concatenate(self._energies)
        late, early = times >= middle, (times >= window[0]) & (times < middle)
        if any(np.any(changes >= middle) for changes in self._changes):
            return {NAME: float(VERDICTS["vibration"])}
        known = late.any() and early.any()
        falls = known and energies[late].max() <= FALLS * energies[early].max()
        return {NAME: float(VERDICTS["rest" if falls else "undecided"])}
