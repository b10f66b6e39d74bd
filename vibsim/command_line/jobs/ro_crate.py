"""A result with its provenance as a Process Run Crate: a folder that says what was run, by what, and to what.

RO-Crate 1.1 (w3id.org/ro/crate/1.1) with the profile Process Run Crate 0.5 (w3id.org/ro/wfrun/process/0.5):
the result file, the case, and `ro-crate-metadata.json`, in which an action joins them to the software.
"""

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

from vibsim.files.errors import ResultFileError, reason
from vibsim.files.signals import held_back
from vibsim.files.writers import open_partial
from vibsim.opening import open_result

CONTEXT = ["https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context"]
CRATE = "https://w3id.org/ro/crate/1.1"
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
METADATA = "ro-crate-metadata.json"
CASE = "case.yaml"
RESOLVED = "case-resolved.yaml"
PIECE = 1 << 20  # bytes
TRIES = 100  # to take the place of a crate that others replace meanwhile
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
    if os.path.lexists(target) and not (force and _holds_nothing_else(target)):
        why = "holds more than a crate" if force else "--force replaces a crate"
        raise ResultFileError(f"{folder}: exists; kept ({why})")


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
    raise ResultFileError(f"{folder}: is written by others all the time; kept")


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
    """What was done: the case in, the file out. A file that says of itself that it is incomplete failed."""
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
