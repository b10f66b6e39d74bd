"""vibsim export: a trajectory for spreadsheets and MATLAB."""

from pathlib import Path

import click

from vibsim.command_line.examples import examples
from vibsim.command_line.parameters import FILE, WINDOW
from vibsim.command_line.terminal import print_json, say


@click.command(
    "export",
    short_help="Write a trajectory as CSV or MAT.",
    epilog=examples(
        "vibsim export II-B.h5 -o II-B.csv",
        "vibsim export II-B.h5 -o impacts.csv --events --window 100:110",
        "vibsim export II-B.h5 -o II-B.mat             # samples and events",
    ),
)
@click.argument("file", metavar="FILE", type=FILE)
@click.option("-o", "--output", metavar="FILE", type=FILE, required=True, help="A .csv or .mat file.")
@click.option("--events", is_flag=True, help="CSV: write the events, not the samples.")
@click.option("--window", type=WINDOW, metavar="A:B", default=":", help="Only this span of time [s].")
@click.option("--force", is_flag=True, help="Replace an existing output file.")
@click.pass_context
def command(ctx, file, output, events, window, force):
    """Write the trajectory in FILE as CSV or MAT, by the suffix of the output.

    All values are in SI units, to the last digit. A CSV file has one line of column names; the kinds of
    events are written as words. A MAT file holds the columns by name and a struct `events`.
    """
    from vibsim.files.errors import ResultFileError
    from vibsim.opening import open_result
    from vibsim.results.export_csv import write_csv
    from vibsim.results.export_mat import write_mat

    suffix = Path(output).suffix.lower()
    if suffix not in (".csv", ".mat"):
        raise click.UsageError(f"-o {output}: the suffix must be .csv or .mat")
    if events and suffix == ".mat":
        raise click.UsageError("--events is for CSV; a MAT file holds samples and events")
    result = open_result(file)
    if result.attrs["vibsim_kind"] != "trajectory":
        raise ResultFileError(f"{file}: holds no trajectory")
    _check(result, window, file, events)
    if suffix == ".mat":
        write_mat(result, output, window, force)
    else:
        write_csv(result, output, window, force, events)
    if ctx.obj.json:
        print_json({"file": file, "written": [output]})
    elif not ctx.obj.quiet:
        say(f"{output} written", err=True)


def _check(result, window, file, events):
    """Usage error for a window with nothing of the run in it; beside samples, events may be missing."""
    from vibsim.results.windows import rows_within

    time = result.column("time")
    times = [time, result.event_column("t")] if events else [time]
    within = [rows_within(column, window) for column in times]
    if all(rows.start == rows.stop for rows in within):
        last = float(time[-1]) if len(time) else 0.0
        shown = ":".join(f"{end:g}" for end in window)
        raise click.UsageError(
            f"--window {shown}: nothing of {file} lies in it; its samples end at {last:g} s"
        )
