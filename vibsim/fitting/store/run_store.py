"""The runs of a fit: in memory, and on file as they come, so that none is computed twice."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from vibsim.files.errors import ResultFileError
from vibsim.files.output_file import check_result_output
from vibsim.files.writers import check_leftover
from vibsim.fitting.goals.measuring import Index
from vibsim.fitting.goals.plan import FitPlan
from vibsim.fitting.store.fit_file import write_fit
from vibsim.fitting.store.stored_fit import read_fit
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.store.journal import Journal

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.fitting.fit_result import FitResult

Runs = dict[Index, Point]


class RunStore:
    """Runs by index, kept in memory; `notes` is what the user should know of what was there before."""

    def __init__(self) -> None:
        self.runs: Runs = {}
        self.attrs: dict[str, str] = {}  # of the file, where there is one
        self.notes: list[str] = []

    def add(self, points: Iterable[Point]) -> None:
        """Keep runs."""
        for point in points:
            self.runs[point.index] = point  # type: ignore[index]

    def close(self, written: bool) -> None:
        """Let go of what is held."""


class FileRunStore(RunStore):
    """Runs that go into the journal of a file at once; those of the file and its journal are there already.

    Raises ResultFileError where the file holds another fit or anything else (unless `force`), where another
    process writes it, or where it cannot be written.
    """

    def __init__(self, plan: FitPlan, path: str | Path, force: bool = False):
        super().__init__()
        self.path = check_result_output(path, force=True)
        check_leftover(path, force)
        self._shown = path
        self._on_file = (-1, False)  # runs, and whether the search had come to its end; no file yet
        self._journal = Journal(self.path, "fit", path)
        try:
            if force:
                self._journal.restart(plan.fingerprint)
            else:
                self._go_on(plan)
        except BaseException:
            self._journal.close(remove=False)
            raise

    def _go_on(self, plan: FitPlan) -> None:
        if self.path.exists():
            attrs, there, _, points = read_fit(Path(self._shown))
            if attrs["fit_sha256"] != plan.fingerprint:
                others = " and ".join(_differences(plan, there.cases, attrs["fit_settings_json"]))
                raise ResultFileError(
                    f"{self._shown}: holds another fit, of other {others}; kept (force=True replaces it)"
                )
            super().add(points)
            self.attrs = {"date_created": attrs["date_created"]}
            self._on_file = (len(self.runs), bool(attrs["complete"]))
        waiting = list(self._journal.read(plan.fingerprint))
        super().add(waiting)
        self.notes += self._journal.notes()
        self._journal.go_on(plan.fingerprint, waiting)

    def add(self, points: Iterable[Point]) -> None:
        batch = list(points)
        super().add(batch)
        self._journal.add(batch)

    def begin(self, result: FitResult) -> None:
        """Make the file, which holds the plan, before the first run; one that is there holds it."""
        if self._on_file < (0, False):
            with suppress(ResultFileError):  # the journal keeps the runs; what is wrong is told at the end
                write_fit(self.path, result)

    def publish(self, result: FitResult) -> None:
        """Write the file of the fit, unless it is there; where that fails, the journal keeps its runs.

        Raises ResultFileError.
        """
        if (len(self.runs), bool(result.attrs["complete"])) <= self._on_file:
            return
        try:
            write_fit(self.path, result)
        except ResultFileError as failure:
            raise self._journal.kept_after(failure) from failure

    def close(self, written: bool) -> None:
        self._journal.close(remove=written)


NAMES = {"free": "free parameters", "starts": "starts", "search": "search settings", "scipy": "scipy",
         "fitting": "version of vibsim"}  # fmt: skip


def _differences(plan: FitPlan, cases: Sequence[Case], stored: str) -> list[str]:
    """What differs between a plan and the fit on file, in words."""
    ours, theirs = json.loads(json.dumps(plan.settings)), json.loads(stored)
    named = [NAMES.get(key, key) for key in ours if ours[key] != theirs.get(key)]
    same_cases = [case.sha256 for case in plan.cases] == [case.sha256 for case in cases]
    return named if same_cases else ["cases", *named]
