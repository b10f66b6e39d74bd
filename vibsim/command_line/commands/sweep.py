"""vibsim sweep: a case at every point of a grid, in parallel and restartable."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from vibsim.cases import Case, RangeError, UnknownKeyError, load_case
from vibsim.command_line.commands.run import hdf5_name, read_case, to_be_completed
from vibsim.command_line.main import FAILED_POINTS
from vibsim.command_line.options import (
    CASE,
    DISCARD,
    KEY_RANGE,
    OneOf,
    Settings,
    count_option,
    every_end_option,
    examples,
    jobs_option,
    joined,
    output_option,
    set_option,
    spread_option,
    stored_force_option,
)
from vibsim.command_line.terminal import PROGRESS_AFTER, Progress, print_json, say
from vibsim.command_line.text import completed_file, goes_on, print_lines
from vibsim.signals import Interruption, interrupted_with
from vibsim.sweeps.axes import read_axis
from vibsim.sweeps.computations import COMPUTATIONS
from vibsim.sweeps.points import Table
from vibsim.sweeps.quantities import DONE, FAILED, MISSING, quantities_of
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import PlanError, SweepPlan, read_shard, shard
from vibsim.sweeps.sweep_result import facts, sweep_lines
from vibsim.sweeps.sweeping import complete, make_plan, open_workers, read_ensemble
from vibsim.sweeps.workers import Workers

DEFAULT_CASE = "II-B"


@click.command(
    "sweep",
    short_help="Run a case at every point of a grid.",
    epilog=examples(
        "vibsim sweep --omega0 3:7:0.05                # II-B, 81 motor constants, into II-B-omega0.h5",
        "vibsim sweep II-B --omega0 3:7:0.05 --direction both --carry-state -o hysteresis.h5",
        "vibsim sweep I-B --omega 3:7:0.1 --discard 100s",
        "vibsim sweep II-B --omega0 3:7:0.1 --param c=0.01:0.05/9",
        "vibsim sweep II-B --param k2='log 1e3:1e6/31 N/m'    # ten to a decade",
        "vibsim sweep drifting-capsule --param stops.anvil.k=1:10/10kN/m",
        "vibsim sweep II-B --omega0 3:7:0.1 --ensemble 20 --spread phi=0:360deg --spread x1=1mm",
        "vibsim sweep II-B --omega0 3:7:0.1 --compute power,capture,regime",
        "vibsim sweep cantilever --param tip.x=-5:5/40mm --param tip.v=-500:500/40mm/s --compute attractor",
        "vibsim sweep II-B --omega0 3:7:0.001 --scheduler tcp://10.0.0.1:8786",
        "vibsim sweep II-B-omega0.h5                   # complete it by the plan that it holds",
        "vibsim plot II-B-omega0.h5",
        before="Ranges: FROM:TO:STEP (both ends included), FROM:TO/COUNT, 'log FROM:TO/COUNT' (spaced by "
        "ratio), or A,B,C; with a unit at the end. "
        "Their order counts: 7:3:0.05 runs down. "
        "An interrupted sweep is resumed by the same command, or by its file alone.",
    ),
)
@click.argument("source", metavar="[CASE]", required=False, type=CASE)
@click.option("--omega0", metavar="RANGE", help="Motor constants; bare numbers are Hz.")
@click.option("--omega", metavar="RANGE", help="Frequencies of a harmonic source; bare numbers are Hz.")
@click.option(
    "--param",
    "params",
    metavar="KEY=RANGE",
    multiple=True,
    type=KEY_RANGE,
    help="Any number; repeat for a grid. KEY=KEY=RANGE gives several keys the same values.",
)
@count_option("--ensemble", "Run N members at every point, each with other start values.", least=1)
@count_option(
    "--seed",
    "Seed of the members' draws; member 7 is the same in an ensemble of any size. [default: 0]",
    metavar="S",
)
@spread_option("the ensemble")
@click.option(
    "--direction", type=OneOf(["up", "down", "both"]),
    help="Along the first axis. [default: as its values are written]",
)  # fmt: skip
@click.option(
    "--carry-state/--fresh", "carry",
    help="Start each point from the end of the one before, or as the case says. [default: fresh]",
)  # fmt: skip
@click.option(
    "--discard",
    default="50%",
    type=DISCARD,
    metavar="TIME|SHARE",
    help="Transient left out, such as 100s or 0.5.",
    show_default=True,
)
@count_option("--section", "Stroboscopic points kept per point.", default=100)
@click.option(
    "--compute", "computed", metavar="NAME,...", default="",
    help="What to compute of each point besides: power, impact-velocity, contact-section, grazing, "
    "certificate, capture, lyapunov (one more run), lyapunov-spectrum (one more, three times as long), "
    "regime, orbit, end-state, attractor (alone, runs stop where it is sure); or all. See --list.",
)  # fmt: skip
@click.option("--list", "list_computations", is_flag=True, help="List what --compute takes, and stop.")
@set_option
@every_end_option
@click.option(
    "--every", metavar="TIME", help="Sampling behind verdicts on the regime. [default: what the motion needs]"
)
@click.option("--method", type=OneOf(["auto", "closed_form", "taylor"]), help="How the motion is computed.")
@jobs_option("Points")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Compute on the workers of this dask scheduler, such as tcp://host:8786.",
)
@click.option("--shard", metavar="K/N", help="Only part K of N of the longest axis, into a file of its own.")
@output_option("CASE-AXES.h5")
@stored_force_option
@click.pass_context
def command(
    ctx: click.Context,
    /,
    source: str | None,
    omega0: str | None,
    omega: str | None,
    params: tuple[tuple[str, str], ...],
    ensemble: int | None,
    seed: int,
    spreads: tuple[tuple[str, str], ...],
    computed: str,
    list_computations: bool,
    changes: tuple[tuple[str, str], ...],
    t_end: str | None,
    method: str | None,
    jobs: int | None,
    scheduler: str | None,
    shard: str | None,
    output: str | None,
    force: bool,
    **settings: Any,
) -> int:
    """Run CASE at every point of a grid and store statistics of each run.

    Bifurcation diagrams, frequency responses and basins are made so. CASE is a YAML file, the name of a
    shipped case, - for standard input, or an HDF5 file of vibsim, whose case is taken. The file of a sweep,
    given alone, is completed.
    """

    if list_computations:
        computations_listed(ctx.obj)
        return 0
    if source is None:
        source = DEFAULT_CASE
        if not ctx.obj.quiet:
            say(f"no case given: sweeping {source}", err=True)
    run_settings = {"run.t_end": t_end, "run.method": method}
    values = joined(changes, run_settings)
    axes = [("", text, "Hz", option) for option, text in (("--omega0", omega0), ("--omega", omega)) if text]
    axes += [(key, text, "", "--param") for key, text in params]
    settings["discard"] = str(settings["discard"])
    settings["compute"] = [name.strip() for name in computed.split(",") if name.strip()]
    if seed is not None and not ensemble:
        raise click.UsageError("--seed draws the members of --ensemble, which is not given")
    stored = None if axes or ensemble or spreads else to_be_completed(source, ("sweep",), ctx)
    if stored is not None:
        plan, output = stored.plan, hdf5_name(output or source)
    else:
        plan = read_plan(source, values, axes, (ensemble or 0, seed or 0, spreads), settings)
        plan, output = sharded(plan, shard, output)
    return run_sweep(plan, output, workers_for(plan, jobs, scheduler), force, ctx.obj)


# What `vibsim sweep` does: make the plan, run it with progress and interruption, say what came of it.


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
) -> SweepPlan:
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


def sharded(plan: SweepPlan, text: str | None, output: str | None) -> tuple[SweepPlan, str]:
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


def workers_for(plan: SweepPlan, jobs: int | None, scheduler: str | None) -> Workers:
    """The workers that the options name. Raises UsageError."""
    try:
        return open_workers(plan, jobs, scheduler)
    except PlanError as error:
        raise click.UsageError(str(error)) from None


def run_sweep(plan: SweepPlan, output: str, workers: Workers, force: bool, settings: Settings) -> int:
    """Run or complete a sweep; returns the exit code."""
    path = Path(output)
    began = time.perf_counter()
    with Interruption() as interruption, interrupted_with(lambda: goes_on(path)), workers:
        store = SweepStore(plan, path, force)
        for note in store.notes:
            say(f"Warning: {note}", err=True)
        had, missing = store.table.count(DONE), store.table.count(MISSING)
        with Progress(not settings.quiet, PROGRESS_AFTER) as progress:

            def watch(table: Table) -> bool:
                progress.show("points", missing - table.count(MISSING), missing)
                return interruption.signum is None

            result, _ = complete(store, workers, watch)
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
