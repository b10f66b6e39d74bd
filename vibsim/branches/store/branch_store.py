"""Where the points of a branch go while it is traced: memory, and the journal beside its file at once."""

from contextlib import suppress
from pathlib import Path
from types import TracebackType

from vibsim.branches.branch import Branch
from vibsim.branches.plan import BranchPlan
from vibsim.branches.store.branch_file import (
    follow_up,
    in_order,
    origin,
    read_pair,
    stored_branch,
    write_branch,
)
from vibsim.branches.tracing.records import PointRecord, SpecialRecord, plain
from vibsim.files.errors import ResultFileError
from vibsim.files.journal import Journal
from vibsim.files.output_file import check_result_output
from vibsim.files.writers import check_leftover


class BranchStore:
    """Points and special points in the order in which they come; `notes` is what the user should know."""

    def __init__(self, plan: BranchPlan, engine: str = "auto"):
        self.plan, self.attrs = plan, origin(plan, engine)
        self.points: list[PointRecord] = []
        self.specials: list[SpecialRecord] = []
        self.notes: list[str] = []
        self.complete = False

    def __enter__(self) -> "BranchStore":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        pass

    def add(self, point: PointRecord, specials: list[SpecialRecord]) -> None:
        """Keep a point, and the special points in front of it."""
        self.points.append(point)
        self.specials += specials

    @property
    def branch(self) -> Branch:
        """What there is of the branch."""
        return Branch(self.plan, self.points, self.specials, self.attrs)


class BranchFileStore(BranchStore):
    """A store on file: goes on from what the file and its journal hold.

    Used as a context manager. At its end, whatever ended it, the file holds all points and the journal is
    gone. Raises ResultFileError where the file holds another branch or anything else (unless `force`), where
    another process writes it, or where it cannot be written.
    """

    def __init__(self, plan: BranchPlan, path: str | Path, engine: str = "auto", force: bool = False):
        super().__init__(plan, engine)
        self.path, self._shown = check_result_output(path, force=True), path
        check_leftover(path, force)
        self._on_file = (0, False)  # points, and whether they are all
        self._journal = Journal(self.path, "branch", path)
        try:
            if not force:
                self._go_on()
            else:
                self._journal.restart(plan.fingerprint)
        except BaseException:
            self._journal.close(remove=False)
            raise

    def _go_on(self) -> None:
        """Take over what the file and the journal hold; they must be of this branch."""
        if self.path.exists():
            there = stored_branch(self._shown)
            self._refuse(there)
            points, specials = there.records
            self.points, self.specials = in_order(points), specials
            self.attrs["date_created"] = there.attrs["date_created"]
            self._on_file = (len(points), bool(there.attrs["complete"]))
        waiting = list(self._journal.read(self.plan.fingerprint))
        for point, of_point in follow_up(self.points, map(read_pair, waiting)):
            super().add(point, of_point)
        self.notes += self._journal.notes()
        self._journal.go_on(self.plan.fingerprint, waiting)

    def _refuse(self, there: Branch) -> None:
        if there.plan.fingerprint != self.plan.fingerprint:
            ours, theirs = self.plan.settings, there.plan.settings
            named = [name for name in ours if ours[name] != theirs[name]]
            named += ["case"] if there.case.sha256 != self.plan.case.sha256 else []
            raise ResultFileError(
                f"{self._shown}: holds another branch; kept (force=True replaces it). It differs in "
                + ", ".join(named)
            )

    def add(self, point: PointRecord, specials: list[SpecialRecord]) -> None:
        """Keep a point on disk; with the first one the file is made, which holds the plan."""
        super().add(point, specials)
        self._journal.add([{"point": plain(point), "specials": [plain(each) for each in specials]}])
        if self._on_file == (0, False):
            with suppress(ResultFileError):  # the journal has it; what is wrong is told at the end
                self._write()

    def _write(self) -> None:
        """Write the file, unless it holds all that there is."""
        if (len(self.points), self.complete) > self._on_file:
            write_branch(self.path, self.branch, self.attrs, self.complete)
            self._on_file = (len(self.points), self.complete)

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        published = False
        try:
            self._write()
            published = True
        except ResultFileError as failure:
            raise self._journal.kept_after(failure) from failure
        finally:
            self._journal.close(remove=published)
