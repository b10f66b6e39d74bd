"""The Poincare section at contact: the states in which the last contacts began (there g = 0).

In a scene of named parts each stop has a section of its own.
"""

from typing import Any

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.sweeps.computations.contacts import Contacts
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import RELATIVE_RATE, Quantities

TITLE = "Poincare section at the beginning of contact"


def columns(of: Quantities) -> Columns:
    """Velocity, phase and motor speed at the last contacts of each stop; none without a stop."""
    columns_of_parts: Columns = {}
    for stop in _stops(of):
        at = "at the last beginnings of contact" + (f" with {stop}" if stop else "")
        rate = f"velocity v_P - v_Q of {stop}" if stop else RELATIVE_RATE
        columns_of_parts[_name("velocity", stop)] = Column("m s-1", f"{rate} {at}", dimension="contact")
        if of.has_source:
            columns_of_parts[_name("phase", stop)] = Column(
                "1", f"phase of the source in turns, 0 to 1, {at}", "contact"
            )
        if of.has_motor:
            columns_of_parts[_name("speed", stop)] = Column("Hz", f"motor speed {at}", dimension="contact")
    return columns_of_parts


def _stops(of: Quantities) -> tuple[str, ...]:
    """Names of the stops; of the two blocks' one stop, no name."""
    return (of.stops if of.of_parts else ("",)) if of.has_stop else ()


def _name(quantity: str, stop: str) -> str:
    return f"contact_{quantity}_{stop}" if stop else f"contact_{quantity}"


class ContactSection:
    """The last contacts of one run."""

    def __init__(self, task: Task):
        self._contacts, self._of, self._count = Contacts(task), task.of, task.section

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._contacts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """The last contacts, oldest first."""
        sections: dict[str, Any] = {}
        for stop in _stops(self._of):
            table = self._contacts.table(stop)
            first = max(len(table["t"]) - self._count, 0)
            sections |= {_name(name, stop): column[first:] for name, column in table.items() if name != "t"}
        return sections
