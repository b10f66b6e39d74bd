"""A trajectory as users meet it: arrays by name, events, attributes, and its state at any instant."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.problems import counted, one_line
from vibsim.cases.quantities import number
from vibsim.results.file_contents import Dataset
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.labelled import PIECE, Arrays, Labelled, few, words_of
from vibsim.results.output_files import output_file
from vibsim.signals import held_back

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.engine.doubts import Doubt
    from vibsim.results.columns import Digits, Tables
    from vibsim.results.file_contents import Column
    from vibsim.results.recording import TrajectoryWriter


Table = Mapping[str, np.ndarray]


class Result(Labelled):
    """A trajectory, in memory or on file.

    `result["x1"]` is the sampled column x1 (1-D array, SI), `result.events["t"]` an event column, and
    `result.events.to_dataframe()` the table of all events; on file they are read when asked for.
    `result.attrs` says where the trajectory comes from and what came of it.
    `result.digits["x1"]` and `result.digits.events["t"]` are the decimal texts of a run with digits; `digits`
    is None for a run in doubles. `result.orbit["multiplier_real"]` is what the file of a periodic orbit knows
    besides; `orbit` is None for any other run.

    >>> import vibsim
    >>> result = vibsim.simulate("I-A", overrides={"run.t_end": "2 s"})
    >>> result["x1"].shape, result.attrs["uncertified"]
    ((401,), 0)
    """

    def __init__(
        self,
        attrs: dict[str, Any],
        samples: Table,
        events: Table,
        case: "Case | None" = None,
        digits: "Digits | None" = None,
        orbit: Table | None = None,
    ):
        self.attrs = attrs
        self.orbit = orbit
        self.digits = digits
        self._case_of = cache(partial(_case, attrs, case))
        self.events = Events(events, self._case_of)
        self._samples = samples

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle: with all columns, so that what comes out needs no file."""
        digits = self.digits and self.digits.in_memory()
        orbit = None if self.orbit is None else dict(self.orbit)
        return Result, (self.attrs, dict(self._samples), dict(self.events), self.case, digits, orbit)

    def __getitem__(self, name: str) -> np.ndarray:
        self._check(name)
        return self._samples[name]

    def _check(self, name: str) -> None:
        """Raises KeyError with the columns that there are where `name` is none."""
        if name not in self._samples:
            raise KeyError(f"no column {name}; this trajectory has {', '.join(self.keys())}")

    def __contains__(self, name: object) -> bool:
        return name in self._samples

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys())

    def __len__(self) -> int:
        return len(self.column("time"))

    def keys(self) -> list[str]:
        """Names of the sampled columns, `time` first."""
        return list(self._samples)

    def column(self, name: str) -> Any:
        """One sampled column; on file a handle that reads only the rows it is indexed with."""
        self._check(name)
        return _column(self._samples, name)

    def event_column(self, name: str) -> Any:
        """One event column, likewise."""
        return self.events.column(name)

    @property
    def time(self) -> np.ndarray:
        """Times of the samples [s]."""
        return self["time"]

    @property
    def trust_horizon(self) -> float | None:
        """Time until which the displacements are right to the trust tolerance [s].

        It is `t_reached` where they are to the end, None where it was not worked out.
        """
        return self.attrs.get("trust_horizon_s")

    @property
    def error_estimate(self) -> np.ndarray | None:
        """Estimated error of the displacements [m] at each sample; None as above."""
        return self._samples.get("error_estimate")

    @property
    def doubts(self) -> "list[Doubt]":
        """The first few points that the certificate could not prove: `time` [s] near which, `events` by the
        names of the parts, `reason` in words. `attrs["uncertified"]` counts all; older files say no more.
        """
        from vibsim.results.trajectory_file import doubts_in

        return doubts_in(self.attrs)

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return bool(self.attrs["complete"])

    @property
    def t_reached(self) -> float:
        """Time until which everything is known [s]; of a killed run, the time of its last event on file."""
        if "t_reached_s" in self.attrs:
            return float(self.attrs["t_reached_s"])
        times = self.events["t"]
        return float(times[-1]) if len(times) else 0.0

    @property
    def case(self) -> "Case":
        """The case that was run."""
        return self._case_of()

    def at(self, t: float | np.ndarray) -> dict[str, np.ndarray]:
        """States at any instants, as accurate as the run: restarted from the last event before each.

        Parameters
        ----------
        t : time or times [s] between 0 and the end of the run, any shape, any order

        Returns the columns, each of the shape of `t`. Raises ValueError for times outside the run.
        """
        from vibsim.results.columns import states_at

        return states_at(self.case.scene(), self.events, t, self.t_reached)

    def save(self, path: str | Path, force: bool = False) -> Path:
        """Write the trajectory to an HDF5 file and return its path.

        Raises ResultFileError when the file exists and `force` is not given, or cannot be written.
        """
        from vibsim.results.recording import TrajectoryWriter

        with ExitStack() as at_the_end:
            with held_back():
                if self.digits is None:
                    writer = TrajectoryWriter(path, self._tables(), {}, force)
                else:
                    writer = self._truth_writer(path, self.digits, force)
                at_the_end.callback(writer.close)
            writer.append({name: self[name] for name in self.keys()}, dict(self.events))
            if self.orbit is not None:
                self._attach(writer, self.orbit)
            return writer.finish(self.attrs)

    def _attach(self, writer: "TrajectoryWriter", orbit: Table) -> None:
        """Write what is known of a periodic orbit."""
        from vibsim.results.trajectory_file import GROUP, orbit_datasets

        writer.attach(orbit_datasets(orbit), {f"{GROUP}/{name}": orbit[name] for name in orbit})

    def _tables(self) -> "Tables":
        """Columns of the run."""
        from vibsim.results.columns import JUDGEMENTS, tables_of

        judgements = [name for name in JUDGEMENTS if name in self]
        return tables_of(self.case.scene()).judged(judgements)

    @property
    def error_unit(self) -> str:
        """Unit of `error_estimate` and of the tolerance of its horizon: m, of torsional scenes rad."""
        return self._tables().error_unit

    def _truth_writer(self, path: str | Path, digits: "Digits", force: bool) -> Any:
        """A writer that has the digits already."""
        from vibsim.results.recording import TruthWriter

        writer = TruthWriter(path, self._tables(), {}, self.attrs["digits"], force)
        writer.append_digits(digits.table, digits.event_table)
        return writer

    def arrays(self) -> Arrays:
        """The sampled columns over time.

        >>> import vibsim
        >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
        >>> result.arrays().lengths
        {'time': 401}
        """
        columns = self._tables().samples
        declared = tuple(Dataset(name, column, ("time",)) for name, column in columns.items())
        return Arrays(declared, self.__getitem__, ("time",), self.attrs)

    def heading(self) -> str:
        """Name of the case, span, and how many samples and events."""
        count = self.attrs.get("events", len(self.event_column("t")))
        state = "" if self.complete else ", incomplete"
        counts = f"{counted(len(self), 'sample')}, {counted(count, 'event')}"
        return f"{self.case.name}: 0 to {self.t_reached:g} s, {counts}{state}"

    def lines(self) -> list[tuple[str, str]]:
        """Title, method, what happened, until when the run is right, and the names of the columns."""

        return lines_of(self)


def _case(attrs: Mapping[str, Any], case: "Case | None") -> "Case":
    """The case that was run: as it was given, or as the attributes have it."""
    if case is not None:
        return case
    from vibsim.cases import Case

    return Case.from_resolved_json(attrs["case_resolved_json"])


def _column(table: Table, name: str) -> Any:
    return table.column(name) if hasattr(table, "column") else table[name]


# The events of a run as a table: when, of which kind, of which part, and the state then.


SHOWN = 10  # events that a notebook shows


class Events(Labelled, Mapping[str, np.ndarray]):
    """The events of a run, in memory or on file: `events["time"]` is a column (1-D array, SI).

    Files and tables call that column `t`, which is read here too.

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
        return self._table[self._stored(name)]

    def _stored(self, name: str) -> str:
        """The name of a column in the file. Raises KeyError with the columns that there are for another."""
        if name == "time" and "t" in self._table:
            return "t"
        if name not in self._table:
            raise KeyError(f"no column {name}; these events have {', '.join(self._table)}")
        return name

    def __iter__(self) -> Iterator[str]:
        return iter(self._table)

    def __len__(self) -> int:
        return len(self._table)

    def column(self, name: str) -> Any:
        """One column; on file a handle that reads only the rows it is indexed with."""
        name = self._stored(name)
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
        """The case, and the number of events."""
        return f"of {self._case().name}: {len(self.column('t'))}, start and end among them"

    def lines(self) -> list[tuple[str, str]]:
        """Numbers of events of each kind and of each part, and the names of the columns."""
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


# The few lines that tell most about a run.


def lines_of(result: "Result") -> list[tuple[str, str]]:
    """Label and text; what is not known has no line."""
    attrs = result.attrs
    lines = [("title", one_line(result.case.title))] if result.case.title else []
    lines.append(("method", f"{attrs.get('method')} on the {attrs.get('engine')} engine"))
    words = {"impacts": "impact", "sticks": "stick phase"}
    counts = [counted(attrs[name], word) for name, word in words.items() if name in attrs]
    if counts:
        lines.append(("motion", ", ".join(counts)))
    if result.trust_horizon is not None:
        lines.append(("right", _trust(result)))
    if "certified" in attrs:
        doubt = f"{counted(attrs.get('uncertified', 0), 'stretch')} in doubt"
        lines.append(("certificate", "every event proved" if attrs["certified"] else doubt))
    return [*lines, ("columns", few(result.keys()))]


def _trust(result: "Result") -> str:
    tolerance = f"to {number(result.attrs['trust_tolerance_m'], 2)} {result.error_unit}"
    horizon = result.trust_horizon
    assert horizon is not None
    if horizon < result.t_reached:
        return f"{tolerance} until {horizon:.4g} s{unknown_text(result.attrs)}"
    return f"{tolerance} over the whole run"


def unknown_text(attrs: Mapping[str, Any]) -> str:
    """From when on nothing is known of the error of a run, and why; empty where something is to its end."""
    if "trust_known_to_s" not in attrs:
        return ""
    return f"; nothing is known behind {attrs['trust_known_to_s']:.4g} s: {attrs['trust_unknown_why']}"


# Rows of a table that lie within a span of time.


Window = tuple[float, float]


def read_window(window: object) -> Window:
    """A span of time [s] as a user writes it: (100, 110), or the text `100:110`, `:20` or `100:`.

    An open end is infinite. Raises ValueError for anything else, and for a span without length.
    """
    if isinstance(window, str):
        return _ordered(_ends_of(window), f"{window}")
    try:
        first, last = (float(instant) for instant in window)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        words = 'a span is (first, last) in seconds, or a text such as "100:110"'
        raise ValueError(f"{words}, got {window!r:.60}") from None
    return _ordered((first, last), f"{first:g}:{last:g}")


def _ends_of(text: str) -> Window:
    first, colon, last = text.partition(":")
    try:
        span = (float(first) if first.strip() else -math.inf, float(last) if last.strip() else math.inf)
    except ValueError:
        span = (math.nan, math.nan)
    if not colon or math.isnan(span[0]) or math.isnan(span[1]):
        raise ValueError(f"{text!r} is not a span: write FIRST:LAST in seconds, such as 100:110")
    return span


def _ordered(span: Window, text: str) -> Window:
    if not span[0] < span[1]:
        raise ValueError(f"the span {text} is empty: its first instant must come before its last")
    return span


def rows_within(time: Sequence[float] | Any, window: Window) -> slice:
    """Rows whose ascending `time` [s] lies within the window, both ends included."""
    return slice(bisect_left(time, window[0]), bisect_right(time, window[1]))


def pieces(rows: slice, length: int) -> Iterator[slice]:
    """The rows in pieces of at most `length`."""
    for start in range(rows.start, rows.stop, length):
        yield slice(start, min(start + length, rows.stop))


# A trajectory as CSV (RFC 4180): one line of column names, then one line per sample or event, SI units.
#
# Numbers are written so that they read back as the same double. Rows are read and written in pieces: memory
# does not grow with the file.


def write_csv(
    result: Result, path: str | Path, window: Window, force: bool = False, events: bool = False
) -> None:
    """Write the samples (or the `events`) within the window [s] to `path`.

    Raises ResultFileError when `path` exists and `force` is not given, or cannot be written.
    """
    names = list(result.events) if events else result.keys()
    words = _words(result, events)
    columns = [result.event_column(name) if events else result.column(name) for name in names]
    with output_file(path, force, "ascii") as file:
        file.write(",".join(names) + "\r\n")
        for piece in pieces(rows_within(columns[0], window), PIECE):
            values = [
                _texts(column[piece].tolist(), words.get(name))
                for name, column in zip(names, columns, strict=True)
            ]
            file.writelines(",".join(row) + "\r\n" for row in zip(*values, strict=True))


def _words(result: Result, events: bool) -> dict[str, dict[int, str]]:
    """Columns of codes, which are written as words: names of their values."""
    from vibsim.results.columns import tables_of

    tables = tables_of(result.case.scene())
    columns = tables.events if events else tables.samples
    return {
        name: {code: word for word, code in column.flags.items()}
        for name, column in columns.items()
        if column.flags
    }


def _texts(values: list[Any], words: dict[int, str] | None) -> list[str]:
    if words is not None:
        return [words.get(code, str(code)) for code in values]
    return [repr(value) for value in values]


# A trajectory as a MATLAB file (version 5): the columns by name, a struct `events`, a struct `info`.


LARGEST = (1 << 31) - 1  # bytes: version 5 counts them in 32 bits, and MATLAB reads up to here


def write_mat(result: Result, path: str | Path, window: Window, force: bool = False) -> None:
    """Write the samples and events within the window [s] to `path`, SI units.

    Raises ResultFileError when `path` exists and `force` is not given, cannot be written, or gets too large.
    """
    samples = rows_within(result.column("time"), window)
    events = rows_within(result.event_column("t"), window)
    columns = {name: result.column(name) for name in result}
    bytes_needed = (samples.stop - samples.start) * sum(column.dtype.itemsize for column in columns.values())
    if bytes_needed > LARGEST:
        size_text = f"would hold {bytes_needed / 2**30:.1f} GB"
        raise ResultFileError(f"{path}: {size_text}, a MAT file takes 2 GB; export a window, or as CSV")
    from scipy.io import savemat

    contents: dict[str, object] = {name: column[samples] for name, column in columns.items()}
    contents["events"] = {name: result.event_column(name)[events] for name in result.events}
    contents["info"] = {name: _plain(value) for name, value in result.attrs.items()}
    with output_file(path, force) as file:
        savemat(file, contents, do_compression=True, oned_as="column")


def _plain(value: object) -> object:
    return np.float64(value) if isinstance(value, int | float) else value
