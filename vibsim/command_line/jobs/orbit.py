"""What `vibsim orbit` does: read, find, refine, store, print."""

from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibsim.cases import Case
from vibsim.command_line.errors import FILE_TROUBLE, told
from vibsim.command_line.jobs.run_plan import check_digits, check_engine, hdf5_name, read_case
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import Progress
from vibsim.command_line.text.orbit import orbit_lines, orbit_object, orbit_row
from vibsim.command_line.text.quantities import counted, size
from vibsim.command_line.text.summary import heading, print_lines
from vibsim.engine.columns import state_columns
from vibsim.files.errors import ResultFileError
from vibsim.files.output_file import check_output
from vibsim.files.signals import interrupted_with
from vibsim.opening import open_result
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.orbit_file import save_orbit
from vibsim.orbits.search.searching import search_attempts
from vibsim.orbits.search.seeking import INITIAL, orbit
from vibsim.results import Result, kind_of, names_a_result


@dataclass(frozen=True)
class Wish:
    """What a command line asks for."""

    source: str
    changes: dict[str, str]
    start: str | None
    at_start: bool
    period: int | None
    digits: int | None
    engine: str
    output: str | None
    force: bool

    def check(self) -> None:
        """Raises UsageError and ResultFileError before anything is computed."""
        check_engine(self.engine)
        check_digits(self.digits, "auto")
        if self.output is not None:
            check_output(hdf5_name(self.output), self.force)

    def subject(self) -> "Case | Result":
        """The run in a file, or a case. Raises CaseError and ResultFileError."""
        if names_a_result(self.source) and kind_of(self.source) == "trajectory":
            return _run(self.source)
        return read_case(self.source, {})

    def beginning(self) -> Result | None:
        """The stored orbit to start from."""
        if self.start is None:
            return None
        stored = _run(self.start)
        if stored.orbit is None:
            raise ResultFileError(f"{self.start}: holds a run and no orbit; give it in place of the case")
        return stored

    def check_likeness(self, case: Case, stored: Result | None) -> None:
        """Raise ResultFileError where the orbit to start from is one of other bodies than the case has."""
        if stored is None:
            return
        case = case.with_values(self.changes) if self.changes else case
        missing = [name for name in state_columns(case.scene()) if name not in stored]
        if missing:
            raise ResultFileError(
                f"{self.start}: holds an orbit of {stored.case.name}; to start from it, {case.name} also "
                f"needs {', '.join(missing)}"
            )


def _run(path: str) -> Result:
    if kind_of(path) != "trajectory":
        raise ResultFileError(f"{path}: holds no single run")
    result: Result = open_result(path)
    return result


@dataclass(frozen=True)
class Row:
    """An orbit, its many digits and its file, where they are asked for."""

    orbit: Orbit
    digits: Any
    file: str | None
    trouble: ResultFileError | None = None  # why there is no file

    @property
    def object(self) -> dict[str, Any]:
        """The orbit for programs."""
        return ({"file": self.file} if self.file else {}) | orbit_object(self.orbit, self.digits)

    @property
    def file_line(self) -> list[tuple[str, str]]:
        return [("file", f"{self.file} ({size(self.file)})")] if self.file else []


def find_one(wish: Wish, settings: Settings) -> int:
    """Find one orbit and print it; returns the exit code."""
    subject, beginning = wish.subject(), wish.beginning()
    wish.check_likeness(subject.case if isinstance(subject, Result) else subject, beginning)
    with interrupted_with(lambda: f"{wish.output} is not written" if wish.output else ""):
        start = INITIAL if wish.at_start else beginning
        row = _kept(orbit(subject, wish.changes, start, wish.period, wish.engine), wish, wish.output)
    if settings.json:
        print_json(row.object | _error_object(row.trouble))
    elif not settings.quiet:
        case = row.orbit.case
        assert case is not None  # the wish names one
        say(heading(case.name, case.title))
        print_lines([*orbit_lines(row.orbit, row.digits), *row.file_line])
    return _code(row.trouble)


def _code(trouble: ResultFileError | None) -> int:
    """The exit code, and on stderr why an orbit that was printed is not stored."""
    return 0 if trouble is None else told(f"Error: {trouble}", FILE_TROUBLE, as_json=False)


def _error_object(trouble: ResultFileError | None) -> dict[str, Any]:
    """The same for programs."""
    return {} if trouble is None else {"error": {"message": str(trouble), "exit_code": FILE_TROUBLE}}


def _kept(orbit: Orbit, wish: Wish, path: str | None) -> Row:
    """An orbit refined and stored; where its digits are not to be had, it is stored without them, and where
    it cannot be stored, it is there to be printed.
    """
    try:
        digits = _refined(orbit, wish)
    except BaseException as error:
        if path is not None:
            save_orbit(orbit, path, wish.force)
        if path is not None and isinstance(error, KeyboardInterrupt):
            raise type(error)(f"{path} holds the orbit without the digits") from error
        raise
    try:
        if path is not None:
            save_orbit(orbit, path, wish.force, digits)
    except ResultFileError as error:
        return Row(orbit, digits, None, error)
    return Row(orbit, digits, path)


def _refined(orbit: Orbit, wish: Wish) -> Any:
    """The orbit in many digits, where they are asked for."""
    if wish.digits is None:
        return None
    from vibsim.orbits.orbit_digits import refine

    return refine(orbit, wish.digits)


def search_all(wish: Wish, count: int, seed: int, settings: Settings) -> int:
    """Look from many starts and list what is there, each stored as it comes; returns the exit code."""
    _check_numbered(wish)
    subject = wish.subject()
    case = subject.case if isinstance(subject, Result) else subject
    case = case.with_values(wish.changes) if wish.changes else case
    rows, done = list[Row](), 0
    steps = Progress(not settings.quiet)
    with Interruption() as interruption, closing(steps), suppress(KeyboardInterrupt):  # of a start given up
        for attempt in search_attempts(case, count, seed, wish.period, wish.engine):
            for each in attempt.orbits:
                rows.append(_kept(each, wish, _numbered(wish, len(rows) + 1)))
            done = attempt.number + 1
            steps.show("starts", done, count)
            if interruption.signum is not None or any(row.trouble for row in rows):
                break
    trouble = next((row.trouble for row in rows if row.trouble), None)
    if settings.json:
        orbits = {"starts": done, "seed": seed, "orbits": [row.object for row in rows]}
        print_json(orbits | _error_object(trouble))
    elif not settings.quiet:
        _print_list(case, rows, done)
    if interruption.signum is not None:
        files = f"; what was found is in {rows[0].file} and on" if rows and rows[0].file else ""
        say(f"interrupted after {done} of {count} starts{files}", err=True)
        return interruption.exit_code
    return _code(trouble)


def _numbered(wish: Wish, number: int) -> str | None:
    """The file of an orbit of a search: NAME-1.h5, ..."""
    if wish.output is None:
        return None
    path = Path(wish.output)
    return str(path.with_name(f"{path.stem}-{number}{path.suffix}"))


def _check_numbered(wish: Wish) -> None:
    """Raise ResultFileError for orbits of another search where the files of this one are to be."""
    number = 1
    while (name := _numbered(wish, number)) is not None and (number == 1 or Path(name).exists()):
        check_output(name, wish.force)
        number += 1


def _print_list(case: Case, rows: list[Row], done: int) -> None:
    say(heading(case.name, case.title))
    print_lines([("orbits", f"{len(rows)} from {counted(done, 'start')}")])
    for number, row in enumerate(rows, 1):
        print_lines([(f"{number}", orbit_row(row.orbit)), *row.file_line])
        if row.digits is not None:
            print_lines(row.digits.lines())
