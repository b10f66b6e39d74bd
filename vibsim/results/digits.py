"""The digits of a truth run: decimal texts beside the doubles."""

from collections.abc import Iterator, Mapping

import numpy as np

Table = Mapping[str, np.ndarray]


class Digits(Mapping[str, np.ndarray]):
    """Columns of decimal texts (numpy str, 1-D), read and decoded when they are asked for.

    `digits["x1"]` holds the sampled displacements of block 1, `digits.events["t"]` the times of the events,
    each to all the digits carried: str(digits["x1"][-1]) can be given to Decimal, flint.arb or mpmath.mpf.
    """

    def __init__(self, table: Table, events: Table | None = None):
        self.table = table
        self.event_table = {} if events is None else events

    def in_memory(self) -> "Digits":
        """The same, read from its file."""
        return Digits(dict(self.table), dict(self.event_table))

    @property
    def events(self) -> "Digits":
        """The digits of the table of events."""
        return Digits(self.event_table)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.table:
            raise KeyError(f"no digits of {name}; there are those of {', '.join(self.table)}")
        return np.char.decode(self.table[name], "ascii")

    def __iter__(self) -> Iterator[str]:
        return iter(self.table)

    def __len__(self) -> int:
        return len(self.table)
