"""vibsim sweep: a case at every point of a grid, in parallel and restartable."""

from typing import Any

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import CASE, KEY_RANGE, OneOf, joined, set_option
from vibsim.command_line.options.shared_options import (
    engine_option,
    every_end_option,
    jobs_option,
    output_option,
    spread_option,
    stored_force_option,
)
from vibsim.command_line.terminal.printing import say

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
        "vibsim sweep II-B --omega0 3:7:0.001 --scheduler tcp://10.0.0.1:8786",
        "vibsim sweep II-B-omega0.h5                   # complete it by the plan that it holds",
        "vibsim plot II-B-omega0.h5",
        before="Ranges: FROM:TO:STEP (both ends included), FROM:TO/COUNT, 'log FROM:TO/COUNT' (spaced by "
        "ratio), or A,B,C; with a unit at the end. "
        "Their order counts: 7:3:0.05 runs down. "
        "An interrupted sweep goes on when the same command is given again, or its file alone.",
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
@click.option(
    "--ensemble", type=click.IntRange(min=1), metavar="N",
    help="Run N members at every point, each with other start values.",
)  # fmt: skip
@click.option(
    "--seed", type=click.IntRange(min=0), metavar="S",
    help="Seed of the members' draws; member 7 is the same in an ensemble of any size. [default: 0]",
)  # fmt: skip
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
    "--discard", default="50%", metavar="TIME|SHARE", help="Transient left out, such as 100s or 0.5.",
    show_default=True,
)  # fmt: skip
@click.option(
    "--section", type=click.IntRange(min=0), default=100, metavar="N", show_default=True,
    help="Stroboscopic points kept per point.",
)  # fmt: skip
@click.option(
    "--compute", "computed", metavar="NAME,...", default="",
    help="What to compute of each point besides: power, impact-velocity, contact-section, grazing, "
    "certificate, capture, lyapunov (one more run), lyapunov-spectrum (one more, three times as long), "
    "regime, orbit, end-state; or all. See --list.",
)  # fmt: skip
@click.option("--list", "list_computations", is_flag=True, help="List what --compute takes, and stop.")
@set_option
@every_end_option
@click.option(
    "--every", metavar="TIME", help="Sampling behind verdicts on the regime. [default: what the motion needs]"
)
@click.option("--method", type=OneOf(["auto", "closed_form", "taylor"]), help="How the motion is computed.")
@engine_option
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
    engine: str,
    jobs: int | None,
    scheduler: str | None,
    shard: str | None,
    output: str | None,
    force: bool,
    **settings: Any,
) -> int:
    """Run CASE at every point of a grid and store statistics of each run.

    CASE is a YAML file, the name of a shipped case, - for standard input, or an HDF5 file of vibsim, whose
    case is taken. The file of a sweep, given alone, is completed.
    """
    from vibsim.command_line.jobs.run_plan import check_engine, hdf5_name, to_be_completed
    from vibsim.command_line.jobs.sweep import computations_listed, read_plan, run_sweep, sharded, workers_for

    if list_computations:
        computations_listed(ctx.obj)
        return 0
    check_engine(engine)
    if source is None:
        source = DEFAULT_CASE
        if not ctx.obj.quiet:
            say(f"no case given: sweeping {source}", err=True)
    run_settings = {"run.t_end": t_end, "run.method": method}
    values = joined(changes, run_settings)
    axes = [("", text, "Hz", option) for option, text in (("--omega0", omega0), ("--omega", omega)) if text]
    axes += [(key, text, "", "--param") for key, text in params]
    settings["compute"] = [name.strip() for name in computed.split(",") if name.strip()]
    if seed is not None and not ensemble:
        raise click.UsageError("--seed draws the members of --ensemble, which is not given")
    stored = None if axes or ensemble or spreads else to_be_completed(source, ("sweep",), ctx)
    if stored is not None:
        plan, output = stored.plan, hdf5_name(output or source)
    else:
        plan = read_plan(source, values, axes, (ensemble or 0, seed or 0, spreads), settings)
        plan, output = sharded(plan, shard, output)
    return run_sweep(plan, output, workers_for(plan, jobs, scheduler, engine), engine, force, ctx.obj)
