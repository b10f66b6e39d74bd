"""Run a case, into memory or straight into a file."""

from collections.abc import Mapping
from contextlib import closing
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibsim.cases.case import by_key, load_case
from vibsim.cases.sources import called_as_result
from vibsim.lazy import FRONT, named
from vibsim.results.hdf5_reading import ResultFileError, check_signature, damage_named, open_hdf5, read_attr
from vibsim.results.recording import MemorySink, Recording, TrajectoryWriter, Watch
from vibsim.results.result import Result
from vibsim.results.trajectory_file import TrajectoryFile
from vibsim.signals import ended_at_once, held_back

if TYPE_CHECKING:
    from vibsim.cases.case import CaseLike


def simulate(
    case: "CaseLike",
    overrides: Mapping[str, object] | None = None,
    trust: bool = True,
    digits: int | str | None = None,
) -> Result:
    """Run a case and keep its samples and events in memory.

    Parameters
    ----------
    case : whatever `load_case` reads: a Case, a file, a shipped name, a dict or YAML text
    overrides : values that are changed, as of `load_case`
    trust : whether a second run beside the first tells until when it is right
    digits : decimal digits to carry (20 to 1000), or "auto" for as many as leave ten right ones at the end;
        they are in `result.digits`. None: doubles

    Raises EngineError (in `vibsim.engine.errors`) when the run fails, ValueError for other digits, and
    MultiprecisionMissing (in `vibsim.physics.precision`) where the engine was not built on words;
    TypeError where `overrides` is no dict.

    >>> import vibsim
    >>> result = vibsim.simulate("II-B", {"Omega0": "6.5 Hz", "run.t_end": "5 s"})
    >>> len(result), result.complete
    (1001, True)
    """

    case = load_case(case, by_key("overrides", overrides, '{"Omega0": "6.5 Hz"}'))
    if digits is not None:
        from vibsim.results.many_digits import truth

        return truth(case, digits)
    recording = Recording(case, trust)
    sink = MemorySink(recording.tables)
    recording.into(sink)
    samples, events = sink.tables()
    return Result({**recording.start, **recording.end()}, samples, events, case=case)


def simulate_to_file(
    case: "CaseLike",
    path: str | Path,
    force: bool = False,
    watch: Watch | None = None,
    trust: bool = True,
    digits: int | str | None = None,
    tangent: tuple[int, float] = (0, 0.0),
) -> Result:
    """Run a case straight into an HDF5 file, in memory that does not grow with the length of the run.

    `watch` is called with how far the run is worked out [s] every few to a hundred milliseconds; when it
    returns False the file is finished as it is, with the attribute `complete` = 0. `tangent` : number of
    Lyapunov exponents to take along, and the time [s] from which they count; a run with digits takes none.

    Raises EngineError when the run fails and ResultFileError when the file cannot be written. Either way what
    was written before is kept beside `path`, in NAME.partial.
    """

    case = load_case(case)
    if digits is not None:
        from vibsim.results.many_digits import truth_to_file

        return truth_to_file(case, path, digits, force, watch)
    recording = Recording(case, trust, tangent)
    with closing(recording):
        recording.set_off()  # the file is made while the engine runs

        writer: TrajectoryWriter | None = None
        try:
            with held_back():
                writer = TrajectoryWriter(path, recording.tables, recording.start, force)
            recording.into(writer, watch)
        except BaseException:
            if writer is not None:
                writer.keep(recording.end())
            raise
    end = recording.end()
    target = writer.finish(end)
    file = TrajectoryFile(target, recording.tables)
    return Result({**recording.start, **end}, file.samples, file.events, case=case)


# Open a trajectory file, and tell what kind of result a file holds.


KINDS = ("trajectory", "sweep", "fit", "branch", "locus", "bench")


@ended_at_once()
def open_result(path: str | Path) -> Any:
    """The Result (SweepResult, FitResult, Branch, BenchResult) in an HDF5 file that vibsim wrote.

    Raises ResultFileError when the file is missing, not readable, foreign, damaged or of a newer format.

    >>> import vibsim
    >>> path = vibsim.simulate(vibsim.load_case("gallery/three-balls")).save("balls.h5")
    >>> vibsim.open_result(path).attrs["impacts"]
    1
    """
    kind = kind_of(path)
    return open_trajectory_file(path) if kind == "trajectory" else named(FRONT[f"open {kind}"])(path)


@ended_at_once()
def kind_of(path: str | Path) -> str:
    """Kind of a result file, one of KINDS; raises as `vibsim.open_result`."""

    with damage_named(Path(path)), open_hdf5(Path(path)) as file:
        kind = str(read_attr(file, "vibsim_kind", "trajectory"))
    if kind not in KINDS:
        raise ResultFileError(f"{path}: holds a {kind!r:.60}, which this vibsim does not read")
    return kind


def names_a_result(source: str | Path) -> bool:
    """Whether a source is a result file, or is called as one that is not there."""

    return str(source) != "-" and (is_result_file(source) or called_as_result(str(source)))


def is_result_file(path: str | Path) -> bool:
    """Whether `path` is a regular file that begins as an HDF5 file does; of a pipe nothing is read.

    One that must not be read is judged by its name, and whoever opens it says so.
    """

    try:
        check_signature(Path(path))
    except ResultFileError as error:
        return isinstance(error.__cause__, PermissionError) and called_as_result(str(path))
    return True


def open_trajectory_file(path: str | Path) -> Any:
    """The Result in a trajectory file; raises as `open_result`, and for no single run."""

    if kind_of(path) != "trajectory":
        raise ResultFileError(f"{path}: holds no single run")
    file = TrajectoryFile(path)
    return Result(file.attrs, file.samples, file.events, case=file.case, digits=file.digits, orbit=file.orbit)


# A run, however it is named: a Result, its file, or a case that is run first.


def as_result(run: "Result | CaseLike", overrides: Mapping[str, object] | None = None) -> Result:
    """The Result itself, that in a file, or that of running a case, some values of which may be changed.

    Raises ResultFileError, CaseError, and TypeError for anything else, and for changes of what has been run.
    """
    if overrides and (
        isinstance(run, Result) or (isinstance(run, str | PathLike) and names_a_result(Path(run)))
    ):
        raise TypeError("overrides change a case before it is run; run the case of the result: result.case")
    if isinstance(run, Result):
        return run
    if isinstance(run, str | PathLike) and names_a_result(Path(run)):
        stored: Result = open_trajectory_file(Path(run))
        return stored
    return simulate(run, overrides)
