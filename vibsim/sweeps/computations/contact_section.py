"""The Poincare section at contact: the states in which the last contacts began (there g = 0)."""

from typing import Any

from vibsim.engine.trajectory import Block
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.sweeps.computations.contacts import Contacts
from vibsim.sweeps.statistics.columns import Column
from vibsim.sweeps.statistics.measured_run import MeasuredRun

TITLE = "Poincare section at the beginning of contact"
_AT = "at the last beginnings of contact"
COLUMNS = {
    "contact_velocity": Column("m s-1", f"v1 - v2 (v1 where block 2 is fixed) {_AT}", "stop", "contact"),
    "contact_phase": Column("1", f"phase of the source in turns, 0 to 1, {_AT}", "stop source", "contact"),
    "contact_speed": Column("Hz", f"motor speed {_AT}", "stop motor", "contact"),
}


class ContactSection:
    """The last contacts of one run."""

    def __init__(self, scene: TwoBlocks, begin: float, section: int):
        self._contacts, self._count = Contacts(scene, begin), section

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._contacts.update(block)

    def values(self, window: tuple[float, float], run: MeasuredRun, found: dict[str, Any]) -> dict[str, Any]:
        """The last contacts, oldest first."""
        table = self._contacts.table()
        first = max(len(table["t"]) - self._count, 0)
        return {f"contact_{name}": column[first:] for name, column in table.items() if name != "t"}
