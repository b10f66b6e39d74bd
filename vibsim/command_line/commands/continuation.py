"""vibsim continue: a periodic orbit followed over a parameter."""

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import CASE, Pair, set_option, some_text
from vibsim.command_line.options.shared_options import (
    engine_option,
    output_option,
    stored_force_option,
)

SPAN = Pair("KEY=FROM:TO, such as c=0.01:0.1", some_text, several=True)


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
        before="An interrupted continuation goes on when the same command is given again, or its file alone.",
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
@click.option(
    "--max-points", type=click.IntRange(min=2), metavar="N",
    help="Points, on both sides together. [default: 5000; 2000 of a locus]",
)  # fmt: skip
@set_option
@engine_option
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
    engine: str,
    output: str | None,
    force: bool,
) -> int:
    """Follow the periodic orbit ORBIT over a parameter, both ways, through folds.

    ORBIT is a stored orbit, or a case or the HDF5 file of a run, whose end it is taken from; with --switch
    or --locus a branch. The file of a branch or a locus, given alone, is completed. The order of events need
    not be told: where it changes is located, and listed beside folds, doublings and Neimark-Sacker points.
    """
    from vibsim.command_line.jobs.continuation import read_energy_plan, read_plan, run_continuation
    from vibsim.command_line.jobs.run_plan import check_engine, hdf5_name, to_be_completed

    check_engine(engine)
    if not any((omega0, omega, param, energy, switch, locus)):
        stored = to_be_completed(source, ("branch", "locus"), ctx)
        if stored is not None:
            output = hdf5_name(output or source)
            if stored.attrs["vibsim_kind"] == "branch":
                return run_continuation(stored.plan, output, max_points, engine, force, ctx.obj)
            from vibsim.command_line.jobs.locus import run_locus

            return run_locus(stored.plan, output, max_points, engine, force, ctx.obj)
    if locus is not None:
        from vibsim.command_line.jobs.locus import read_locus_plan, run_locus

        if omega0 or omega or energy or switch or changes:
            raise click.UsageError("--locus takes its second parameter from --param, and nothing else")
        locus_plan, output = read_locus_plan(source, locus, param, output)
        return run_locus(locus_plan, output, max_points, engine, force, ctx.obj)
    if energy is not None:
        if omega0 or omega or param or switch:
            raise click.UsageError("--energy is a range of its own; leave other ranges and --switch out")
        plan, output = read_energy_plan(source, dict(changes), energy, engine, output)
        return run_continuation(plan, output, max_points, engine, force, ctx.obj)
    ranges = {"--omega0": omega0, "--omega": omega}
    plan, output = read_plan(source, dict(changes), ranges, param, switch, engine, output)
    return run_continuation(plan, output, max_points, engine, force, ctx.obj)
