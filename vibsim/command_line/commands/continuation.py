"""vibsim continue: a periodic orbit followed over a parameter."""

import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import click

from vibsim.cases import Case, UnknownKeyError
from vibsim.command_line.commands.run import hdf5_name, read_case, to_be_completed
from vibsim.command_line.commands.sweep import source_key
from vibsim.command_line.options import (
    CASE,
    PairType,
    Settings,
    count_option,
    examples,
    output_option,
    set_option,
    some_text,
    stored_force_option,
)
from vibsim.command_line.terminal import PROGRESS_AFTER, Progress, print_json, say
from vibsim.command_line.text import completed_file, goes_on, print_columns, print_lines
from vibsim.orbits.branches.branch import Branch, BranchStore, branch_lines, facts, special_table
from vibsim.orbits.branches.continuing import orbit_from, switched
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import MOST_POINTS as MOST_LOCUS_POINTS
from vibsim.orbits.branches.locus_result import (
    Locus,
    LocusPlan,
    LocusStore,
    locus_facts,
    locus_lines,
    locus_plan,
)
from vibsim.orbits.branches.plan import (
    BranchError,
    BranchPlan,
    energy_plan,
    parameter_within,
    plan_from,
    read_span,
)
from vibsim.orbits.branches.tracing import MOST_POINTS
from vibsim.results import kind_of, names_a_result
from vibsim.results.simulation import open_result
from vibsim.signals import Interruption, interrupted_with
from vibsim.sweeps.axes import scale_name

SPAN = PairType("KEY=FROM:TO, such as c=0.01:0.1", some_text, several=True)


@click.command(
    "continue",
    short_help="Follow a periodic orbit over a parameter, stable or not.",
    epilog=examples(
        "vibsim continue II-B-orbit.h5 --omega0 3:9     # a stored orbit, into II-B-omega0-branch.h5",
        "vibsim continue II-B -s c=0.03 -s Omega0=5Hz --omega0 3:9 -o captured.h5",
        "vibsim continue I-A --omega 3:4",
        "vibsim continue II-B-orbit.h5 --param c=0.01:0.1 --json",
        "vibsim continue captured.h5 --switch PD1       # the branch that leaves there",
        "vibsim continue I-A -s excitation=none -s c=0 -s friction=none -s x1=5mm --energy 1e-5:0.1",
        "vibsim continue captured.h5 --locus NS1 --param c=0.02:0.1",
        "vibsim continue captured.h5                   # complete it by the plan that it holds",
        "vibsim plot captured.h5",
        before="An interrupted continuation is resumed by the same command, or by its file alone.",
    ),
)
@click.argument("source", metavar="ORBIT", type=CASE)
@click.option("--omega0", metavar="FROM:TO", help="Motor constants; bare numbers are Hz.")
@click.option("--omega", metavar="FROM:TO", help="Frequencies of an ideal source; bare numbers are Hz.")
@click.option(
    "--param", metavar="KEY=FROM:TO", type=SPAN,
    help="Any number of the case. KEY=KEY=FROM:TO gives several keys the same value.",
)  # fmt: skip
@click.option("--energy", metavar="FROM:TO", help="Energies of a conservative orbit [J]: its backbone curve.")
@click.option("--switch", metavar="LABEL", help="Follow what leaves the branch ORBIT there: PD1, BP1, ...")
@click.option("--locus", metavar="LABEL", help="Follow NS1, F1, PD1, GR1, ST1 of a branch in --param too.")
@count_option("--max-points", "Points, on both sides together. [default: 5000; 2000 of a locus]", least=2)
@set_option
@output_option("CASE-KEY-branch.h5")
@stored_force_option
@click.pass_context
def command(
    ctx: click.Context,
    source: str,
    omega0: str | None,
    omega: str | None,
    param: tuple[str, str] | None,
    energy: str | None,
    switch: str | None,
    locus: str | None,
    max_points: int | None,
    changes: tuple[tuple[str, str], ...],
    output: str | None,
    force: bool,
) -> int:
    """Follow the periodic orbit ORBIT over a parameter, both ways, through folds.

    ORBIT is a stored orbit, or a case or the HDF5 file of a run, whose end it is taken from; with --switch
    or --locus a branch. The file of a branch or a locus, given alone, is completed. The order of events need
    not be told: where it changes is located, and listed beside folds, doublings and Neimark-Sacker points.
    Frequency responses with their unstable parts are branches over --omega, backbone curves over --energy.
    """

    if not any((omega0, omega, param, energy, switch, locus)):
        stored = to_be_completed(source, ("branch", "locus"), ctx)
        if stored is not None:
            output = hdf5_name(output or source)
            if stored.attrs["vibsim_kind"] == "branch":
                return run_continuation(stored.plan, output, max_points, force, ctx.obj)

            return run_locus(stored.plan, output, max_points, force, ctx.obj)
    if locus is not None:
        if omega0 or omega or energy or switch or changes:
            raise click.UsageError("--locus takes its second parameter from --param, and nothing else")
        locus_plan, output = read_locus_plan(source, locus, param, output)
        return run_locus(locus_plan, output, max_points, force, ctx.obj)
    if energy is not None:
        if omega0 or omega or param or switch:
            raise click.UsageError("--energy is a range of its own; leave other ranges and --switch out")
        plan, output = read_energy_plan(source, dict(changes), energy, output)
        return run_continuation(plan, output, max_points, force, ctx.obj)
    ranges = {"--omega0": omega0, "--omega": omega}
    plan, output = read_plan(source, dict(changes), ranges, param, switch, output)
    return run_continuation(plan, output, max_points, force, ctx.obj)


# What `vibsim continue` does: find the orbit, follow it with progress, list what was met.


def read_plan(
    source: str,
    changes: dict[str, str],
    options: Mapping[str, str | None],
    param: tuple[str, str] | None,
    switch: str | None,
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
        key, bare_rate = source_key(case, option, text), "Hz"
    else:
        option, (key, text), bare_rate = "--param", param, ""
    try:
        keys, unit, span = read_span(case, key, text, bare_rate)
        parameter_within(case, keys, unit, span)
        plan = plan_from(_orbit(source, case, changes), keys, unit, span)
    except (BranchError, UnknownKeyError) as error:
        raise click.UsageError(f"{option}: {error}") from None
    return plan, hdf5_name(output or f"{case.name}-{scale_name(keys[0])}-branch.h5")


def read_energy_plan(
    source: str, changes: dict[str, str], text: str, output: str | None
) -> tuple[BranchPlan, str]:
    """The plan of a backbone curve, and its file.

    Raises UsageError, CaseError, OrbitError, ResultFileError.
    """

    _check_kind(source)
    is_file = not changes and names_a_result(source)
    subject = open_result(source) if is_file else read_case(source, changes)
    try:
        plan = energy_plan(subject, text)
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


def _orbit(source: str, case: Case, changes: dict[str, str]) -> object:
    """The orbit in a file, or where the run of a case comes to."""
    if changes or not names_a_result(source):
        return orbit_from(case)
    return orbit_from(open_result(source))


def run_continuation(plan: BranchPlan, output: str, most: int | None, force: bool, settings: Settings) -> int:
    """Follow a branch, or complete one; returns the exit code."""
    path = Path(output)
    store = partial(BranchStore, plan, path, force)
    return follow(store, facts, print_branch, path, most or MOST_POINTS, settings)


def print_branch(branch: Branch, file: str, more: Iterable[tuple[str, str]] = ()) -> None:
    """Lines about a branch, a line per special point, more lines and the file."""
    print_lines(branch_lines(branch))
    print_columns(special_table(branch))
    print_lines([*more, ("file", file)])


# What `vibsim continue --locus` does: follow a bifurcation of a branch in two parameters.


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


def run_locus(plan: LocusPlan, output: str, most: int | None, force: bool, settings: Settings) -> int:
    """Follow a locus, or complete one; returns the exit code."""
    path = Path(output)
    store = partial(LocusStore, plan, path, force)
    return follow(store, locus_facts, print_locus, path, most or MOST_LOCUS_POINTS, settings)


def print_locus(locus: Locus, file: str, more: Iterable[tuple[str, str]] = ()) -> None:
    """Lines about a locus, more lines and the file."""
    print_lines([*locus_lines(locus), *more, ("file", file)])


# What is followed point by point into a file, a branch or a locus: progress, interruption, what is said.


def follow(
    open_store: Callable[[], Any],
    facts_of: Callable[[Any], dict[str, Any]],
    show: Callable[[Any, str], None],
    path: Path,
    most: int,
    settings: Settings,
) -> int:
    """Follow a branch or a locus into a file, or complete that; returns the exit code.

    open_store : opens what takes the points, which has `points` and `notes`
    facts_of, show : it as plain data, and printed with a text about its file
    """
    began, store = time.perf_counter(), None
    with Interruption() as interruption, interrupted_with(lambda: _kept(path, store)):
        store = open_store()
        for note in store.notes:
            say(f"Warning: {note}", err=True)
        had = len(store.points)
        with Progress(not settings.quiet, PROGRESS_AFTER) as progress:

            def watch(count: int, *_: object) -> bool:
                progress.show("points", count, most)
                return interruption.signum is None

            followed, finished = complete(store, most, watch)
    if settings.json:
        print_json({"file": str(path), **facts_of(followed)})
    elif not settings.quiet:
        show(followed, completed_file(path, len(followed), had, time.perf_counter() - began))
    if not finished:
        say(f"interrupted: {_kept(path, store)}", err=True)
        return interruption.exit_code
    return 0


def _kept(path: Path, store: Any) -> str:
    if store is None or not store.points:
        return "stopped before the first point; nothing is kept"
    return goes_on(path)
