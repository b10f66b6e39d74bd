"""The events of a run as a table: when, of which kind, of which part, and the state then."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.number import number
from vibsim.files.declarations import Dataset
from vibsim.labelled.arrays import Arrays
from vibsim.labelled.labelled import Labelled, few
from vibsim.labelled.words import words_of

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.files.declarations import Column

SHOWN = 10  # events that a notebook shows


class Events(Labelled, Mapping[str, np.ndarray]):
    """The events of a run, in memory or on file: `events["t"]` is a column (1-D array, SI).

    `kind` and `part` are codes there; `events.words("kind")` are their names, as in `to_dataframe()`.

    >>> import vibsim
    >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
    >>> result.events.words("kind")[0], result.events.words("part")[1]
    ('start', 'friction')
    """

    def __init__(self, table: Mapping[str, np.ndarray], case: "Callable[[], Case]"):
        self._table: Mapping[str, np.ndarray] = table._table if isinstance(table, Events) else table
        self._case = case

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle: with all columns, so that what comes out needs no file."""
        return Events, (dict(self), partial(_itself, self._case()))

    def __getitem__(self, name: str) -> np.ndarray:
        self._check(name)
        return self._table[name]

    def _check(self, name: str) -> None:
        """Raises KeyError with the columns that there are where `name` is none."""
        if name not in self._table:
            raise KeyError(f"no column {name}; these events have {', '.join(self._table)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._table)

    def __len__(self) -> int:
        return len(self._table)

    def column(self, name: str) -> Any:
        """One column; on file a handle that reads only the rows it is indexed with."""
        self._check(name)
        return self._table.column(name) if hasattr(self._table, "column") else self._table[name]

    def words(self, name: str) -> np.ndarray:
        """The words of a column of codes, such as kind, part, or the state of a part (n, objects).

        Raises KeyError for a column that has no words.
        """
        column = self._columns()[name]
        if not column.flags:
            worded = [each for each, column in self._columns().items() if column.flags]
            raise KeyError(f"{name} is no column of codes; such are {', '.join(worded)}")
        return words_of(column, self[name])

    def arrays(self) -> Arrays:
        """The columns over the events."""
        declared = tuple(Dataset(name, column, ("t",)) for name, column in self._columns().items())
        return Arrays(declared, self.__getitem__, ("t",), numbered=True)

    def _columns(self) -> "dict[str, Column]":
        from vibsim.results.columns import tables_of

        columns = tables_of(self._case().scene()).events
        return {name: columns[name] for name in self}

    def heading(self) -> str:
        """How many there are."""
        return f"of {self._case().name}: {len(self.column('t'))}, start and end among them"

    def lines(self) -> list[tuple[str, str]]:
        """How many of each kind and of each part, and the names of the columns."""
        counted = [(label, self._counts(name)) for label, name in (("kinds", "kind"), ("parts", "part"))]
        return [*counted, ("columns", few(self))]

    def _counts(self, name: str) -> str:
        codes, flags = np.asarray(self[name]), self._columns()[name].flags
        counts = ((word, np.count_nonzero(codes == code)) for word, code in flags.items())
        return ", ".join(f"{count} {word}" for word, count in counts if count)

    def _repr_html_(self) -> str:
        from html import escape

        rows = slice(0, SHOWN)
        columns = self._columns()
        shown = {
            name: words_of(column, self.column(name)[rows]) if column.flags else self.column(name)[rows]
            for name, column in columns.items()
        }
        units = [f"{name} [{column.units}]" if column.units else name for name, column in columns.items()]
        head = "".join(f"<th>{escape(text)}</th>" for text in units)
        body = "".join(_row(values) for values in zip(*shown.values(), strict=True))
        left = len(self.column("t")) - SHOWN
        more = f"<div>and {left} more</div>" if left > 0 else ""
        return f"<div><b>Events {escape(self.heading())}</b><table><tr>{head}</tr>{body}</table>{more}</div>"


def _itself(case: "Case") -> "Case":
    return case


def _row(values: tuple[Any, ...]) -> str:
    from html import escape

    texts = (number(value, 6) if isinstance(value, float) else str(value) for value in values)
    return "<tr>" + "".join(f"<td>{escape(text)}</td>" for text in texts) + "</tr>"
