"""vibsim bench: speed against error, vibsim beside its peers."""

import json
import time
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from math import isfinite
from pathlib import Path

import click

from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.command_line.commands.run import check_digits, check_picture, hdf5_name, read_case
from vibsim.command_line.main import told
from vibsim.command_line.options import (
    CASE,
    FILE,
    FiniteRange,
    NameList,
    Settings,
    examples,
    joined,
    set_option,
)
from vibsim.command_line.terminal import Progress, print_json, say, style
from vibsim.command_line.text import heading, metres, print_lines, seconds, size
from vibsim.evidence.benchmark.bench_result import (
    FAILED,
    SLOWER,
    BenchResult,
    BenchRow,
    BenchTruth,
    beside_reference,
    facts,
    fastest,
    impacts_per_second,
    most_accurate,
    reference,
    refusals,
)
from vibsim.evidence.benchmark.plan import (
    FAMILIES,
    BenchError,
    BenchPlan,
    families_named,
    family_of,
    make_plan,
)
from vibsim.evidence.benchmark.running import run_bench, truth_at_hand, truth_from
from vibsim.evidence.peers.solvers import CONTACTS
from vibsim.results.output_files import check_output
from vibsim.signals import Interruption, interrupted_with

DEFAULT_CASE = "II-B"
LIMIT = 20.0


METHODS = NameList("methods", [family.name for family in FAMILIES], lambda names, _: families_named(names))


@click.command(
    "bench",
    short_help="Measure speed against error, beside other solvers.",
    epilog=examples(
        "vibsim bench                                   # II-B, into II-B-bench.h5; some minutes",
        "vibsim bench I-C --t-end 20s --plot I-C.png",
        "vibsim bench II-B --methods taylor,heyoka,dop853",
        "vibsim bench gallery/impact-oscillator-coco    # impacts per second, errors beside them",
        "vibsim bench II-B -o again.h5 --truth II-B-bench.h5",
        before="Every method gives the same states, and is judged by a run of many digits. Run it on a quiet "
        "machine.",
    ),
)
@click.argument("source", metavar="[CASE]", required=False, type=CASE)
@set_option
@click.option("--t-end", metavar="TIME", help="End of the span. [default: that of the case, at most 100 s]")
@click.option(
    "--methods", type=METHODS, default="", metavar="NAME[,NAME..]",
    help=f"Who takes part: {', '.join(family.name for family in FAMILIES)}. [default: all]",
)  # fmt: skip
@click.option(
    "--limit", type=FiniteRange(min=0, min_open=True), default=LIMIT, metavar="SECONDS",
    show_default=True, help="A run is stopped after so long.",
)  # fmt: skip
@click.option("--truth", type=FILE, metavar="FILE", help="Take the truth from this bench.")
@click.option("-o", "--output", type=FILE, metavar="FILE", help="Output file. [default: NAME-bench.h5]")
@click.option("--plot", "picture", type=FILE, metavar="FILE", help="Draw it too: a .png, .pdf or .svg file.")
@click.option("--force", is_flag=True, help="Replace existing output files.")
@click.pass_context
def command(
    ctx: click.Context,
    source: str | None,
    changes: tuple[tuple[str, str], ...],
    t_end: str | None,
    methods: list[str],
    limit: float,
    truth: str | None,
    output: str | None,
    picture: str | None,
    force: bool,
) -> int:
    """Measure what vibsim and other solvers take for CASE, and how right they are.

    For every method: time, impacts per second, steps, right-hand sides, events found, missed and made up,
    errors, and until when it is faithful (error within 1 mm, or a twentieth of the largest displacement where
    that is less). A method that cannot take the case says so. CASE is a YAML file, the name of a shipped
    case, - for standard input, or the HDF5 file of a run.
    """

    if source is None:
        source = DEFAULT_CASE
        if not ctx.obj.quiet:
            say(f"no case given: measuring {source}", err=True)
    joined(changes, {"run.t_end": t_end})  # one of them alone
    plan = read_plan(source, dict(changes), t_end, methods, limit)
    return run_jobs(plan, output, picture, truth, force, ctx.obj)


# What `vibsim bench` does: settle everything, run it with progress and interruption, print the table.


def read_plan(
    source: str, changes: dict[str, str], t_end: str | None, methods: Sequence[str], limit: float
) -> BenchPlan:
    """The plan that the options describe. Raises CaseError, ResultFileError, and UsageError for the span."""
    case = read_case(source, changes)
    try:
        return make_plan(case, t_end, methods, limit)
    except BenchError as error:
        raise click.UsageError(str(error)) from None


def run_jobs(
    plan: BenchPlan,
    output: str | None,
    picture: str | None,
    truth_file: str | None,
    force: bool,
    settings: Settings,
) -> int:
    """Run a bench; returns the exit code."""
    path = Path(hdf5_name(output) if output is not None else f"{plan.case.name}-bench.h5")
    check_output(path, force)
    check_picture(picture, 1, force)
    truth = _truth(plan, path, truth_file)
    began, rows_begun, progress = time.perf_counter(), False, Progress(not settings.quiet)
    with Interruption() as interruption, interrupted_with(lambda: _kept(path, rows_begun)), progress:

        def watch(what: str, share: float) -> bool:
            nonlocal rows_begun
            rows_begun = what != "truth"
            if what == "truth":
                progress.show("truth", share * plan.times[-1], plan.times[-1])
            else:
                progress.show("methods", share, 1.0, what)
            return interruption.signum is None

        bench = run_bench(plan, path, truth, force, watch)
    if bench is None:
        return told(f"interrupted: {_kept(path, False)}", interruption.exit_code, settings.json)
    if settings.json:
        print_json({"file": str(path), **facts(bench)})
    elif not settings.quiet:
        print_bench(bench, path, time.perf_counter() - began)
    if picture and bench.rows:
        from vibsim.plots import plot_run

        plot_run(path, picture, force=force)
    if not bench.complete:
        say(f"interrupted: {_kept(path, True)}", err=True)
        return interruption.exit_code
    return 0


def _kept(path: Path, rows_begun: bool) -> str:
    """Message on the rows that an interrupted bench leaves."""
    if not rows_begun:
        return "stopped before the truth was computed; nothing is kept"
    return f"{path} holds the rows that were done, and the truth; --truth {path} uses it again"


def _truth(plan: BenchPlan, path: Path, file: str | None) -> BenchTruth | None:
    """The truth of `file`, else of the file about to be replaced; None to compute it."""
    if file is not None:
        try:
            return truth_from(plan, file)
        except BenchError as error:
            raise click.UsageError(f"--truth: {error}") from None
    truth = truth_at_hand(plan, path)
    if truth is None:
        check_digits("auto")
    return truth


# A bench as a table for people.


SETTING = 22
NOTHING = "-"
SETUP = 0.05  # s before the first run that are worth a word


def print_bench(
    bench: BenchResult,
    path: str | Path | None,
    took: float | None = None,
    more: Iterable[tuple[str, str]] = (),
) -> None:
    """Print what was measured, the table, what it says, and more lines."""
    say(heading(bench.attrs["case_name"], bench.attrs["title"]))
    print_lines(head_lines(bench))
    say()
    for line in table_lines(bench):
        say(line)
    say()
    file = [("file", _file_text(path, took))] if path else []
    print_lines([*verdict_lines(bench), *more, *file])


def head_lines(bench: BenchResult) -> list[tuple[str, str]]:
    """Case, truth and machine, as labelled lines."""
    attrs, time = bench.attrs, bench["time"]
    truth = f"{attrs['truth_digits']} digits carried, {attrs['truth_digits_right']} right at the end"
    versions = [
        f"{name} {attrs[f'{name.lower()}_version']}" for name in ("Python", "numpy", "scipy", "heyoka")
    ]
    lines = [
        ("span", f"{seconds(float(time[-1]))}, compared at {counted(len(time), 'instant')}"),
        ("truth", f"{truth}; {attrs['truth_library']}, {attrs['truth_wall_time_s']:.3g} s"),
        ("times", "milliseconds per second of motion, medians; impacts per second of computing"),
        ("faithful", f"errors within {metres(bench.faithful_error, bench.error_unit)}"),
        ("machine", f"{attrs['processor']}, {counted(attrs['cores'], 'core')}; {attrs['platform']}"),
        ("versions", f"vibsim {attrs['vibsim_version']}, {', '.join(versions)}"),
    ]
    return lines if bench.complete else [*lines, ("incomplete", style("stopped early", fg="yellow"))]


def table_lines(bench: BenchResult) -> Iterator[str]:
    """The table, one group of rows per family."""
    yield from _header(bench)
    for method, rows in groupby(bench.rows, key=lambda row: row.method):
        group = list(rows)
        yield style(family_of(method).label, bold=True) + style(_note(group), dim=True)
        yield from (_row_text(bench, row) for row in group)
    for name in json.loads(bench.attrs["not_installed"]):
        family = family_of(name)
        yield style(family.label, bold=True) + f"  {family.remedy}"
    for name, sentence in refusals(bench).items():
        yield style(family_of(name).label, bold=True) + f"  {sentence}"


def _note(group: list[BenchRow]) -> str:
    """Remark that holds for all rows of a family and not for others."""
    setup = max((row.setup_time for row in group if row.runs), default=0.0)
    if setup > SETUP:
        return f"  (compiled beforehand in {setup:.2f} s at most)"
    contacts = any(set(row.events) == set(CONTACTS) for row in group)
    return "  (contacts only, read off its steps)" if contacts else ""


def _header(bench: BenchResult) -> list[str]:
    times = [f"{t:g} s" for t in bench.check_times]
    errors = "".join(f"{t:>9}" for t in times)
    largest = f"largest error [{bench.error_unit}] until"
    return [
        f"{'':{SETTING + 2}}{'time':>9}{'CPU':>9}{'impacts':>10}{'':>9}{'right-':>12}"
        f"{largest:>{9 * len(times)}}{'faithful':>10}{'events until then':>21}",
        f"{'':{SETTING + 2}}{'ms/s':>9}{'ms/s':>9}{'per s':>10}{'steps':>9}{'hand sides':>12}"
        f"{errors}{'until':>10}{'found':>7}{'missed':>7}{'extra':>7}",
    ]


def _row_text(bench: BenchResult, row: BenchRow) -> str:
    if row.status == FAILED:
        return f"  {row.setting:{SETTING}}" + style(f"  failed: {row.problem}", fg="red")
    count = row.counted()
    events = [NOTHING] * 3 if count is None else [str(n) for n in vars(count).values()]
    errors = [_error_text(row.error_until(bench["time"], t)) for t in bench.check_times]
    cells = [
        f"{_time_text(bench, row, row.wall_time):>9}{_time_text(bench, row, row.cpu_time):>9}",
        f"{_rate_text(impacts_per_second(bench, row)):>10}",
        f"{_count_text(row.steps):>9}{_count_text(row.evaluations):>12}",
        "".join(f"{text:>9}" for text in errors),
        f"{f'{row.faithful_time:.4g} s':>10}",
        "".join(f"{text:>7}" for text in events),
    ]
    return f"  {row.setting:{SETTING}}" + "".join(cells) + _remark(bench, row)


def _time_text(bench: BenchResult, row: BenchRow, took: float) -> str:
    """Milliseconds per second of motion; of a row that was stopped, what the whole span takes at least."""
    if row.status == SLOWER:
        return "> " + _short(1e3 * took / float(bench["time"][-1]))
    return _short(1e3 * took / row.t_reached)


def _remark(bench: BenchResult, row: BenchRow) -> str:
    best = [
        word
        for word, best in (("fastest", fastest(bench)), ("most accurate", most_accurate(bench)))
        if row is best
    ]
    text = style(f"  {', '.join(best)}", fg="green", bold=True) if best else ""
    if row.status == SLOWER:
        text += style(f"  stopped at {row.t_reached:.4g} s", fg="yellow")
    return text


def verdict_lines(bench: BenchResult) -> list[tuple[str, str]]:
    """vibsim's own row, and the most accurate row of every peer beside it."""
    ours = reference(bench)
    if ours is None:
        return []
    t = bench.telling_time
    error = f"{_error_text(ours.error_until(bench['time'], t))} {bench.error_unit}"
    numbers = f"{_short(1e3 * ours.time_per_second)} ms per second of motion, error {error} until {t:g} s"
    lines = [
        ("vibsim", f"{family_of(ours.method).label.removeprefix('vibsim, ')}, {ours.setting}: {numbers}")
    ]
    for i, each in enumerate(beside_reference(bench)):
        text = f"{family_of(each.row.method).label}, {each.row.setting}"
        ratio = f"{_ratio(each.times)} x the time, {_ratio(each.errors)} x the error"
        lines.append(("" if i else "beside it", f"{text:<46}{ratio}"))
    return lines


def _ratio(x: float) -> str:
    return number(x, 2) if x < 100 or x >= 1e5 else f"{float(f'{x:.2g}'):.0f}"


def _short(x: float) -> str:
    """Three digits without an exponent: 0.0512, 12.3, 2036."""
    return number(x, 3) if x < 1000 else f"{x:.0f}"


def _error_text(x: float) -> str:
    return number(x, 2) if isfinite(x) else NOTHING


def _rate_text(rate: float | None) -> str:
    return NOTHING if rate is None else _short(float(f"{rate:.3g}"))


def _count_text(n: int) -> str:
    return NOTHING if n < 0 else str(n)


def _file_text(path: str | Path, took: float | None) -> str:
    return f"{path} ({size(path)})" + ("" if took is None else f", {took:.1f} s")
