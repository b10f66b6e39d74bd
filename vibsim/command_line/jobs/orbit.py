"""What `vibsim orbit` does: read, find, refine, store, print."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibsim.cases import Case
from vibsim.command_line.jobs.run_plan import check_digits, check_engine, hdf5_name, read_case
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import Progress
from vibsim.command_line.text.orbit import orbit_lines, orbit_object, orbit_row
from vibsim.command_line.text.quantities import counted, size
from vibsim.command_line.text.summary import heading, print_lines
from vibsim.files.errors import ResultFileError
from vibsim.files.output_file import check_output
from vibsim.opening import open_result
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.orbit_file import save_orbit
from vibsim.orbits.searching import search_attempts
from vibsim.orbits.seeking import orbit
from vibsim.results import Result, is_result_file, kind_of


@dataclass(frozen=True)
class Wish:
    """What a command line asks for."""

    source: str
    changes: dict[str, str]
    start: str | None
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
        if self.source != "-" and is_result_file(self.source) and kind_of(self.source) == "trajectory":
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


def _run(path: str) -> Result:
    if kind_of(path) != "trajectory":
        raise ResultFileError(f"{path}: holds no single run")
    result: Result = open_result(path)
    return result


def find_one(wish: Wish, settings: Settings) -> int:
    """Find one orbit and print it; returns the exit code."""
    found = orbit(wish.subject(), wish.changes, wish.beginning(), wish.period, wish.engine)
    refined = _refined(found, wish)
    if wish.output is not None:
        save_orbit(found, wish.output, wish.force, refined)
    if settings.json:
        print_json(({"file": wish.output} if wish.output else {}) | orbit_object(found, refined))
    elif not settings.quiet:
        assert found.case is not None  # the wish names one
        say(heading(found.case.name, found.case.title))
        print_lines([*orbit_lines(found, refined), *_file_line(wish.output)])
    return 0


def _file_line(path: str | None) -> list[tuple[str, str]]:
    return [] if path is None else [("file", f"{path} ({size(path)})")]


def _refined(found: Orbit, wish: Wish) -> Any:
    """The orbit in many digits, where they are asked for."""
    if wish.digits is None:
        return None
    from vibsim.orbits.orbit_digits import refine

    return refine(found, wish.digits)


def search_all(wish: Wish, count: int, seed: int, settings: Settings) -> int:
    """Look from many starts and list what is there; returns the exit code."""
    subject = wish.subject()
    case = subject.case if isinstance(subject, Result) else subject
    case = case.with_values(wish.changes) if wish.changes else case
    orbits, done = [], 0
    steps = Progress(not settings.quiet)
    with Interruption() as interruption:
        try:
            for attempt in search_attempts(case, count, seed, wish.period, wish.engine):
                done = attempt.number + 1
                orbits += attempt.orbits
                steps.show("starts", done, count)
                if interruption.signum is not None:
                    break
        finally:
            steps.close()
    refined = [_refined(each, wish) for each in orbits]
    files = _stored(wish, orbits, refined)
    if settings.json:
        objects = [orbit_object(*each) for each in zip(orbits, refined, strict=True)]
        named = (
            [{"file": file} | told for file, told in zip(files, objects, strict=True)] if files else objects
        )
        print_json({"starts": done, "seed": seed, "orbits": named})
    elif not settings.quiet:
        _print_list(case, orbits, refined, done, files)
    if interruption.signum is not None:
        say(f"interrupted after {done} of {count} starts", err=True)
        return interruption.exit_code
    return 0


def _stored(wish: Wish, orbits: list[Orbit], refined: list[Any]) -> list[str]:
    """The files that the orbits are stored in: NAME-1.h5, ..."""
    if wish.output is None:
        return []
    path = Path(wish.output)
    names = [str(path.with_name(f"{path.stem}-{i}{path.suffix}")) for i in range(1, len(orbits) + 1)]
    for name in names:
        check_output(name, wish.force)
    for name, each, digits in zip(names, orbits, refined, strict=True):
        save_orbit(each, name, wish.force, digits)
    return names


def _print_list(case: Case, orbits: list[Orbit], refined: list[Any], done: int, files: list[str]) -> None:
    say(heading(case.name, case.title))
    print_lines([("orbits", f"{len(orbits)} from {counted(done, 'start')}")])
    for i, each in enumerate(orbits):
        print_lines([(f"{i + 1}", orbit_row(each)), *_file_line(files[i] if files else None)])
        if refined[i] is not None:
            print_lines(refined[i].lines())
