"""The beginnings of contact of a run, block by block: when, where, how fast, at what phase of the source."""

import math

import numpy as np

from vibsim.engine.columns import part_columns, stop_column
from vibsim.engine.trajectories.blocks import Block
from vibsim.physics.modes import EVENT_KINDS, IMPACTS
from vibsim.physics.period import Period, common_period
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.motions import velocities
from vibsim.sweeps.statistics.quantities import Motion

TURN = 2 * math.pi
BEFORE = "before_"  # of velocities in front of an event, which impacts on rigid stops change
Contact = dict[str, np.ndarray]


class Contacts:
    """Beginnings of contact from the time `begin` [s] on. Memory grows with their number."""

    def __init__(self, task: Task):
        self._task, self._scene = task, task.scene
        self._names = [stop.name for stop in task.scene.stops]
        self._rates = [Motion("", "", "", "", stop.P, stop.Q) for stop in task.scene.stops]
        columns = part_columns(task.scene)
        self._numbers = [columns.index(stop_column(name)) for name in self._names]
        self._period = None if task.scene.has_motor else common_period(task.scene)
        self._parts: list[Contact] = []

    def update(self, block: Block) -> None:
        """Take the next block."""
        events = block.events
        impacts = np.isin(events["kind"], [EVENT_KINDS[kind] for kind in IMPACTS])
        chosen = impacts & (events["t"] >= self._task.begin)
        self._parts.append(self._of({name: column[chosen] for name, column in events.items()}))

    def _of(self, events: Contact) -> Contact:
        columns = {"t": events["t"], "part": events["part"], "velocity": self._velocity(events)}
        if self._scene.has_motor:
            columns |= {"phase": events["phase"] / TURN, "speed": events["phidot"] / TURN}
        elif self._period is not None:
            columns["phase"] = _phase(self._period, events["t"])
        return columns

    def _velocity(self, events: Contact) -> np.ndarray:
        """v_P - v_Q of the stop that each contact is at, in front of it [m/s] (n)."""
        before = {name.removeprefix(BEFORE): c for name, c in events.items() if name.startswith(BEFORE)}
        states = {**events, **before, "time": events["t"]}
        velocity = np.zeros(len(events["t"]))
        for number, each in zip(self._numbers, velocities(self._scene, self._rates, states), strict=True):
            at = events["part"] == number
            velocity[at] = each[at]
        return velocity

    def table(self, stop: str = "") -> Contact:
        """Each (n), of one stop or of all: t [s], velocity v_P - v_Q [m/s], with a source its phase [turns],
        speed [Hz].
        """
        names = self._parts[0] if self._parts else ("t", "part", "velocity")
        whole = {name: np.concatenate([part[name] for part in self._parts]) for name in names}
        number = self._numbers[self._names.index(stop)] if stop else None
        at = whole["part"] == number if stop else slice(None)
        return {name: column[at] for name, column in whole.items() if name != "part"}


def _phase(period: Period, t: np.ndarray) -> np.ndarray:
    """Phase in a common period of `turns` turns [turns of the period], 0 to 1."""
    cycles = t * period.cycles + t * period.cycles_lo
    turns = cycles / period.turns
    return turns - np.floor(turns)
