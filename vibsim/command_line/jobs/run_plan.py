"""What `vibsim run` is to do: which case goes into which file, settled before anything is computed."""

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.text.summary import case_lines, heading, print_lines
from vibsim.files.errors import ResultFileError, reason
from vibsim.files.output_file import RESULT_SUFFIXES, check_output, check_result_name
from vibsim.opening import open_result
from vibsim.results import kind_of, names_a_result

if TYPE_CHECKING:
    from vibsim.cases import Case


@dataclass(frozen=True)
class Job:
    """One case and the file that it is written to, as the user would name it."""

    case: "Case"
    output: Path
    folder: Path | None = None  # of the file, where it is to be made if it is missing
    tangent: tuple[int, float] = (0, 0.0)  # number of Lyapunov exponents, and from when on [s]


def plan(sources: tuple[str, ...], changes: dict[str, str], output: str | None) -> list[Job]:
    """The jobs of one `vibsim run`, every case read.

    Raises CaseError, ResultFileError, and UsageError where two cases would go into one file, or where a file
    is called what an HDF5 file is not.
    """
    cases = [read_case(source, changes) for source in sources]
    names = [_name_of(case, source) for case, source in zip(cases, sources, strict=True)]
    folder, paths = _outputs(names, output)
    return [Job(case, path, folder) for case, path in zip(cases, paths, strict=True)]


def check_outputs(jobs: list[Job], force: bool) -> None:
    """Raise ResultFileError for an output that exists (unless `force`) or cannot be written.

    The folder of several is made where it is missing.
    """
    for folder in {job.folder for job in jobs if job.folder is not None}:
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


ASIDE = {"engine", "jobs", "scheduler", "max_points", "output", "force"}  # options that change no plan


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


def check_engine(engine: str) -> None:
    """Usage error where the C engine is asked for and was not built."""
    from vibsim.engine.choice import compiled

    if engine == "c" and not compiled():
        raise click.UsageError("--engine c: this installation has no C engine; leave --engine out")


def check_digits(digits: int | str | None, engine: str) -> None:
    """Usage error where many digits are asked for and cannot be had."""
    if digits is None:
        return
    from vibsim.physics.arithmetic.number_kits import MultiprecisionMissing, installed_library

    if engine == "c":
        raise click.UsageError("--digits needs the Python engine; the C engine has doubles only")
    try:
        installed_library()
    except MultiprecisionMissing as error:
        raise click.UsageError(f"--digits: {error}") from error


def with_exponents(
    jobs: list[Job], count: int | str | None, discard: str | None, digits: int | str | None
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


def _tangent(case: "Case", count: int | str, discard: str | None) -> tuple[int, float]:
    from vibsim.analysis.discard import HALF, parse_discard
    from vibsim.engine.tangent.tangent_space import dimension

    scene = case.scene()
    if count != "all" and int(count) > dimension(scene):
        raise click.UsageError(f"--lyapunov {count}: {case.name} has {dimension(scene)} exponents")
    try:
        begin = (HALF if discard is None else parse_discard(discard)).time(scene.t_end)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="'--discard'") from error
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
