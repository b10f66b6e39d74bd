"""What `vibsim continue` does: find the orbit, follow it with progress, list what was met."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import click

from vibsim.branches.branch import Branch
from vibsim.branches.continuing import complete, orbit_from
from vibsim.branches.description import branch_lines, facts, special_table
from vibsim.branches.plan import BranchError, BranchPlan, parameter_within, plan_from
from vibsim.branches.span import read_span
from vibsim.branches.store.branch_store import BranchFileStore
from vibsim.branches.switching import switched
from vibsim.branches.tracing.tracing import MOST_POINTS
from vibsim.cases import Case, UnknownKeyError
from vibsim.command_line.jobs.following import Following
from vibsim.command_line.jobs.run_plan import hdf5_name, read_case
from vibsim.command_line.jobs.sweep import source_key
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.printing import say
from vibsim.command_line.text.summary import print_lines
from vibsim.opening import open_result
from vibsim.results import kind_of, names_a_result
from vibsim.sweeps.plan.axis import scale_name


def read_plan(
    source: str,
    changes: dict[str, str],
    options: Mapping[str, str | None],
    param: tuple[str, str] | None,
    switch: str | None,
    engine: str,
    output: str | None,
) -> tuple[BranchPlan, str]:
    """The plan that the options describe, and its file.

    Raises UsageError for what cannot be followed, CaseError, OrbitError and ResultFileError for the source.
    """
    chosen = [(option, text) for option, text in options.items() if text is not None]
    parameters = len(chosen) + (param is not None)
    if switch is not None:
        return _switched(source, changes, parameters, switch, output)
    if parameters != 1:
        raise click.UsageError("give one range to follow: --omega0, --omega, --energy or --param KEY=FROM:TO")
    _check_kind(source)
    case = read_case(source, changes)
    if param is None:
        option, text = chosen[0]
        key = source_key(case, option, text)
    else:
        option, (key, text) = "--param", param
    try:
        keys, unit, span = read_span(case, key, text)
        parameter_within(case, keys, unit, span)
        plan = plan_from(_orbit(source, case, changes, engine), keys, unit, span)
    except (BranchError, UnknownKeyError) as error:
        raise click.UsageError(f"{option}: {error}") from None
    return plan, hdf5_name(output or f"{case.name}-{scale_name(keys[0])}-branch.h5")


def read_energy_plan(
    source: str, changes: dict[str, str], text: str, engine: str, output: str | None
) -> tuple[BranchPlan, str]:
    """The plan of a backbone curve, and its file.

    Raises UsageError, CaseError, OrbitError, ResultFileError.
    """
    from vibsim.branches.backbone import energy_plan

    _check_kind(source)
    is_file = not changes and names_a_result(source)
    subject = open_result(source) if is_file else read_case(source, changes)
    try:
        plan = energy_plan(subject, text, engine)
    except BranchError as error:
        raise click.UsageError(f"--energy: {error}") from None
    return plan, hdf5_name(output or f"{plan.case.name}-energy-branch.h5")


def _check_kind(source: str) -> None:
    """Usage error for a file that holds neither an orbit nor a run."""
    kind = kind_of(source) if names_a_result(source) else "trajectory"
    if kind == "branch":
        raise click.UsageError(
            f"{source} holds a branch; --switch PD1 or --locus NS1 go on from one, and alone it is completed"
        )
    if kind != "trajectory":
        raise click.UsageError(f"{source} holds a {kind}; give a case, or the file of an orbit or a run")


def _switched(
    source: str, changes: dict[str, str], ranges: int, label: str, output: str | None
) -> tuple[BranchPlan, str]:
    """The branch that leaves another, over the range of that one."""
    if changes or ranges:
        raise click.UsageError("--switch follows over the range of its branch; leave ranges and --set out")
    try:
        plan = switched(read_branch_for(f"--switch {label}", source), label)
    except BranchError as error:
        raise click.UsageError(f"--switch {label}: {error}") from None
    return plan, hdf5_name(output or f"{Path(source).stem}-{label}.h5")


def read_branch_for(option: str, source: str) -> Branch:
    """The branch that an option goes on from. Raises UsageError for what is none, ResultFileError and
    CaseError for what cannot be read.
    """
    branch = open_result(source) if names_a_result(source) else read_case(source, {})
    if not isinstance(branch, Branch):
        raise click.UsageError(f"{option}: {source} is no branch; give the file of one")
    return branch


def _orbit(source: str, case: Case, changes: dict[str, str], engine: str) -> object:
    """The orbit in a file, or where the run of a case comes to."""
    if changes or not names_a_result(source):
        return orbit_from(case, engine)
    return orbit_from(open_result(source), engine)


def run_continuation(
    plan: BranchPlan, output: str, most: int | None, engine: str, force: bool, settings: Settings
) -> int:
    """Follow a branch, or complete one; returns the exit code."""
    path, most = Path(output), most or MOST_POINTS
    return Following(
        lambda: BranchFileStore(plan, path, engine, force),
        lambda store, watch: complete(store, most, engine, watch),
        facts,
        print_branch,
    ).run(path, most, settings)


def print_branch(branch: Branch, file: str, more: Iterable[tuple[str, str]] = ()) -> None:
    """Lines about a branch, a line per special point, more lines and the file."""
    print_lines(branch_lines(branch))
    rows = special_table(branch)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (text.ljust(width) for text, width in zip(row, widths, strict=True))
        say(f"  {'  '.join(cells)}".rstrip())
    print_lines([*more, ("file", file)])
