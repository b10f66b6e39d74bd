"""Run the cases of `vibsim run` one by one, with progress, interruption and a summary of each."""

import time
from functools import partial

from vibsim.command_line.errors import RUN_FAILED, told
from vibsim.command_line.jobs.run_plan import Job
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import PATIENCE, Progress
from vibsim.command_line.terminal.slow_run import SlowRun
from vibsim.command_line.text.quantities import size
from vibsim.command_line.text.summary import heading, print_lines, result_lines, summary_object
from vibsim.engine.errors import EngineError
from vibsim.files.signals import interrupted_with
from vibsim.files.writers import held_until, partial_path
from vibsim.physics.rates import fastest_damping
from vibsim.results import Result, simulate_to_file


def run_all(
    jobs: list[Job],
    engine: str,
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
                _run_one(job, engine, force, settings, interruption, trust, digits)
            except EngineError as error:
                what = f"Error: {job.case.name}: {error}; {_left(job)}"
                code = told(what, RUN_FAILED, settings.json, case=job.case.name)
            if interruption.signum is not None:
                return interruption.exit_code
    return code


def _run_one(
    job: Job,
    engine: str,
    force: bool,
    settings: Settings,
    interruption: Interruption,
    trust: bool,
    digits: int | str | None,
) -> None:
    began = time.perf_counter()
    scene = job.case.scene()
    t_end = scene.t_end
    progress = Progress(not settings.quiet, PATIENCE)
    slow = SlowRun(
        job.case.name,
        t_end,
        shown=not settings.quiet,
        damping=fastest_damping(scene),
        lossless=[stop.name for _, stop in scene.rigid_stops if stop.e == 1],
    )

    def watch(t: float) -> bool:
        progress.show(job.case.name, t, t_end)
        slow.note(t)
        return interruption.signum is None

    try:
        with interrupted_with(partial(_left, job)):
            result = simulate_to_file(job.case, job.output, engine, force, watch, trust, digits, job.tangent)
    finally:
        progress.close()
    if not result.complete:
        say(f"interrupted: {job.output} holds the run until {result.t_reached:g} s", err=True)
    if settings.json:
        print_json(summary_object(result, job.output))
    elif not settings.quiet:
        _print_summary(job, result, time.perf_counter() - began, settings)


def _left(job: Job) -> str:
    """What a run that broke off has left."""
    path = partial_path(job.output)
    reached = held_until(path)
    return f"what came before is in {path}, until {reached:g} s" if reached > 0.0 else "nothing came before"


def _print_summary(job: Job, result: Result, took: float, settings: Settings) -> None:
    attrs = result.attrs
    lines = result_lines(result)
    if settings.verbose:
        lines.append(("work", f"{attrs['steps']} steps, {attrs['evaluations']} evaluations"))
        lines.append(("fingerprint", attrs["case_sha256"]))
    say(heading(job.case.name, job.case.title))
    print_lines([*lines, ("file", f"{job.output} ({size(job.output)}), {took:.2f} s")])
