"""What `vibsim export` writes of each kind of result."""

from pathlib import Path
from typing import Any

import click

from vibsim.files.errors import ResultFileError
from vibsim.labelled.csv_table import write_table
from vibsim.labelled.extras import MissingExtra
from vibsim.labelled.labelled import Labelled
from vibsim.labelled.parquet_table import write_parquet
from vibsim.labelled.tidy import Tidy
from vibsim.opening import open_result
from vibsim.results.export_csv import write_csv
from vibsim.results.export_mat import write_mat
from vibsim.results.result import Result
from vibsim.results.windows import Window, rows_within

SUFFIXES = (".csv", ".parquet", ".mat")


def suffix_of(output: str) -> str:
    """Suffix of an output, in lower case. Raises UsageError for one that is not written."""
    suffix = Path(output).suffix.lower()
    if suffix not in SUFFIXES:
        raise click.UsageError(f"-o {output}: the suffix must be .csv, .parquet or .mat")
    return suffix


def export_any(
    file: str, output: str, events: bool, window: Window | None, along: str | None, force: bool
) -> None:
    """Write what a file holds. Raises UsageError for options that are not for its kind."""
    suffix_of(output)
    result = open_result(file)
    if result.attrs["vibsim_kind"] == "trajectory":
        if along:
            raise click.UsageError("--along is for sweeps and the like; a run has one dimension")
        export_run(result, file, output, window or (0.0, float("inf")), events, force)
        return
    if events or window:
        raise click.UsageError(
            f"{'--events' if events else '--window'} is for runs, and {file} holds something else"
        )
    export_table(result, file, output, along or "", force)


def export_run(result: Result, file: str, output: str, window: Window, events: bool, force: bool) -> None:
    """Write the samples or the events of a run within the window [s]."""
    _check(result, window, file, events)
    suffix = suffix_of(output)
    if suffix == ".mat":
        write_mat(result, output, window, force)
    elif suffix == ".csv":
        write_csv(result, output, window, force, events)
    else:
        time = result.event_column("t") if events else result.column("time")
        table = Tidy((result.events if events else result).arrays())
        _parquet(table, output, force, rows_within(time, window))


def export_table(result: Any, file: str, output: str, along: str, force: bool) -> None:
    """Write a result of labelled arrays as a tidy table."""
    suffix = suffix_of(output)
    if not isinstance(result, Labelled):
        raise ResultFileError(f"{file}: holds a {result.attrs['vibsim_kind']}, which is no table")
    if suffix == ".mat":
        raise click.UsageError(
            f"-o {output}: a MAT file takes a run, and {file} holds something else; try .csv"
        )
    try:
        table = Tidy(result.arrays(), along)
    except ValueError as error:
        raise click.UsageError(f"--along {along}: {error}") from None
    if suffix == ".csv":
        write_table(table, output, force)
    else:
        _parquet(table, output, force)


def _parquet(table: Tidy, output: str, force: bool, rows: slice = slice(None)) -> None:
    try:
        write_parquet(table, output, force, rows)
    except MissingExtra as error:
        raise click.UsageError(f"-o {output}: {error}") from None


def _check(result: Result, window: Window, file: str, events: bool) -> None:
    """Usage error for a window with nothing of the run in it; beside samples, events may be missing."""
    time = result.column("time")
    times = [time, result.event_column("t")] if events else [time]
    within = [rows_within(column, window) for column in times]
    if all(rows.start == rows.stop for rows in within):
        last = float(time[-1]) if len(time) else 0.0
        shown = ":".join(f"{end:g}" for end in window)
        raise click.UsageError(
            f"--window {shown}: nothing of {file} lies in it; its samples end at {last:g} s"
        )
