"""vibsim export: results for spreadsheets, data frames and MATLAB."""

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import FILE, WINDOW
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.printing import print_json, say


@click.command(
    "export",
    short_help="Write a result as CSV, Parquet or MAT.",
    epilog=examples(
        "vibsim export II-B.h5 -o II-B.csv",
        "vibsim export II-B.h5 -o impacts.csv --events --window 100:110",
        "vibsim export II-B.h5 -o II-B.mat             # samples and events",
        "vibsim export sommerfeld.h5 -o sommerfeld.parquet",
        "vibsim export sommerfeld.h5 -o points.csv --along section",
        "vibsim export II-B.h5 --ro-crate -o II-B-crate        # a folder with case, versions, checksums",
    ),
)
@click.argument("file", metavar="FILE", type=FILE)
@click.option(
    "-o", "--output", metavar="FILE", type=FILE, required=True,
    help="A .csv, .parquet or .mat file; of --ro-crate a folder.",
)  # fmt: skip
@click.option("--events", is_flag=True, help="Of a run the events, not the samples.")
@click.option("--window", type=WINDOW, metavar="A:B", help="Of a run only this span of time [s].")
@click.option(
    "--along",
    metavar="DIMENSION",
    help="Of a sweep and the like: what has this dimension, such as section, one row per position along it.",
)
@click.option(
    "--ro-crate", "crate", is_flag=True,
    help="Write a folder instead, a Process Run Crate: file, case, versions, checksums.",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Replace an existing output file.")
@click.pass_context
def command(
    ctx: click.Context,
    file: str,
    output: str,
    events: bool,
    window: tuple[float, float] | None,
    along: str,
    crate: bool,
    force: bool,
) -> None:
    """Write what FILE holds as CSV, Parquet or MAT, by the suffix of the output.

    A run: a row per sample, or per event. A sweep, an orbit or a branch: a tidy table, a row per point, with
    the values of the axes in columns of their own. Runs are in SI units and axes in the unit in which they
    were given, to the last digit; codes are written as words. A Parquet file (needs vibsim[parquet]) keeps
    units and the root attributes as metadata; a MAT file holds the columns of a run and a struct `events`.
    """
    from vibsim.command_line.jobs.export import export_any, suffix_of
    from vibsim.files.signals import interrupted_with

    with interrupted_with(lambda: f"{output} is not written"):
        if crate:
            return _crate(ctx.obj, file, output, bool(events or window or along), force)
        if events and suffix_of(output) == ".mat":
            raise click.UsageError("--events is for CSV and Parquet; a MAT file holds samples and events")
        export_any(file, output, events, window, along, force)
    if ctx.obj.json:
        print_json({"file": file, "written": [output]})
    elif not ctx.obj.quiet:
        say(f"{output} written", err=True)


def _crate(settings: Settings, file: str, folder: str, narrowed: bool, force: bool) -> None:
    from vibsim.command_line.jobs.ro_crate import write_crate

    if narrowed:
        raise click.UsageError("--ro-crate takes the file whole; leave --events, --window and --along out")
    written = write_crate(file, folder, force)
    if settings.json:
        print_json({"file": file, "written": written})
    elif not settings.quiet:
        say(f"{folder} written", err=True)
