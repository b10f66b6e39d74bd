"""The beginnings of contact of a run, block by block: when, how fast, at what phase of the source."""

import math

import numpy as np

from vibsim.engine.trajectory import Block
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.two_blocks import TwoBlocks

TURN = 2 * math.pi


class Contacts:
    """Beginnings of contact from the time `begin` [s] on. Memory grows with their number."""

    def __init__(self, scene: TwoBlocks, begin: float):
        self._scene, self._begin = scene, begin
        self._parts: list[dict[str, np.ndarray]] = []

    def update(self, block: Block) -> None:
        """Take the next block."""
        events = block.events
        chosen = (events["kind"] == EVENT_KINDS["contact_begin"]) & (events["t"] >= self._begin)
        self._parts.append(self._of({name: column[chosen] for name, column in events.items()}))

    def _of(self, events: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        velocity = events["v1"] - events["v2"] if self._scene.has_block2 else events["v1"]
        found = {"t": events["t"], "velocity": velocity}
        if self._scene.has_motor:
            found |= {"phase": events["phase"] / TURN, "speed": events["phidot"] / TURN}
        elif self._scene.source == "harmonic":
            turns = events["t"] * self._scene.cycles + events["t"] * self._scene.cycles_lo
            found["phase"] = turns - np.floor(turns)
        return found

    def table(self) -> dict[str, np.ndarray]:
        """Each (n): t [s], velocity v1 - v2 [m/s], and with a source its phase [turns], speed [Hz]."""
        names = self._parts[0] if self._parts else ("t", "velocity")
        return {name: np.concatenate([part[name] for part in self._parts]) for name in names}
