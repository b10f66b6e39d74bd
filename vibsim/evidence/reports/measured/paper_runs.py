"""The runs behind a report: simulated once, and read again as long as they are of the same case.

A trajectory is taken over when its file holds a whole run of this case by this version of vibsim, with its
trust horizon. Anything else at its place is replaced.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from vibsim import __version__
from vibsim.results import ResultFileError, open_trajectory_file, simulate_to_file
from vibsim.results.recording.recording import Watch

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.results import Result

PRINTED = ("I-A", "I-B", "I-C")
EQUAL_FORCE = ("I-A-eq211", "I-B-eq211", "I-C-eq211")
MOTORS = ("II-A", "II-B", "II-C")
HERTZ = ("3.5", "5.5", "6.5")  # of A, B and C
PRINTED_MOTOR = "II-B"  # which the readings are readings of
READINGS = ("II-B-captured", "II-C-escape")
PAPER_RUNS = (*PRINTED, *EQUAL_FORCE, *MOTORS, *READINGS)


class Interrupted(Exception):
    """The user has asked to stop; what was finished is on file."""


def obtain_run(
    case: Case, folder: Path, watch: Watch | None = None, fresh: bool = False
) -> tuple[Result, bool]:
    """The run of a case in FOLDER/NAME.h5, and whether it was simulated: where it had to be, or if `fresh`.

    Raises EngineError when the run fails, ResultFileError when the file cannot be written, and Interrupted
    when `watch` returns False before the end.
    """
    path = folder / f"{case.name}.h5"
    stored = None if fresh else stored_run(case, path)
    if stored is not None:
        return stored, False
    result = simulate_to_file(case, path, force=True, watch=watch)
    if not result.complete:
        raise Interrupted
    return result, True


def stored_run(case: Case, path: Path) -> Result | None:
    """The run on file, if it is whole and of this very case and version."""
    if not path.is_file():
        return None
    try:
        result = open_trajectory_file(path)
        attrs = result.attrs
    except ResultFileError:
        return None
    same = (attrs.get("case_sha256"), attrs.get("vibsim_version")) == (case.sha256, __version__)
    return result if same and attrs.get("complete") and "trust_horizon_s" in attrs else None
