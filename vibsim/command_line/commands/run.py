"""vibsim run: cases in, trajectories out."""

import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from vibsim.cases.problems import counted
from vibsim.command_line.main import RUN_FAILED, told
from vibsim.command_line.options import (
    CASE,
    DIGITS,
    DISCARD,
    EXPONENTS,
    FILE,
    RAMP,
    OneOf,
    Settings,
    examples,
    joined,
    once_each,
    set_option,
)
from vibsim.command_line.terminal import PROGRESS_AFTER, Progress, SlowRun, print_json, say
from vibsim.command_line.text import case_lines, heading, print_lines, result_lines, size, summary_object
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.physics.parts import STATE
from vibsim.physics.precision import NOT_BUILT, is_built
from vibsim.physics.rates import fastest_damping
from vibsim.results import Result, kind_of, names_a_result, simulate_to_file
from vibsim.results.hdf5_reading import ResultFileError, reason
from vibsim.results.output_files import (
    RESULT_SUFFIXES,
    check_output,
    check_result_name,
    held_until,
    partial_path,
)
from vibsim.results.simulation import open_result
from vibsim.signals import Interruption, interrupted_with

if TYPE_CHECKING:
    from vibsim.analysis.cycles import Discard
    from vibsim.cases import Case


METHODS = ["auto", "closed_form", "taylor"]


@click.command(
    "run",
    short_help="Run cases and write their trajectories.",
    epilog=examples(
        "vibsim run II-B                               # into II-B.h5",
        "vibsim run my.yaml -s c='0.03 N s/m' -o damped.h5",
        "vibsim run I-A I-B I-C -o runs/               # three files in one folder",
        "vibsim run II-B --t-end 20s --every 1ms --plot II-B.png",
        "vibsim run II-B --ramp Omega0=3:7Hz --over 400s -o up.h5   # a slow run-up",
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
@click.option(
    "--ramp",
    "ramps",
    metavar="KEY=FROM:TO[:BACK]",
    multiple=True,
    type=RAMP,
    callback=once_each,
    help="Change a value evenly while the run goes on; repeatable.",
)
@click.option("--over", metavar="TIME", help="How long --ramp takes each way; the end of the run too.")
@click.option("--t-end", metavar="TIME", help="End of the run, such as 20s.")
@click.option("--every", metavar="TIME", help="Time between samples, such as 5ms.")
@click.option("--method", type=OneOf(METHODS), help="How the motion between events is computed.")
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
    type=DISCARD,
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
    ramps: tuple[tuple[str, str], ...],
    over: str | None,
    t_end: str | None,
    every: str | None,
    method: str | None,
    picture: str | None,
    trust: bool,
    digits: int | str | None,
    lyapunov: int | str | None,
    discard: "Discard | None",
    dry_run: bool,
    force: bool,
) -> int:
    """Run each CASE and write its trajectory to an HDF5 file.

    A CASE is a YAML file, the name of a shipped case (see `vibsim cases`), - for standard input, or an HDF5
    file that vibsim wrote: its case is run again. --ramp runs a machine slowly through a resonance.
    """

    check_digits(digits)
    check_picture(picture, len(sources), force or dry_run)
    run_settings = {"run.t_end": t_end, "run.every": every, "run.method": method}
    values = joined(changes, run_settings)
    jobs = plan(sources, *with_ramps(values, ramps, over), output)
    jobs = with_exponents(jobs, lyapunov, discard, digits)
    if dry_run:
        print_plan(jobs, ctx.obj)
        return 0
    check_outputs(jobs, force)
    code = run_all(jobs, force, ctx.obj, trust, digits)
    if picture and code == 0:
        from vibsim.plots import plot_run

        plot_run(jobs[0].output, picture, force=force)
    return code


# What `vibsim run` is to do: which case goes into which file, settled before anything is computed.


@dataclass(frozen=True)
class Job:
    """One case and the file that it is written to, as the user would name it."""

    case: "Case"
    output: Path
    folder: Path | None = None  # of the file, where it is to be made if it is missing
    tangent: tuple[int, float] = (0, 0.0)  # number of Lyapunov exponents, and from when on [s]


Changed = Callable[["Case"], "Case"]


def with_ramps(
    values: dict[str, str], ramps: tuple[tuple[str, str], ...], over: str | None
) -> tuple[dict[str, str], Changed | None]:
    """Values by key, the end of the run among them where ramps set it, and what makes ramps of a case.

    Raises UsageError for ramps without a time, a time without ramps and a key that has a value too.
    """
    if not ramps and over is None:
        return values, None
    if not ramps or over is None:
        missing = "--over needs a --ramp" if not ramps else "--ramp needs --over, how long it takes"
        raise click.UsageError(f"{missing}, such as --ramp Omega0=3:7Hz --over 400s")
    from vibsim.cases.ramps import check_time, end_of, ramped, read_ramp

    try:
        check_time(over)
    except ValueError as error:
        raise click.UsageError(f"--{error}") from error
    for key, _ in ramps:
        same = [given for given in values if f".{given}".endswith(f".{key}") or key.endswith(f".{given}")]
        if same:
            raise click.UsageError(f"--ramp {key} and --set {same[0]} give one value; choose one")
    try:
        read = [read_ramp(*ramp) for ramp in ramps]
        end = {} if {"t_end", "run.t_end"} & values.keys() else {"run.t_end": end_of(read, over)}
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="'--ramp'") from error

    def changed(case: "Case") -> "Case":
        try:
            return ramped(case, read, over)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="'--ramp'") from error

    return {**values, **end}, changed


def plan(
    sources: tuple[str, ...], changes: dict[str, str], ramp: Changed | None, output: str | None
) -> list[Job]:
    """The jobs of one `vibsim run`, every case read; ramp: what is made of each case that is read.

    Raises CaseError, ResultFileError, and UsageError where two cases would go into one file, or where a file
    is called what an HDF5 file is not.
    """
    cases = [read_case(source, changes) for source in sources]
    cases = [ramp(case) for case in cases] if ramp else cases
    names = [_name_of(case, source) for case, source in zip(cases, sources, strict=True)]
    folder, paths = _outputs(names, output)
    return [Job(case, path, folder) for case, path in zip(cases, paths, strict=True)]


def check_outputs(jobs: list[Job], force: bool) -> None:
    """Raise ResultFileError for an output that exists (unless `force`) or cannot be written.

    The folder of several is made where it is missing.
    """
    for folder in dict.fromkeys(job.folder for job in jobs if job.folder is not None):
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise ResultFileError(f"{folder}: cannot make the folder: {reason(error)}") from error
    for job in jobs:
        check_output(job.output, force)


def hdf5_name(output: str) -> str:
    """The name of an output file as given. Raises UsageError where its suffix promises another format."""
    try:
        check_result_name(output)
    except ResultFileError as error:
        raise click.UsageError(f"-o {error}") from None
    return output


def read_case(source: str, changes: dict[str, str]) -> "Case":
    """A case from a YAML file, a shipped name, "-", or the file of a run, sweep, branch or locus."""
    from vibsim.cases import load_case

    if not names_a_result(source):
        return load_case(source, changes)
    if kind_of(source) not in ("trajectory", "sweep", "branch", "locus"):
        allowed = "a case, or the file of a run, sweep, branch or locus"
        raise ResultFileError(f"{source}: holds no run; give {allowed}")
    result = open_result(source)
    case: Case = replace(result.case, text=result.attrs["case_yaml"])
    return case.with_values(changes) if changes else case


ASIDE = {"jobs", "scheduler", "max_points", "output", "force"}  # options that change no plan


def to_be_completed(source: str, kinds: tuple[str, ...], ctx: click.Context) -> Any:
    """The result of one of the kinds in a file that is given alone, to be completed by the plan in it.

    None where the source is anything else. Raises UsageError for options that change a plan, ResultFileError.
    """
    if not names_a_result(source) or kind_of(source) not in kinds:
        return None
    given = [
        option.opts[-1]
        for option in ctx.command.params
        if isinstance(option, click.Option) and option.expose_value and option.name not in ASIDE
        and ctx.get_parameter_source(str(option.name)) is ParameterSource.COMMANDLINE
    ]  # fmt: skip
    if given:
        raise click.UsageError(f"{source} is completed by the plan that it holds; leave {given[0]} out")
    return open_result(source)


def check_digits(digits: int | str | None) -> None:
    """Usage error where many digits are asked for and cannot be had."""
    if digits is not None and not is_built(0):
        raise click.UsageError(f"--digits: {NOT_BUILT}")


def with_exponents(
    jobs: list[Job], count: int | str | None, discard: "Discard | None", digits: int | str | None
) -> list[Job]:
    """The jobs with so many Lyapunov exponents ("all": as many as each case has) behind a transient.

    Raises UsageError for more exponents than a case has, a transient that leaves nothing of a run, a
    transient without exponents, and exponents with digits.
    """
    if count is None:
        if discard is not None:
            raise click.UsageError("--discard leaves a transient out of --lyapunov, which is not given")
        return jobs
    if digits is not None:
        raise click.UsageError("--lyapunov needs doubles; leave --digits out")
    return [replace(job, tangent=_tangent(job.case, count, discard)) for job in jobs]


def _tangent(case: "Case", count: int | str, discard: "Discard | None") -> tuple[int, float]:
    from vibsim.analysis.cycles import HALF

    scene = case.scene()
    if count != "all" and int(count) > dimension(scene):
        raise click.UsageError(f"--lyapunov {count}: {case.name} has {counted(dimension(scene), 'exponent')}")
    begin = (HALF if discard is None else discard).time(scene.t_end)
    if not begin < scene.t_end:
        raise click.UsageError(f"--discard {discard}: leaves nothing of {case.name}, {scene.t_end:g} s")
    return (dimension(scene) if count == "all" else int(count)), begin


def check_picture(picture: str | None, count: int, force: bool) -> None:
    """Settle before the run that its picture can be written.

    Raises UsageError for several runs, PlotError for its format, ResultFileError.
    """
    if picture is None:
        return
    if count > 1:
        raise click.UsageError("--plot draws one run; for several use vibsim plot")
    from vibsim.plots.picture import picture_suffix

    picture_suffix(picture)
    check_output(picture, force)


def print_plan(jobs: list[Job], settings: Settings) -> None:
    """Print what would be run: each case with its defaults filled in, and its file."""
    for job in jobs:
        resolved = json.loads(job.case.resolved_json())
        if settings.json:
            facts = {"file": str(job.output), "file_exists": os.path.exists(job.output)}
            print_json({**facts, "case": resolved, "case_sha256": job.case.sha256})
            continue
        if settings.quiet:
            continue
        say(heading(job.case.name, job.case.title))
        file = f"{job.output} (not written: dry run{_in_the_way(job)})"
        print_lines([*case_lines(job.case), ("file", file)])
        print_json(resolved, indent=2)


def _in_the_way(job: Job) -> str:
    return "; it exists, and --force would replace it" if os.path.exists(job.output) else ""


def _name_of(case: "Case", source: str) -> str:
    """The file of a run unless it is given; the run of a file does not go into that file."""
    name = f"{case.name}.h5"
    same = names_a_result(source) and os.path.exists(name) and os.path.samefile(name, source)
    return f"{case.name}-again.h5" if same else name


def _outputs(names: list[str], output: str | None) -> tuple[Path | None, list[Path]]:
    """The folder that may have to be made, and the file of each case."""
    if len(set(names)) < len(names):
        repeated = next(name for name in names if names.count(name) > 1)
        raise click.UsageError(f"two of the cases would be written to {repeated}; run them one by one")
    if output is None:
        return None, [Path(name) for name in names]
    in_folder = os.path.isdir(output)  # no for what cannot be, such as too long a name
    if len(names) > 1 and Path(output).suffix.lower() in RESULT_SUFFIXES and not in_folder:
        raise click.UsageError(f"-o {output}: several cases need a folder, such as {Path(output).stem}/")
    if in_folder or len(names) > 1 or output.endswith(("/", os.sep)):
        return Path(output), [Path(output) / name for name in names]
    return None, [Path(hdf5_name(output))]


# Run the cases of `vibsim run` one by one, with progress, interruption and a summary of each.


def run_all(
    jobs: list[Job],
    force: bool,
    settings: Settings,
    trust: bool = True,
    digits: int | str | None = None,
) -> int:
    """Run the jobs; returns the exit code. One that fails does not keep the others from running."""
    code = 0
    with Interruption() as interruption:
        for job in jobs:
            try:
                _run_one(job, force, settings, interruption, trust, digits)
            except EngineError as error:
                what = f"Error: {job.case.name}: {error}; {_left(job)}"
                code = told(what, RUN_FAILED, settings.json, case=job.case.name)
            if interruption.signum is not None:
                return interruption.exit_code
    return code


def _run_one(
    job: Job,
    force: bool,
    settings: Settings,
    interruption: Interruption,
    trust: bool,
    digits: int | str | None,
) -> None:
    began = time.perf_counter()
    scene = job.case.scene()
    t_end = scene.t_end
    progress = Progress(not settings.quiet, PROGRESS_AFTER)
    slow = SlowRun(
        job.case.name,
        t_end,
        shown=not settings.quiet,
        damping=fastest_damping(scene),
        lossless=[stop.name for _, stop in scene.rigid_stops if stop.e == 1],
        states=[body.name for body in scene.bodies if body.kind == STATE],
    )

    def watch(t: float) -> bool:
        progress.show(job.case.name, t, t_end)
        slow.note(t)
        return interruption.signum is None

    with progress, interrupted_with(partial(_left, job)):
        result = simulate_to_file(job.case, job.output, force, watch, trust, digits, job.tangent)
    if not result.complete:
        say(f"interrupted: {job.output} holds the run until {result.t_reached:g} s", err=True)
    if settings.json:
        print_json(summary_object(result, job.output))
    elif not settings.quiet:
        _print_summary(job, result, time.perf_counter() - began, settings)


def _left(job: Job) -> str:
    """Message on the file that a run leaves which broke off."""
    path = partial_path(job.output)
    reached = held_until(path)
    return f"what came before is in {path}, until {reached:g} s" if reached > 0.0 else "nothing came before"


def _print_summary(job: Job, result: Result, took: float, settings: Settings) -> None:
    attrs = result.attrs
    lines = result_lines(result)
    if settings.verbose:
        lines.append(
            ("work", f"{counted(attrs['steps'], 'step')}, {counted(attrs['evaluations'], 'evaluation')}")
        )
        lines.append(("fingerprint", attrs["case_sha256"]))
    say(heading(job.case.name, job.case.title))
    print_lines([*lines, ("file", f"{job.output} ({size(job.output)}), {took:.2f} s")])
