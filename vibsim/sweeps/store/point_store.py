"""Where the points of a running sweep are kept: in memory and the journal at once, on file now and then."""

import time
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

from vibsim.files.errors import ResultFileError
from vibsim.files.output_file import check_result_output
from vibsim.files.writers import check_leftover
from vibsim.sweeps.plan.capacity import check_memory
from vibsim.sweeps.plan.sweep_plan import Plan
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.statistics.columns import DONE
from vibsim.sweeps.store.differences import differences
from vibsim.sweeps.store.journal import Journal, record_bytes
from vibsim.sweeps.store.provenance import origin, outcome
from vibsim.sweeps.store.stored_plan import read_sweep
from vibsim.sweeps.store.sweep_file import read_column, write_sweep

LEAST_PAUSE = 10.0  # seconds between two writings of the HDF5 file while points come in
LARGEST_SHARE = 0.02  # of the time that writing it may take


class Store:
    """The points of one sweep. `table` holds them; `add` takes more."""

    def __init__(self, plan: Plan, engine: str = "auto"):
        check_memory(plan)
        self.plan = plan
        self.attrs: dict[str, Any] = origin(plan, engine)
        self.table = Table(plan)
        self.notes: list[str] = []  # what the user should know of what was there before

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        pass

    def make_room(self, count: int) -> None:
        """Make sure that so many more points can be kept, before they are computed."""

    def add(self, points: list[Point]) -> None:
        """Keep points."""
        for point in points:
            self.table.put(point)

    @property
    def all_attrs(self) -> dict[str, Any]:
        """The attributes that a file written now would have."""
        return {**self.attrs, **outcome(self.table)}


class FileStore(Store):
    """A store on file: goes on from what the file and its journal hold, and keeps every point from then on.

    Used as a context manager. At its end, whatever ended it, the file holds all points and the journal is
    gone. Raises ResultFileError when the file holds another sweep or anything else (unless `force`), when
    another process writes it, or when it cannot be written.
    """

    def __init__(self, plan: Plan, path: str | Path, engine: str = "auto", force: bool = False):
        super().__init__(plan, engine)
        self.path = check_result_output(path, force=True)
        check_leftover(path, force)
        self._shown = path
        self._record_bytes = record_bytes(plan)
        self._journal = Journal(self.path, shown=path)
        self._next = 0.0  # when the file is written next
        self._on_file = False  # whether the file holds all that the table holds
        try:
            if not force:
                self._go_on()
        except BaseException:
            self._journal.close(remove=False)
            raise

    def _go_on(self) -> None:
        """Take over what the file and the journal hold; they must be of this sweep."""
        if self.path.exists():
            attrs, _, file = read_sweep(Path(self._shown))
            with file:
                self._refuse(differences(self.plan, attrs))
                self.table.fill(partial(read_column, Path(self._shown), file, self.plan))
            self.attrs["date_created"] = attrs["date_created"]
            self._on_file = True
        for point in self._journal.read(self.plan.fingerprint):
            self.table.put(point)
            self._on_file = False
        self.notes += self._journal.notes()

    def _refuse(self, differences: list[str]) -> None:
        if differences:
            listed = "\n  ".join(differences)
            raise ResultFileError(
                f"{self._shown}: holds another sweep; kept (force=True replaces it)."
                f" It differs in\n  {listed}"
            )

    def __enter__(self) -> "FileStore":
        try:
            self._publish()
        except BaseException:
            self._journal.close(remove=False)
            raise
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        published = False
        try:
            self._journal.give_back()
            self._publish()
            published = True
        except ResultFileError as failure:
            raise self._journal.kept_after(failure) from failure
        finally:
            self._journal.close(remove=published)

    def make_room(self, count: int) -> None:
        """As above. Raises ResultFileError when the disk is full."""
        if not self._journal.reserve(count * self._record_bytes):
            done = self.table.count(DONE)
            held = (
                f"it holds {done} points, and the same command goes on from there"
                if done
                else "no point was done"
            )
            raise ResultFileError(f"{self._shown}: disk full; {held}")

    def add(self, points: list[Point]) -> None:
        """Keep points. The journal has them even where there is no room for the file beside its old self."""
        super().add(points)
        self._on_file = False
        self._journal.add(points)
        if time.monotonic() >= self._next:
            try:
                self._publish()
            except ResultFileError:
                self._next = time.monotonic() + LEAST_PAUSE

    def _publish(self) -> None:
        """Write the file anew if need be; then the journal, whose points are in it, begins anew."""
        began = time.monotonic()
        if not self._on_file:
            write_sweep(self.path, self.plan, self.table, self.all_attrs)
        self._on_file = True
        self._journal.restart(self.plan.fingerprint)
        ended = time.monotonic()
        self._next = ended + max(LEAST_PAUSE, (ended - began) / LARGEST_SHARE)
