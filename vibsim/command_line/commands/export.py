"""vibsim export: results for spreadsheets, data frames and MATLAB."""

import errno
import hashlib
import json
import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

import click

from vibsim.command_line.options import FILE, WINDOW, Settings, examples
from vibsim.command_line.terminal import print_json, say
from vibsim.results.hdf5_reading import ResultFileError, reason
from vibsim.results.labelled import Labelled, MissingExtra, Tidy, write_parquet, write_table
from vibsim.results.output_files import open_partial
from vibsim.results.result import Result, Window, rows_within, write_csv, write_mat
from vibsim.results.simulation import open_result
from vibsim.signals import held_back, interrupted_with


@click.command(
    "export",
    short_help="Write a result as CSV, Parquet or MAT.",
    epilog=examples(
        "vibsim export II-B.h5 -o II-B.csv",
        "vibsim export II-B.h5 -o impacts.csv --events --window 100:110",
        "vibsim export II-B.h5 -o II-B.mat             # samples and events",
        "vibsim export sommerfeld.h5 -o sommerfeld.parquet",
        "vibsim export sommerfeld.h5 -o points.csv --along section",
        "vibsim export II-B.h5 --ro-crate -o II-B-crate        # a folder with case, versions, checksums",
    ),
)
@click.argument("file", metavar="FILE", type=FILE)
@click.option(
    "-o", "--output", metavar="FILE", type=FILE, required=True,
    help="A .csv, .parquet or .mat file; of --ro-crate a folder.",
)  # fmt: skip
@click.option("--events", is_flag=True, help="Of a run the events, not the samples.")
@click.option("--window", type=WINDOW, metavar="A:B", help="Of a run only this span of time [s].")
@click.option(
    "--along",
    metavar="DIMENSION",
    help="Of a sweep and the like: what has this dimension, such as section, one row per position along it.",
)
@click.option(
    "--ro-crate", "crate", is_flag=True,
    help="Write a folder instead, a Process Run Crate: file, case, versions, checksums.",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Replace an existing output file.")
@click.pass_context
def command(
    ctx: click.Context,
    file: str,
    output: str,
    events: bool,
    window: tuple[float, float] | None,
    along: str,
    crate: bool,
    force: bool,
) -> None:
    """Write what FILE holds as CSV, Parquet or MAT, by the suffix of the output.

    A run: a row per sample, or per event. A sweep, an orbit or a branch: a tidy table, a row per point, with
    the values of the axes in columns of their own. Runs are in SI units and axes in the unit in which they
    were given, to the last digit; codes are written as words. A Parquet file (needs vibsim[parquet]) keeps
    units and the root attributes as metadata; a MAT file holds the columns of a run and a struct `events`.
    """

    with interrupted_with(lambda: f"{output} is not written"):
        if crate:
            return _crate(ctx.obj, file, output, bool(events or window or along), force)
        if events and suffix_of(output) == ".mat":
            raise click.UsageError("--events is for CSV and Parquet; a MAT file holds samples and events")
        export_any(file, output, events, window, along, force)
    if ctx.obj.json:
        print_json({"file": file, "written": [output]})
    elif not ctx.obj.quiet:
        say(f"{output} written", err=True)


def _crate(settings: Settings, file: str, folder: str, narrowed: bool, force: bool) -> None:

    if narrowed:
        raise click.UsageError("--ro-crate takes the file whole; leave --events, --window and --along out")
    written = write_crate(file, folder, force)
    if settings.json:
        print_json({"file": file, "written": written})
    elif not settings.quiet:
        say(f"{folder} written", err=True)


# What `vibsim export` writes of each kind of result.


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


# A result with its provenance as a Process Run Crate: a folder that says what was run, by what, and to what.
#
# RO-Crate 1.1 (w3id.org/ro/crate/1.1) with the profile Process Run Crate 0.5 (w3id.org/ro/wfrun/process/0.5):
# the result file, the case, and `ro-crate-metadata.json`, in which an action joins them to the software.


CONTEXT = ["https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context"]
CRATE = "https://w3id.org/ro/crate/1.1"
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
METADATA = "ro-crate-metadata.json"
CASE = "case.yaml"
RESOLVED = "case-resolved.yaml"
PIECE = 1 << 20  # bytes
TRIES = 100  # to take the place of a crate that others replace meanwhile
BUSY = "is written by others all the time; kept"
HDF5 = "application/x-hdf5"
YAML = "application/yaml"


def write_crate(file: str, folder: str, force: bool = False) -> list[str]:
    """Write the crate of the result in `file` as a folder; the names of the files in it.

    The folder is made beside its name and renamed when it is whole. Raises ResultFileError where the file
    holds no result, and where the folder is there and `force` is not given, or cannot be written.
    """
    open_result(file)
    try:
        target = Path(folder).absolute()
        _check_replaceable(target, folder, force)
        name = Path(file).name.removesuffix(".partial")
        with _new_folder(target) as partial:
            shutil.copyfile(file, partial / name)
            result = open_result(partial / name)  # the file may be another by now
            (partial / CASE).write_text(result.attrs["case_yaml"], encoding="utf-8")
            (partial / RESOLVED).write_text(result.case.to_yaml(), encoding="utf-8")
            metadata = json.dumps(_metadata(result, partial, name), indent=2, ensure_ascii=False)
            (partial / METADATA).write_text(metadata + "\n", encoding="utf-8")
            _take_place(partial, target, folder, force)
    except OSError as error:
        raise ResultFileError(f"{folder}: cannot write: {reason(error)}") from error
    return [str(Path(folder) / each) for each in (METADATA, name, CASE, RESOLVED)]


def _check_replaceable(target: Path, folder: str, force: bool) -> None:
    """Raises ResultFileError where a folder is there that may not be replaced. One that others have replaced
    while it was looked at is looked at again.
    """
    for _ in range(TRIES):
        seen = _number(target)
        if seen is None or (force and _holds_nothing_else(target)):
            return
        if _number(target) == seen:
            why = "holds more than a crate" if force else "--force replaces a crate"
            raise ResultFileError(f"{folder}: exists; kept ({why})")
    raise ResultFileError(f"{folder}: {BUSY}")


def _number(path: Path) -> int | None:
    """The number of a file or folder in its file system, None where there is none."""
    try:
        return os.lstat(path).st_ino
    except FileNotFoundError:
        return None


@contextmanager
def _new_folder(target: Path) -> Iterator[Path]:
    """A folder beside the target, removed at the end where it has got no other name."""
    with ExitStack() as at_the_end:
        with held_back():
            descriptor, partial = open_partial(target, folder=True)
            at_the_end.callback(os.close, descriptor)
            at_the_end.callback(shutil.rmtree, partial, ignore_errors=True)
        yield partial


def _take_place(partial: Path, target: Path, folder: str, force: bool) -> None:
    """Give a whole crate its name. One that is replaced is moved aside before, and removed afterwards."""
    for _ in range(TRIES):
        _check_replaceable(target, folder, force)
        with _new_folder(target) as aside, held_back():
            before = aside / target.name
            with suppress(FileNotFoundError):  # there is none, or no more
                target.rename(before)
            try:
                partial.rename(target)
                return
            except OSError as error:
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):  # or another was faster
                    if before.exists():
                        before.rename(target)
                    raise
    raise ResultFileError(f"{folder}: {BUSY}")


def _holds_nothing_else(folder: Path) -> bool:
    """Whether a folder is a crate, and holds only what the crate names."""
    try:
        described = json.loads((folder / METADATA).read_text(encoding="utf-8"))["@graph"]
        named = {METADATA, *(entity["@id"] for entity in described if entity["@type"] == "File")}
        return {_reference(path.name) for path in folder.iterdir()} <= named
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _reference(name: str) -> str:
    """A file name as a URI path, which has ASCII characters only (RFC 3986)."""
    return quote(os.fsencode(name))


def _metadata(result: Any, folder: Path, name: str) -> dict[str, Any]:
    """The JSON-LD document."""
    attrs = result.attrs
    files = [
        _file(folder, name, HDF5, f"{attrs['vibsim_kind']} of {attrs['case_name']}"),
        _file(folder, CASE, YAML, "the case file as it was given"),
        _file(folder, RESOLVED, YAML, "the case that was run, every default filled in"),
    ]
    return {
        "@context": CONTEXT,
        "@graph": [
            {
                "@id": METADATA,
                "@type": "CreativeWork",
                "conformsTo": {"@id": CRATE},
                "about": {"@id": "./"},
            },
            _root(attrs, [each["@id"] for each in files]),
            {"@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5"},
            _action(attrs, name),
            *_software(attrs),
            *files,
        ],
    }


def _root(attrs: dict[str, Any], parts: list[str]) -> dict[str, Any]:
    return {
        "@id": "./",
        "@type": "Dataset",
        "name": str(attrs["title"]),
        "description": f"A {attrs['vibsim_kind']} of the case {attrs['case_name']}, computed by vibsim",
        "datePublished": attrs["date_created"],
        "conformsTo": {"@id": PROFILE},
        "hasPart": [{"@id": part} for part in parts],
        "mentions": {"@id": "#run"},
    }


def _action(attrs: dict[str, Any], name: str) -> dict[str, Any]:
    """Action of the crate: the case in, the file out. A file that says of itself that it is incomplete
    failed.
    """
    status = "CompletedActionStatus" if attrs.get("complete") else "FailedActionStatus"
    return {
        "@id": "#run",
        "@type": "CreateAction",
        "name": f"{attrs['vibsim_kind']} of {attrs['case_name']}",
        "endTime": attrs["date_created"],
        "actionStatus": {"@id": f"http://schema.org/{status}"},
        "instrument": {"@id": "#vibsim"},
        "object": [{"@id": CASE}, {"@id": RESOLVED}],
        "result": {"@id": _reference(name)},
        "description": f"engine {attrs.get('engine', 'unknown')}, case SHA-256 {attrs['case_sha256']}",
    }


def _software(attrs: dict[str, Any]) -> list[dict[str, Any]]:
    versions = {"Python": attrs["python_version"], "NumPy": attrs["numpy_version"]}
    return [
        {
            "@id": "#vibsim",
            "@type": "SoftwareApplication",
            "name": "vibsim",
            "softwareVersion": attrs["vibsim_version"],
            "operatingSystem": attrs["platform"],
            "softwareRequirements": [{"@id": f"#{name.lower()}"} for name in versions],
        },
        *(_package(name, version) for name, version in versions.items()),
    ]


def _package(name: str, version: str) -> dict[str, Any]:
    kind = "SoftwareApplication"
    return {"@id": f"#{name.lower()}", "@type": kind, "name": name, "softwareVersion": version}


def _file(folder: Path, name: str, kind: str, what: str) -> dict[str, Any]:
    return {
        "@id": _reference(name),
        "@type": "File",
        "name": name.encode("utf-8", "backslashreplace").decode(),
        "description": what,
        "encodingFormat": kind,
        "contentSize": str((folder / name).stat().st_size),
        "sha256": checksum(folder / name),
    }


def checksum(path: Path) -> str:
    """SHA-256 of a file, read in pieces."""
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while piece := file.read(PIECE):
            digest.update(piece)
    return digest.hexdigest()
