"""What `vibsim sweep` does: make the plan, run it with progress and interruption, say what came of it."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from vibsim.cases import Case, RangeError, UnknownKeyError, load_case
from vibsim.command_line.errors import FAILED_POINTS
from vibsim.command_line.jobs.run_plan import hdf5_name, read_case
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import PATIENCE, Progress
from vibsim.command_line.text.going_on import completed_file, goes_on
from vibsim.command_line.text.summary import print_lines
from vibsim.files.signals import interrupted_with
from vibsim.sweeps.computations.registry import COMPUTATIONS
from vibsim.sweeps.description import facts, sweep_lines
from vibsim.sweeps.plan.axis import read_axis
from vibsim.sweeps.plan.shard import read_shard, shard
from vibsim.sweeps.plan.sweep_plan import Plan, PlanError
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.schedule.workers import Workers
from vibsim.sweeps.statistics.columns import DONE, FAILED, MISSING
from vibsim.sweeps.statistics.quantities import quantities_of
from vibsim.sweeps.store.point_store import FileStore
from vibsim.sweeps.sweeping import complete, make_plan, open_workers, read_ensemble

EXAMPLE = "II-B"  # a case that has everything

AxisText = tuple[str, str, str, str]  # key, range, unit of a bare range, option that it was given with
SOURCES = {"--omega0": "motor", "--omega": "harmonic force"}  # what the options sweep; they have no key
Ensemble = tuple[int, int, Sequence[tuple[str, str]]]  # members, seed, spreads as key and text


def read_plan(
    source: str,
    changes: dict[str, str],
    axes: Sequence[AxisText],
    ensemble: Ensemble,
    settings: dict[str, Any],
) -> Plan:
    """The plan that the options describe.

    Raises CaseError and ResultFileError for the case, UsageError for axes and settings.
    """
    case = read_case(source, changes)
    count, seed, spreads = ensemble
    if not axes and not count and not spreads:
        raise click.UsageError("nothing to sweep: give --omega0, --omega, --param KEY=RANGE or --ensemble N")
    axes = [(key or source_key(case, option, text), text, unit, option) for key, text, unit, option in axes]
    try:
        members = read_ensemble(case, count, seed, dict(spreads))
        plan = make_plan(case, axes, carry_state=settings.pop("carry"), ensemble=members, **settings)
    except (UnknownKeyError, RangeError, PlanError) as error:
        raise click.UsageError(f"{_at_fault(case, axes)}{error}") from None
    if settings["direction"] is not None and not plan.carry:
        say("every point starts fresh, so the direction makes no difference; see --carry-state", err=True)
    return plan


def source_key(case: Case, option: str, text: str) -> str:
    """The key that --omega0 (of the motor) or --omega (of all forces and the base, one value) stands for.

    Raises UsageError for a case of another source, and where frequencies differ.
    """
    motor = case.source_kind == "motor"
    if motor == (option == "--omega0"):
        if motor:
            return "motor.Omega0" if case.is_long else "excitation.Omega0"
        keys = [key for key in case.numeric_keys() if key.rpartition(".")[2] == "omega"]
        if case.frequency() is not None:
            return "=".join(keys)
        if keys:
            listed = " and ".join(keys)
            raise click.UsageError(f"{option}: the frequencies {listed} of {case.name} differ; use --param")
    elif motor or case.source_kind in ("harmonic", "base"):
        kind = {"motor": "motor", "harmonic": "harmonic", "base": "moving base"}[case.source_kind]
        other = next(each for each in SOURCES if each != option)
        raise click.UsageError(f"{option}: the source of {case.name} is {kind}; use {other} {text}")
    raise click.UsageError(f"{option}: {case.name} has no {SOURCES[option]}")


def _at_fault(case: Case, axes: Sequence[AxisText]) -> str:
    """The option that cannot be followed, as the begin of a message; empty where none is wrong by itself."""
    for key, text, unit, option in axes:
        try:
            read_axis(case, key, text, unit, option)
        except (UnknownKeyError, RangeError):
            return f"{option} {key}: " if option == "--param" else f"{option}: "
    return ""


def computations_listed(settings: Settings) -> None:
    """Print what --compute takes, and what each stores of the paper's two blocks under a motor."""
    of = quantities_of(load_case(EXAMPLE))
    if settings.json:
        kinds = COMPUTATIONS.items()
        print_json({name: {"title": kind.title, "columns": list(kind.columns(of))} for name, kind in kinds})
        return
    width = max(map(len, COMPUTATIONS))
    for name, kind in COMPUTATIONS.items():
        say(f"{name:<{width}}  {kind.title}: {', '.join(kind.columns(of))}")


def sharded(plan: Plan, text: str | None, output: str | None) -> tuple[Plan, str]:
    """The part of a plan that --shard asks for, and the file for it. Raises UsageError."""
    output = output if output is None else hdf5_name(output)
    name = f"{plan.case.name}-{'-'.join(axis.name for axis in plan.axes)}"
    if text is None:
        return plan, output or f"{name}.h5"
    try:
        number, parts = read_shard(text)
        return shard(plan, number, parts), output or f"{name}-{number:0{len(str(parts))}}of{parts}.h5"
    except PlanError as error:
        raise click.UsageError(f"--shard: {error}") from None


def workers_for(plan: Plan, jobs: int | None, scheduler: str | None, engine: str) -> Workers:
    """The workers that the options name. Raises UsageError."""
    try:
        return open_workers(plan, jobs, scheduler, engine)
    except PlanError as error:
        raise click.UsageError(str(error)) from None


def run_sweep(plan: Plan, output: str, workers: Workers, engine: str, force: bool, settings: Settings) -> int:
    """Run or complete a sweep; returns the exit code."""
    path = Path(output)
    began = time.perf_counter()
    with Interruption() as interruption, interrupted_with(lambda: goes_on(path)), workers:
        store = FileStore(plan, path, engine, force)
        for note in store.notes:
            say(f"Warning: {note}", err=True)
        had, missing = store.table.count(DONE), store.table.count(MISSING)
        progress = Progress(not settings.quiet, PATIENCE)

        def watch(table: Table) -> bool:
            progress.show("points", missing - table.count(MISSING), missing)
            return interruption.signum is None

        try:
            result, _ = complete(store, workers, watch)
        finally:
            progress.close()
    took = time.perf_counter() - began
    if settings.json:
        print_json({"file": str(path), **facts(result)})
    elif not settings.quiet:
        lines = [*sweep_lines(result), ("file", completed_file(path, plan.count, had, took))]
        print_lines(lines)
    if not result.complete and interruption.signum is not None:
        say(f"interrupted: {goes_on(path)}", err=True)
        return interruption.exit_code
    failed = result.table.count(FAILED)
    if failed:
        say(f"Error: {failed} of {plan.count} points failed; the same command tries them again", err=True)
    return FAILED_POINTS if failed else 0
