"""What `vibsim continue --locus` does: follow a bifurcation of a branch in two parameters."""

from collections.abc import Iterable
from pathlib import Path

import click

from vibsim.branches.description import locus_facts, locus_lines
from vibsim.branches.loci.locus_plan import LocusPlan, locus_plan
from vibsim.branches.loci.locus_result import MOST_POINTS, Locus
from vibsim.branches.plan import BranchError
from vibsim.branches.span import read_span
from vibsim.branches.store.locus_file import LocusStore
from vibsim.cases import UnknownKeyError
from vibsim.command_line.jobs.continuation import read_branch_for
from vibsim.command_line.jobs.following import Following
from vibsim.command_line.jobs.run_plan import hdf5_name
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.text.summary import print_lines


def read_locus_plan(
    source: str, label: str, param: tuple[str, str] | None, output: str | None
) -> tuple[LocusPlan, str]:
    """The plan that the options describe, and its file. Raises UsageError, ResultFileError, CaseError."""
    if param is None:
        raise click.UsageError(f"--locus {label} needs the second parameter: --param KEY=FROM:TO")
    branch = read_branch_for(f"--locus {label}", source)
    try:
        plan = locus_plan(branch, label, *read_span(branch.case, *param))
    except (BranchError, UnknownKeyError) as error:
        raise click.UsageError(f"--locus {label}: {error}") from None
    return plan, hdf5_name(output or f"{Path(source).stem}-{label}-locus.h5")


def run_locus(
    plan: LocusPlan, output: str, most: int | None, engine: str, force: bool, settings: Settings
) -> int:
    """Follow a locus, or complete one; returns the exit code."""
    path, most = Path(output), most or MOST_POINTS
    return Following(
        lambda: LocusStore(plan, path, engine, force),
        lambda store, watch: store.complete(most, watch),
        locus_facts,
        print_locus,
    ).run(path, most, settings)


def print_locus(locus: Locus, file: str, more: Iterable[tuple[str, str]] = ()) -> None:
    """Lines about a locus, more lines and the file."""
    print_lines([*locus_lines(locus), *more, ("file", file)])
