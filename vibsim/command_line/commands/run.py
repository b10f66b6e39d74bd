"""vibsim run: cases in, trajectories out."""

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import CASE, DIGITS, EXPONENTS, FILE, OneOf, joined, set_option
from vibsim.command_line.options.shared_options import engine_option

METHODS = ["auto", "closed_form", "taylor"]


@click.command(
    "run",
    short_help="Run cases and write their trajectories.",
    epilog=examples(
        "vibsim run II-B                               # into II-B.h5",
        "vibsim run my.yaml -s c='0.03 N s/m' -o damped.h5",
        "vibsim run I-A I-B I-C -o runs/               # three files in one folder",
        "vibsim run II-B --t-end 20s --every 1ms --plot II-B.png",
        "vibsim run I-A --digits 60                    # the truth, 60 digits of it",
        "vibsim run II-B --lyapunov all --discard 100s # with its Lyapunov exponents from 100 s on",
        "vibsim run II-B.h5                            # the same run again, into II-B-again.h5",
        "cat my.yaml | vibsim run - --json",
    ),
)
@click.argument("sources", metavar="CASE...", nargs=-1, required=True, type=CASE)
@click.option(
    "-o",
    "--output",
    type=FILE,
    metavar="FILE",
    help="Output file, or folder, which is made. [default: NAME.h5]",
)
@set_option
@click.option("--t-end", metavar="TIME", help="End of the run, such as 20s.")
@click.option("--every", metavar="TIME", help="Time between samples, such as 5ms.")
@click.option("--method", type=OneOf(METHODS), help="How the motion between events is computed.")
@engine_option
@click.option(
    "--plot", "picture", type=FILE, metavar="FILE", help="Draw the run too: a .png, .pdf or .svg file."
)
@click.option(
    "--trust/--no-trust",
    default=True,
    help="Tell by a second run until when this one is right. [default: trust]",
)
@click.option(
    "--digits",
    type=DIGITS,
    metavar="N|auto",
    help="Decimal digits to carry, 20 to 1000; auto: ten right ones at the end.",
)
@click.option(
    "--lyapunov",
    type=EXPONENTS,
    metavar="N|all",
    help="Compute the N largest Lyapunov exponents too.",
)
@click.option(
    "--discard",
    metavar="TIME|SHARE",
    help="Transient that --lyapunov leaves out, such as 100s or 0.5. [default: 0.5]",
)
@click.option("--dry-run", is_flag=True, help="Print what would be run, and stop.")
@click.option("--force", is_flag=True, help="Replace existing output files.")
@click.pass_context
def command(
    ctx: click.Context,
    sources: tuple[str, ...],
    output: str | None,
    changes: tuple[tuple[str, str], ...],
    t_end: str | None,
    every: str | None,
    method: str | None,
    engine: str,
    picture: str | None,
    trust: bool,
    digits: int | str | None,
    lyapunov: int | str | None,
    discard: str | None,
    dry_run: bool,
    force: bool,
) -> int:
    """Run each CASE and write its trajectory to an HDF5 file.

    A CASE is a YAML file, the name of a shipped case (see `vibsim cases`), - for standard input, or an HDF5
    file that vibsim wrote: its case is run again.
    """
    from vibsim.command_line.jobs.run import run_all
    from vibsim.command_line.jobs.run_plan import (
        check_digits,
        check_engine,
        check_outputs,
        check_picture,
        plan,
        print_plan,
        with_exponents,
    )

    check_engine(engine)
    check_digits(digits, engine)
    check_picture(picture, len(sources), force or dry_run)
    run_settings = {"run.t_end": t_end, "run.every": every, "run.method": method}
    values = joined(changes, run_settings)
    jobs = with_exponents(plan(sources, values, output), lyapunov, discard, digits)
    if dry_run:
        print_plan(jobs, ctx.obj)
        return 0
    check_outputs(jobs, force)
    code = run_all(jobs, engine, force, ctx.obj, trust, digits)
    if picture and code == 0:
        from vibsim.plots import plot_run

        plot_run(jobs[0].output, picture, force=force)
    return code
