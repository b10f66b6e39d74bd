"""The rows of a run in time order: samples, events and stroboscopic points, each with its mode."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vibsim.engine.columns import section_columns
from vibsim.engine.trajectory import Block
from vibsim.physics.two_blocks import TwoBlocks


@dataclass(frozen=True)
class Rows:
    """A stretch of a run.

    Attributes
    ----------
    states : `time` and the states by name, each (n), ascending in time
    contact, friction : mode from each row on (n)
    section : positions of the stroboscopic points among the rows
    """

    states: dict[str, np.ndarray]
    contact: np.ndarray
    friction: np.ndarray
    section: np.ndarray

    def __len__(self) -> int:
        return len(self.contact)

    def since(self, t: float) -> "Rows":
        """The rows from time t [s] on."""
        return self._from(int(np.searchsorted(self.states["time"], t, side="left")))

    def last(self) -> "Rows":
        """The last row alone, which begins the next stretch; it is no stroboscopic point there again."""
        row = self._from(len(self) - 1)
        return Rows(row.states, row.contact, row.friction, row.section[:0])

    def _from(self, first: int) -> "Rows":
        states = {name: column[first:] for name, column in self.states.items()}
        section = self.section[self.section >= first] - first
        return Rows(states, self.contact[first:], self.friction[first:], section)

    def followed_by(self, later: "Rows") -> "Rows":
        """These rows and later ones as one stretch."""
        states = {name: np.concatenate([column, later.states[name]]) for name, column in self.states.items()}
        contact, friction = (
            np.concatenate(pair) for pair in ((self.contact, later.contact), (self.friction, later.friction))
        )
        return Rows(states, contact, friction, np.concatenate([self.section, later.section + len(self)]))


class Merger:
    """Merges the tables of block after block; remembers the mode from one to the next."""

    def __init__(self, scene: TwoBlocks):
        self.names = section_columns(scene.as_parts())
        self._mode = (0, 1)  # contact, friction of a scene that has neither

    def merge(self, block: Block) -> Rows:
        """The rows of a block: at one instant a sample comes before an event, and that before the section."""
        events = {**block.events, "time": block.events["t"]}
        tables: list[Mapping[str, np.ndarray]] = [block.samples, events, block.section]
        states = {name: np.concatenate([table[name] for table in tables]) for name in self.names}
        order = np.argsort(states["time"], kind="stable")
        first = len(states["time"]) - len(block.section["time"])
        states = {name: column[order] for name, column in states.items()}
        contact, friction = self._modes(block, states["time"])
        return Rows(states, contact, friction, np.flatnonzero(order >= first))

    def _modes(self, block: Block, times: np.ndarray) -> list[np.ndarray]:
        """Modes change at events only, so each row has that of the last event at or before it."""
        event = np.searchsorted(block.events["t"], times, side="right")
        codes = [
            np.concatenate([[before], block.events.get(name, np.full(len(block.events["t"]), before))])
            for name, before in zip(("contact", "friction"), self._mode, strict=True)
        ]
        self._mode = int(codes[0][-1]), int(codes[1][-1])
        return [code[event] for code in codes]
