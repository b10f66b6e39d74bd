"""One line of the table of budgets."""

import time
from dataclasses import dataclass, field
from statistics import median


@dataclass
class Row:
    """A budget and what was measured for it.

    Attributes
    ----------
    budget : what the budget limits
    unit : of the figures, such as "ms"; "x" for a ratio
    limit : allowed value; the least allowed where `at_least`; None for a figure without a budget
    figures : the measured values, one per repetition
    notes : lines printed below the table's line
    """

    budget: str
    unit: str
    limit: float | None
    figures: list[float]
    notes: list[str] = field(default_factory=list)
    at_least: bool = False

    @property
    def met(self) -> str:
        if self.limit is None:
            return "-"
        value = median(self.figures)
        return "met" if (value >= self.limit if self.at_least else value <= self.limit) else "NOT MET"

    def __str__(self) -> str:
        low, middle, high = min(self.figures), median(self.figures), max(self.figures)
        sign = ">=" if self.at_least else "<="
        limit = "" if self.limit is None else f"{sign} {self.limit:.4g} {self.unit}"
        ratio = f"{middle / self.limit:.2f}" if self.limit else ""
        measured = f"{middle:.4g} {self.unit} ({low:.4g}-{high:.4g})"
        line = f"{self.budget:<58} {limit:>14} {measured:>32} {ratio:>7}  {self.met}"
        return "\n".join([line, *(f"    {note}" for note in self.notes)])


def stopwatch(call) -> float:
    """Wall time of call() [s]."""
    began = time.perf_counter()
    call()
    return time.perf_counter() - began
