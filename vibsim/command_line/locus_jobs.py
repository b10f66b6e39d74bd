"""What `vibsim continue --locus` does: follow a bifurcation of a branch in two parameters."""

import time
from collections.abc import Iterable
from pathlib import Path

import click

from vibsim.branches.branch import Branch
from vibsim.branches.description import locus_facts, locus_lines
from vibsim.branches.locus_plan import LocusPlan, locus_plan
from vibsim.branches.locus_result import MOST_POINTS, Locus
from vibsim.branches.plan import BranchError
from vibsim.branches.span import read_span
from vibsim.branches.store.locus_file import LocusStore
from vibsim.cases import UnknownKeyError
from vibsim.command_line.interruption import Interruption
from vibsim.command_line.progress import PATIENCE, Progress
from vibsim.command_line.quantity_text import size
from vibsim.command_line.run_plan import hdf5_name
from vibsim.command_line.settings import Settings
from vibsim.command_line.summary import print_lines
from vibsim.command_line.terminal import print_json, say
from vibsim.opening import open_result
from vibsim.results import is_result_file


def read_locus_plan(
    source: str, label: str, param: tuple[str, str] | None, output: str | None
) -> tuple[LocusPlan, str]:
    """The plan that the options describe, and its file. Raises UsageError, ResultFileError, CaseError."""
    if param is None:
        raise click.UsageError(f"--locus {label} needs the second parameter: --param KEY=FROM:TO")
    branch = open_result(source) if source != "-" and is_result_file(source) else None
    if not isinstance(branch, Branch):
        raise click.UsageError(f"--locus {label}: {source} is no branch; give the file of one")
    try:
        plan = locus_plan(branch, label, *read_span(branch.case, *param))
    except (BranchError, UnknownKeyError) as error:
        raise click.UsageError(f"--locus {label}: {error}") from None
    return plan, hdf5_name(output or f"{Path(source).stem}-{label}-locus.h5")


def run_locus(
    plan: LocusPlan, output: str, most: int | None, engine: str, force: bool, settings: Settings
) -> int:
    """Follow a locus, or complete one; returns the exit code."""
    path, began = Path(output), time.perf_counter()
    most = most or MOST_POINTS
    with Interruption() as interruption:
        store = LocusStore(plan, path, engine, force)
        for note in store.notes:
            say(f"Warning: {note}", err=True)
        progress = Progress(not settings.quiet, PATIENCE)

        def watch(count: int) -> bool:
            progress.show("points", count, most)
            return interruption.signum is None

        try:
            locus, finished = store.complete(most, watch)
        finally:
            progress.close()
    if settings.json:
        print_json({"file": str(path), **locus_facts(locus)})
    elif not settings.quiet:
        print_locus(locus, f"{path} ({size(path)}), {time.perf_counter() - began:.2f} s")
    if not finished:
        say(f"interrupted: {path} holds what was done; the same command goes on from there", err=True)
        return interruption.exit_code
    return 0


def print_locus(locus: Locus, file: str, more: Iterable[tuple[str, str]] = ()) -> None:
    """Lines about a locus, more lines and the file."""
    print_lines([*locus_lines(locus), *more, ("file", file)])
