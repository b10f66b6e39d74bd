"""What `vibsim bench` does: settle everything, run it with progress and interruption, print the table."""

import time
from collections.abc import Sequence
from pathlib import Path

import click

from vibsim.command_line.errors import told
from vibsim.command_line.jobs.run_plan import check_digits, check_picture, hdf5_name, read_case
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import Progress
from vibsim.command_line.text.bench import print_bench
from vibsim.evidence.benchmark.errors import BenchError
from vibsim.evidence.benchmark.known_truth import truth_at_hand, truth_from
from vibsim.evidence.benchmark.plan import Plan, make_plan
from vibsim.evidence.benchmark.running import run_bench
from vibsim.evidence.benchmark.truth import Truth
from vibsim.files.output_file import check_output
from vibsim.files.signals import interrupted_with


def read_plan(
    source: str, changes: dict[str, str], t_end: str | None, methods: Sequence[str], limit: float
) -> Plan:
    """The plan that the options describe. Raises CaseError, ResultFileError, and UsageError for the span."""
    case = read_case(source, changes)
    try:
        return make_plan(case, t_end, methods, limit)
    except BenchError as error:
        raise click.UsageError(str(error)) from None


def run_jobs(
    plan: Plan,
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
    began, rows_begun = time.perf_counter(), False
    with Interruption() as interruption, interrupted_with(lambda: _kept(path, rows_begun)):
        progress = Progress(not settings.quiet)

        def watch(what: str, share: float) -> bool:
            nonlocal rows_begun
            rows_begun = what != "truth"
            if what == "truth":
                progress.show("truth", share * plan.times[-1], plan.times[-1])
            else:
                progress.show("methods", share, 1.0, what)
            return interruption.signum is None

        try:
            bench = run_bench(plan, path, truth, force, watch)
        finally:
            progress.close()
    if bench is None:
        return told(f"interrupted: {_kept(path, False)}", interruption.exit_code, settings.json)
    if settings.json:
        from vibsim.evidence.benchmark.description import facts

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
    """What an interrupted bench leaves."""
    if not rows_begun:
        return "stopped before the truth was computed; nothing is kept"
    return f"{path} holds the rows that were done, and the truth; --truth {path} uses it again"


def _truth(plan: Plan, path: Path, file: str | None) -> Truth | None:
    """The truth of `file`, else of the file about to be replaced; None to compute it."""
    if file is not None:
        try:
            return truth_from(plan, file)
        except BenchError as error:
            raise click.UsageError(f"--truth: {error}") from None
    truth = truth_at_hand(plan, path)
    if truth is None:
        check_digits("auto", "python")
    return truth
