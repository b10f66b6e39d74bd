"""Run a case, into memory or straight into a file."""

from collections.abc import Mapping
from contextlib import closing
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from vibsim.cases.arguments import by_key
from vibsim.files.signals import held_back
from vibsim.results.recording.recording import MemorySink, Recording, Watch
from vibsim.results.result import Result

if TYPE_CHECKING:
    from vibsim.cases import Case


def simulate(
    case: "Case | str | PathLike[str]",
    overrides: Mapping[str, object] | None = None,
    engine: str = "auto",
    trust: bool = True,
    digits: int | str | None = None,
) -> Result:
    """Run a case and keep its samples and events in memory.

    Parameters
    ----------
    case : a Case, the path of a case file or the name of a shipped case
    overrides : values that are changed, as of `load_case`
    engine : "auto" (C where it was built, else Python), "c" or "python"; they agree bit for bit
    trust : whether a second run beside the first tells until when it is right
    digits : decimal digits to carry (20 to 1000), or "auto" for as many as leave ten right ones at the end;
        they are in `result.digits`. None: doubles

    Raises EngineError (in `vibsim.engine.errors`) when the run fails, ValueError for other digits, and
    MultiprecisionMissing (in `vibsim.physics.arithmetic.number_kits`) where neither python-flint nor
    mpmath is there; TypeError where `overrides` is no dict.

    >>> import vibsim
    >>> result = vibsim.simulate("II-B", {"Omega0": "6.5 Hz", "run.t_end": "5 s"})
    >>> len(result), result.complete
    (1001, True)
    """
    from vibsim.cases.loading import load_case

    case = load_case(case, by_key("overrides", overrides, '{"Omega0": "6.5 Hz"}'))
    if digits is not None:
        from vibsim.results.many_digits.truth import truth

        return truth(case, digits, engine)
    recording = Recording(case, engine, trust)
    sink = MemorySink(recording.tables)
    recording.into(sink)
    samples, events = sink.tables()
    return Result({**recording.start, **recording.end()}, samples, events, case=case)


def simulate_to_file(
    case: "Case | str | PathLike[str]",
    path: str | Path,
    engine: str = "auto",
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
    from vibsim.cases.loading import load_case

    case = load_case(case)
    if digits is not None:
        from vibsim.results.many_digits.truth import truth_to_file

        return truth_to_file(case, path, digits, engine, force, watch)
    recording = Recording(case, engine, trust, tangent)
    with closing(recording):
        recording.set_off()  # HDF5 is loaded while the engine runs
        from vibsim.results.stored.trajectory_file import TrajectoryFile
        from vibsim.results.stored.trajectory_writer import TrajectoryWriter

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
