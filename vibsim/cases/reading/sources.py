"""Where cases come from: a path, a shipped name, or standard input; size and encoding checked."""

import re
import sys
from os.path import exists, isdir, isfile, normpath
from pathlib import Path
from typing import NamedTuple

from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.spelling import did_you_mean

LARGEST_FILE = 1_000_000  # bytes
HDF5_SIGNATURE = b"\x89HDF"
ASCII_TEXT = re.compile("[\t\n\r -~]*")
CONTROL = "[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"  # what YAML forbids
SUFFIXES = (".yaml", ".yml")
RESULTS = (".h5", ".hdf5", ".partial")
HARD, GALLERY = "hard/", "gallery/"  # folders of shipped cases, and how their names begin


class SourceText(NamedTuple):
    """The text of one case file.

    Attributes
    ----------
    shown : path as the user gave it, for messages
    stem : name of the case where the file gives none
    text : the YAML text
    folder : where an `extends` of this file looks for relative paths
    identity : tells whether two sources are the same file
    """

    shown: str
    stem: str
    text: str
    folder: Path
    identity: str


def shipped_folder() -> Path:
    """The folder of the shipped cases, installed or in a checkout."""
    from importlib import resources

    try:
        return Path(str(resources.files("vibsim.shipped_cases").joinpath("II-B.yaml"))).parent
    except ModuleNotFoundError:
        return Path(__file__).resolve().parents[3] / "cases"


def shipped_case_names() -> list[str]:
    """Names of the shipped cases, sorted: I-A, I-A-eq211, ... II-C."""
    return sorted(path.stem for path in shipped_folder().glob("*.yaml"))


def hard_case_names() -> list[str]:
    """Names of the cases that are hard to compute, sorted: hard/a-million-seconds, ... hard/..."""
    return _names_in(HARD)


def gallery_case_names() -> list[str]:
    """Names of the published models and examples, sorted: gallery/bilinear-oscillator, ... gallery/..."""
    return _names_in(GALLERY)


def _names_in(folder: str) -> list[str]:
    return sorted(f"{folder}{path.stem}" for path in (shipped_folder() / folder).glob("*.yaml"))


def is_path(source: str) -> bool:
    """True for what names a file: it ends in .yaml or .yml or has a folder in it."""
    return source.lower().endswith(SUFFIXES) or "/" in source or "\\" in source


def find_source(source: str, folder: Path | None = None) -> SourceText:
    """Read the case file that `source` names: a path, a shipped name, or "-" for standard input.

    Relative paths count from `folder`: that of the file which names the source (default: the current one, for
    what the user names). Raises CaseError where there is no such file, or where it is too large or no UTF-8
    text; a file may only name regular files, because opening another kind can wait for ever.
    """
    if source == "-":
        text = decoded(sys.stdin.buffer.read(LARGEST_FILE + 1), "stdin")
        return SourceText("stdin", "stdin", text, Path(), "-")
    path = Path(source)
    if source.startswith((HARD, GALLERY)) and source in _names_in(source.partition("/")[0] + "/"):
        path = shipped_folder() / f"{source}.yaml"
        return _file(path, str(path))
    if is_path(source):
        if folder is None:
            return _file(path, str(path))
        path = path if path.is_absolute() else Path(normpath(folder / path))
        if exists(path) and not isfile(path) and not isdir(path):
            raise CaseError([Problem(str(path), None, None, "", "is no regular file")])
        return _file(path, str(path))
    if source in shipped_case_names():
        path = shipped_folder() / f"{source}.yaml"
        return _file(path, str(path))
    raise CaseError([Problem(source or '""', None, None, "", _no_such_case(source))])


def called_as_result(source: str) -> bool:
    """Whether a source has the name of a result file, which holds no text."""
    return source.lower().endswith(RESULTS)


def _no_case_but(source: str) -> str:
    """What a source with the name of a result file is instead of a case."""
    if isdir(source):
        return _no_case_but_a_folder(Path(source))
    if not isfile(source):
        return "no such file"
    try:
        with open(source, "rb") as file:
            is_result = file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    except OSError:
        is_result = True
    if not is_result:
        return "is not an HDF5 file, as its name says; a case file ends in .yaml"
    return "is a result and no case file; vibsim info --case prints its case"


def _no_case_but_a_folder(path: Path) -> str:
    inside = [f"{path}/*{suffix}" for suffix in SUFFIXES if any(path.glob(f"*{suffix}"))]
    others = f"; for those in it write {' '.join(inside)}" if inside else _shipped_in(path)
    return f"is a folder, not a case file{others}"


def _shipped_in(path: Path) -> str:
    """The shipped cases whose names begin as a folder is called; empty for other folders."""
    names = _names_in(f"{path}/") if f"{path}/" in (GALLERY, HARD) else []
    return f"; shipped are {', '.join(names)}" if names else ""


def _no_such_case(source: str) -> str:
    if called_as_result(source):
        return _no_case_but(source)
    if isdir(source):
        return _no_case_but_a_folder(Path(source))
    if f"{source}/" in (GALLERY, HARD):
        return f"is no shipped case{_shipped_in(Path(source))}"
    names = shipped_case_names()
    inner = [f"{folder}{source}" for folder in (GALLERY, HARD) if f"{folder}{source}" in _names_in(folder)]
    hint = f" (did you mean {inner[0]}?)" if inner else did_you_mean(source, names)
    if isfile(source):  # False too for what no file can be called
        hint = f"; for the file write ./{source}"
    elif isfile(f"{source}.yaml"):
        hint = f"; did you mean the file {source}.yaml?"
    return f"is no shipped case{hint}; shipped are {', '.join(names)}; a file name ends in .yaml"


def _file(path: Path, name: str) -> SourceText:
    try:
        with open(path, "rb") as file:
            raw = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        raise CaseError([Problem(name, None, None, "", _unreadable(path, error))]) from None
    return SourceText(name, path.stem, decoded(raw, name), path.parent, str(path.resolve()))


def _unreadable(path: Path, error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        names = shipped_case_names()
        near = f"; the shipped case is called {path.stem}" if path.stem in names else _shipped_in(path)
        if str(path).startswith((HARD, GALLERY)):
            near = did_you_mean(str(path), [*hard_case_names(), *gallery_case_names()])
        return f"no such file{near}"
    if isinstance(error, IsADirectoryError):
        return _no_case_but_a_folder(path)
    return f"cannot be read: {getattr(error, 'strerror', None) or error}"


def decoded(raw: bytes, name: str) -> str:
    """Bytes of a case file as text. Raises CaseError for large, binary and non-UTF-8 files."""
    if raw.startswith(HDF5_SIGNATURE):
        raise CaseError([Problem(name, None, None, "", "is an HDF5 file, not a YAML case file")])
    if len(raw) > LARGEST_FILE:
        raise CaseError([Problem(name, None, None, "", "is larger than 1 MB; a case file has about 2 kB")])
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        what = f"is not UTF-8 text (byte 0x{raw[error.start]:02x}); save the file as UTF-8"
        raise CaseError([_at(name, raw[: error.start].decode("utf-8", "replace"), what)]) from None
    control = None if ASCII_TEXT.fullmatch(text) else re.search(CONTROL, text)
    if control:
        what = f"holds the control character 0x{ord(control[0]):02x}; is it a binary file?"
        raise CaseError([_at(name, text[: control.start()], what)])
    return text


def _at(name: str, before: str, message: str) -> Problem:
    """A problem right behind the text `before`."""
    line = before.count("\n") + 1
    column = len(before) - (before.rfind("\n") + 1) + 1
    return Problem(name, line, column, "", message)


def case_name_from(stem: str) -> str:
    """A case's name from its file's name: what a name may not hold becomes "_"."""
    name = re.sub(r"[^A-Za-z0-9._+ -]", "_", stem).strip()[:80]
    return name if name[:1].isalnum() and name.isascii() else f"case{name}"[:80]
