"""The whole report: runs, numbers, figures, and the pages that tell them, into one folder.

DIR/report.html, report.txt    the audit
DIR/figures/                   one file for each figure, and all-figures: one page with all
DIR/runs/                      the trajectories
DIR/branches/                  orbits over the no-load speed
DIR/sweeps/                    motors over the no-load speed, up and down, with and without stop
DIR/numbers.json               what was measured
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

from vibsim.cases import load_case
from vibsim.evidence.reports.claims import Claim, Finding, Numbers
from vibsim.evidence.reports.figures import (
    FORMATS,
    obtain_sweeps,
    write_evidence,
    write_figures,
    write_load_curves,
    write_page,
    write_search,
    write_sommerfeld,
)
from vibsim.evidence.reports.measurements import PAPER_RUNS, MeasurementInterrupted, NumbersFile
from vibsim.evidence.reports.pages import Picture, render_html, render_text
from vibsim.evidence.reports.paper_document import judge_claims, paper_document
from vibsim.evidence.reports.paper_figures import growth_figure, obtain_branches, paper_figures, powers_figure
from vibsim.evidence.reports.paper_numbers import Tell, measure_paper
from vibsim.evidence.reports.true_motions import obtain
from vibsim.orbits.branches.branch import Branch
from vibsim.plots import style
from vibsim.plots.subject import Subject
from vibsim.results import Result, ResultFileError
from vibsim.results.hdf5_reading import reason
from vibsim.results.output_files import Lock, output_file
from vibsim.signals import held_back
from vibsim.sweeps import SweepResult


@dataclass(frozen=True)
class Report:
    """What was written: the report's pages and the findings on the claims; how many runs were simulated."""

    html: Path
    text: Path
    findings: list[tuple[Claim, Finding]]
    simulated: int


def write_paper(
    folder: str | Path,
    formats: Sequence[str] = FORMATS,
    tell: Tell = lambda *_: True,
    fresh: bool = False,
) -> Report:
    """Write the report into `folder`, which is made where it is missing.

    Parameters
    ----------
    formats : of the figures, out of png, pdf and svg; png is always written, the pages need it
    tell : given what is being done, how much of it is, and of how much; returns False to stop
    fresh : simulate and measure everything again

    Otherwise runs and numbers that are there already and of the same cases are taken over. Raises
    EngineError when a run fails, ResultFileError when a file cannot be written, and Interrupted when `tell`
    says to stop; what was finished before is kept. One process at a time writes a report.
    """
    root = _made_folder(Path(folder))
    with held_back():
        lock = Lock(root / "report", folder)
    try:
        return _write_report(root, formats, tell, fresh)
    finally:
        lock.release()


def _write_report(root: Path, formats: Sequence[str], tell: Tell, fresh: bool) -> Report:
    results, simulated = obtain_runs(root / "runs", tell, fresh)
    follow = cache(partial(obtain_branches, root / "branches", tell, fresh))
    numbers = measure_paper(results, follow, NumbersFile(root / "numbers.json", fresh), tell)
    sweeps = obtain_sweeps(root / "sweeps", tell, fresh)
    pictures, audit = draw_pictures(results, follow(), numbers, sweeps, root / "figures", formats, tell)
    document = paper_document(numbers, pictures, audit)
    pages = {root / "report.html": render_html(document), root / "report.txt": render_text(document)}
    for path, text in pages.items():
        with output_file(path, force=True, encoding="utf-8") as file:
            file.write(text)
    return Report(root / "report.html", root / "report.txt", judge_claims(numbers), simulated)


def _made_folder(root: Path) -> Path:
    try:
        for name in ("runs", "branches", "sweeps", "figures"):
            (root / name).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultFileError(f"{root}: cannot write: {reason(error)}") from error
    return root


def obtain_runs(folder: Path, tell: Tell, fresh: bool = False) -> tuple[dict[str, Result], int]:
    """The runs of all cases by name, and how many had to be simulated."""
    results, simulated, total = {}, 0, len(PAPER_RUNS)
    for done, name in enumerate(PAPER_RUNS):
        watch = partial(_still_at, tell, done, total)
        results[name], anew = obtain(load_case(name), folder, watch, fresh)
        simulated += anew
        if not tell("simulating", done + 1, total):
            raise MeasurementInterrupted
    return results, simulated


def _still_at(tell: Tell, done: int, total: int, t_reached: float) -> bool:
    return tell("simulating", done, total)


def draw_pictures(
    results: Mapping[str, Result],
    branches: Mapping[str, Branch],
    numbers: Numbers,
    sweeps: Mapping[str, SweepResult],
    folder: Path,
    formats: Sequence[str],
    tell: Tell,
) -> tuple[list[Picture], dict[str, Picture]]:
    """The figures of the paper, and those of the audit by name."""
    subjects = {
        name: Subject(f"{name}.h5", name, "trajectory", result.case, result)
        for name, result in results.items()
    }
    with style.applied():
        *pictures, growth, powers = write_figures(
            [*paper_figures(), growth_figure(), powers_figure()], subjects, folder, formats, tell
        )
        write_page(pictures, folder, formats)
        evidence = write_evidence(numbers, folder, formats)
        search = write_search(numbers, folder, formats)
        load = write_load_curves(branches, folder, formats)
        sommerfeld = write_sommerfeld(sweeps, folder, formats)
        audit = {"growth": growth, "powers": powers, "search": search, "load-curves": load}
        return pictures, {**audit, "sommerfeld": sommerfeld, **evidence}
