"""The whole report: runs, numbers, figures, and the pages that tell them, into one folder.

DIR/report.html, report.txt    the audit
DIR/figures/                   one file for each figure, and all-figures: one page with all
DIR/runs/                      the trajectories
DIR/branches/                  orbits over the no-load speed
DIR/sweeps/                    motors over the no-load speed, up and down, with and without stop
DIR/numbers.json               what was measured

Its motions from rest are the true ones: runs of many digits, kept as states to restart from. In double
precision the motors are known for some 80 s of 300: errors grow a thousandfold every 20 s or so. A run of 30
to 140 digits (`vibsim run CASE --digits auto`) knows them to the end, but takes minutes and tens of
megabytes. Of each, true_motions/CASE.json keeps the row of one event in every two seconds, rounded to
doubles, and the state at the end to 25 digits. Between two such rows an ordinary run errs by no more than in
its first seconds, so that the whole motion is made again within a second (`true_motion`). Its error was
measured at all samples when the motion was kept; and what a piece has at its end can be compared with the row
that the next one begins with (`restarted`).

    python -m vibsim.evidence.reports.paper [CASE...]    (make true-motions)
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Context, Decimal
from functools import cache, partial
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import Case, load_case
from vibsim.engine.trajectory import flow_of, open_trajectory
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
from vibsim.evidence.reports.measurements import (
    EQUAL_FORCE,
    INERTIAS,
    LONG,
    MOTORS,
    PAPER_RUNS,
    PRINTED,
    PRINTED_MOTOR,
    SHIPPED_READINGS,
    Advance,
    MeasurementInterrupted,
    NumbersFile,
    Tell,
    at_voltage,
    measure_ensemble,
    measure_facts,
    measure_long_runs,
    measure_runs,
    obtain_run,
    starts,
    stored_run,
    unbalance,
)
from vibsim.evidence.reports.pages import Picture, render_html, render_text
from vibsim.evidence.reports.paper_document import judge_claims, paper_document
from vibsim.evidence.reports.paper_figures import growth_figure, paper_figures, powers_figure
from vibsim.evidence.reports.readings import (
    DAMPINGS,
    FOLLOWED,
    FREQUENCIES,
    GAPS_MM,
    LAWS,
    LONGER,
    REGIMES_NEARBY_STARTS,
    SOLVERS,
    followed_cases,
    made_of,
    measure_ends,
    measure_gaps,
    measure_nearby,
    measure_solvers,
    measure_without_stop,
    obtain_branches,
    search_plane,
    search_readings,
)
from vibsim.orbits.branches.branch import Branch
from vibsim.physics.parts import EVENT_KINDS
from vibsim.plots import style
from vibsim.plots.subject import Subject
from vibsim.results import Result, ResultFileError, open_trajectory_file, simulate_to_file
from vibsim.results.columns import tables_of
from vibsim.results.file_contents import origin
from vibsim.results.hdf5_reading import reason
from vibsim.results.output_files import Lock, output_file
from vibsim.results.recording import Watch
from vibsim.signals import held_back
from vibsim.sweeps import SweepResult

SEARCHED = ("II-B", "II-C")
EVERY = 2.0  # [s] between the rows that are kept: errors grow a hundredfold in that time, seldom more
ALONE = 1e-3  # [s] on either side of a row that is kept nothing else happens
BEYOND = 1e-4  # [s] by which a piece runs past the row that the next one begins with
SHOWN = Context(prec=25)  # digits of the state at the end
CHAOTIC = tuple(name for name in PAPER_RUNS if name not in PRINTED)  # the others are right in doubles
COUNTED = ("impacts", "sticks", "reversals", "events", "steps", "evaluations", "uncertified")
KNOWN = (*COUNTED, "certified", "rest_distance_needed", "grazing_margin", "grazing_time", "violations")

Table = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class TrueMotion:
    """Stored numbers of a run of many digits.

    Attributes
    ----------
    case, sha256 : name and fingerprint of the case
    made : date, digits carried, digits right at the end and how that is known, number library; and `error`,
        the greatest error of the displacements when the motion is made again [m]
    totals : counts of events and margins of the whole run
    end : state at the end, SI, decimal texts
    rows : rows of the table of events to restart from, by column
    """

    case: str
    sha256: str
    made: dict[str, Any]
    totals: dict[str, Any]
    end: dict[str, str]
    rows: dict[str, list[float]]

    @property
    def times(self) -> list[float]:
        """Of the rows [s]."""
        return self.rows["t"]

    def row(self, i: int) -> dict[str, float]:
        """Row `i` by column."""
        return {name: column[i] for name, column in self.rows.items()}


def motion_path(name: str) -> Path:
    """Path of the stored motion of a case."""
    return Path(str(resources.files("vibsim.evidence.reports"))) / "true_motions" / f"{name}.json"


def read_motion(case: Case) -> TrueMotion | None:
    """Stored numbers of a case; None where there are none, or where the case has changed since."""
    path = motion_path(case.name)
    if not path.is_file():
        return None
    motion = TrueMotion(**json.loads(path.read_text(encoding="utf-8")))
    return motion if motion.sha256 == case.sha256 else None


def obtain(case: Case, folder: Path, watch: Watch | None = None, fresh: bool = False) -> tuple[Result, bool]:
    """The run of a case in FOLDER/NAME.h5, and whether it had to be made: the true motion where one is kept,
    else as `paper_runs.obtain_run` has it.
    """
    motion = read_motion(case)
    if motion is None:
        return obtain_run(case, folder, watch, fresh)
    path = folder / f"{case.name}.h5"
    stored = None if fresh else stored_run(case, path)
    if stored is not None and stored.attrs.get("comment") == how_it_was_had(motion):
        return stored, False
    result = true_motion(case, motion)
    result.save(path, force=True)
    return result, True


def true_motion(case: Case, motion: TrueMotion) -> Result:
    """The whole motion, right to its end: restarted from each of the rows kept."""
    pieces = list(restarted(case, motion))
    samples = _joined([piece for piece, _, _ in pieces])
    events = _joined([piece for _, piece, _ in pieces])
    scene, error = case.scene(), motion.made["error"]
    samples["error_estimate"] = np.full(len(samples["time"]), error)
    end = float(scene.t_end)
    right = {
        "trust_horizon_s": end,
        "trust_tolerance_m": case.number("run.trust_tolerance"),
        "error_estimate_max": error,
    }
    attrs = {
        **origin(case, scene, flow_of(scene)),
        **motion.totals,
        **right,
        "date_created": motion.made["date"],
        "t_reached_s": end,
        "complete": 1,
        "comment": how_it_was_had(motion),
    }
    return Result(attrs, samples, events, case=case)


def _joined(tables: Sequence[Table]) -> dict[str, np.ndarray]:
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def how_it_was_had(motion: TrueMotion) -> str:
    """Origin of a motion, in a sentence."""
    made = motion.made
    return (
        f"restarted from {len(motion.times)} states of a run of {made['digits']} digits, "
        f"{made['digits_right']} of them right at the end"
    )


def restarted(case: Case, motion: TrueMotion) -> Iterator[tuple[Table, Table, float]]:
    """Samples and events from each row up to the next, and the error of the displacements there [m].

    The last piece ends with the run, and is compared with the state at the end.
    """
    scene = case.scene()
    tables = tables_of(scene)
    times = motion.times
    for i, (begin, next_row) in enumerate(zip(times, [*times[1:], None], strict=True)):
        until = scene.t_end if next_row is None else min(next_row + BEYOND, scene.t_end)
        trajectory = open_trajectory(replace(scene, t_end=until), resume=motion.row(i))
        blocks = list(trajectory.blocks())
        samples, events = (
            {name: np.concatenate([getattr(block, which)[name] for block in blocks]) for name in names}
            for which, names in (("samples", tables.samples), ("events", tables.events))
        )
        first = {name: [value] for name, value in motion.row(i).items()}
        inside = (events["t"] > begin) & (events["kind"] != EVENT_KINDS["start"])
        last = {name: float(samples[name][-1]) for name in tables.displacements}
        target = {name: float(motion.end[name]) for name in tables.displacements}
        if next_row is not None:
            reached = int(np.argmin(np.abs(events["t"] - next_row)))
            last = {name: float(events[name][reached]) for name in tables.displacements}
            target = {name: motion.row(i + 1)[name] for name in tables.displacements}
            inside &= events["t"] < next_row - BEYOND
        until = np.inf if next_row is None else next_row
        rows = (samples["time"] < until) & ((samples["time"] >= begin) if i else True)
        yield (
            {name: column[rows] for name, column in samples.items()},
            {
                name: np.concatenate([np.array(first[name], dtype=column.dtype), column[inside]])
                for name, column in events.items()
            },
            max(abs(last[name] - target[name]) for name in target),
        )


def keep(result: Result) -> TrueMotion:
    """Numbers to store of a run with digits."""
    digits, attrs, events = result.digits, result.attrs, result.events
    if digits is None or not result.complete:
        raise ValueError(f"{result.case.name}: no whole run with digits")
    chosen = rows_to_keep(events["t"], events["kind"])
    names = tables_of(result.case.scene()).events
    names_of_state = [name for name in digits if name in tables_of(result.case.scene()).states]
    return TrueMotion(
        result.case.name,
        result.case.sha256,
        {
            "date": attrs["date_created"],
            "error": 0.0,
            **{key: attrs[key] for key in ("digits", "digits_right", "digits_right_from", "number_library")},
        },
        {key: _plain(attrs[key]) for key in KNOWN if key in attrs},
        {name: str(SHOWN.create_decimal(Decimal(str(digits[name][-1])))) for name in names_of_state},
        {name: events[name][chosen].tolist() for name in names},
    )


def error_of(remade: Result, result: Result) -> float:
    """Greatest difference of the displacements of two runs at all samples [m]. ValueError where they have not
    the same events.
    """
    if remade.events["kind"].tolist() != result.events["kind"].tolist():
        raise ValueError(f"{result.case.name}: the motion that is made again has other events")
    displacements = tables_of(result.case.scene()).displacements
    return max(float(np.abs(remade[name] - result[name]).max()) for name in displacements)


def rows_to_keep(times: np.ndarray, kinds: np.ndarray) -> list[int]:
    """The start, then the first contact after every EVERY seconds that is alone at its time."""
    alone = np.zeros(len(times), dtype=bool)
    alone[1:-1] = (np.diff(times)[:-1] > ALONE) & (np.diff(times)[1:] > ALONE)
    fit = np.flatnonzero(alone & (kinds == EVENT_KINDS["contact_begin"]))
    rows = [0]
    for row in fit.tolist():
        if times[row] >= times[rows[-1]] + EVERY:
            rows.append(row)
    return rows


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def write_motion(motion: TrueMotion) -> Path:
    """Write what is kept, a column a line."""
    path = motion_path(motion.case)
    rows = ",\n".join(f'  "{name}": {json.dumps(column)}' for name, column in motion.rows.items())
    facts = {key: getattr(motion, key) for key in ("case", "sha256", "made", "totals", "end")}
    lines = ",\n".join(f' "{key}": {json.dumps(value)}' for key, value in facts.items())
    path.write_text(f'{{\n{lines},\n "rows": {{\n{rows}\n }}\n}}\n', encoding="utf-8")
    return path


def main(names: list[str], folder: Path = Path("results/true-motions")) -> None:
    """Run each case with as many digits as it needs, or take the run that FOLDER has, and keep its motion."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names or CHAOTIC:
        case, path = load_case(name), folder / f"{name}.h5"
        result = open_trajectory_file(path) if path.is_file() else None
        if result is None or not result.complete or result.case.sha256 != case.sha256:
            result = simulate_to_file(case, path, force=True, digits="auto")
        motion = keep(result)
        motion.made["error"] = error = error_of(true_motion(case, motion), result)
        print(f"{name}: {how_it_was_had(motion)}; made again to {error:.1e} m: {write_motion(motion)}")


# The report itself.


@dataclass(frozen=True)
class Report:
    """A written report: its pages, the findings on the claims, and how many runs were simulated."""

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


def measure_paper(
    results: Mapping[str, Result], follow: Callable[[], Mapping[str, Branch]], file: NumbersFile, tell: Tell
) -> Numbers:
    """All sections, measured or taken from the file; raises Interrupted when `tell` returns False.

    follow : gives the branches of `readings.obtain_branches`
    """
    cases = {name: result.case for name, result in results.items()}
    prints = {name: case.sha256 for name, case in cases.items()}
    motors = [cases[name] for name in SEARCHED]
    keys = [prints[name] for name in SEARCHED]

    def told(step: str) -> Advance:
        return lambda done, total: tell(step, done, total)

    file.section("facts", [prints, INERTIAS], lambda: measure_facts(cases))
    files = {name: [prints[name], result.attrs["date_created"]] for name, result in results.items()}
    file.section("runs", files, lambda: measure_runs(results, told("measuring")))
    followed = {name: case.sha256 for name, case in followed_cases().items()}
    file.section("ends", followed, lambda: measure_ends(follow()))
    file.section("long_runs", [prints, LONG], lambda: measure_long_runs(cases, told("following for longer")))
    for name in cases:
        measure = partial(measure_ensemble, cases[name], told(f"perturbing {name}"))
        file.section(f"ensemble {name}", [prints[name], starts()], measure)
    shown = [case for name, case in cases.items() if name not in SHIPPED_READINGS]
    file.section("without_stop", prints, lambda: measure_without_stop(shown, told("taking the stop away")))
    m3e = unbalance(cases)
    by_law = {
        law: [cases[name] for name in names] for law, names in zip(LAWS, (PRINTED, EQUAL_FORCE), strict=True)
    }
    beside = [prints, m3e, FREQUENCIES, DAMPINGS, LAWS, REGIMES_NEARBY_STARTS, FOLLOWED, LONGER]
    file.section("nearby", beside, lambda: measure_nearby(by_law, m3e, told("looking beside")))
    gapped = cases[PRINTED_MOTOR]
    file.section("gaps", [gapped.sha256, GAPS_MM], lambda: measure_gaps(gapped, told("widening the gap")))
    for case in motors:
        changed = case.with_values(at_voltage(case, cases[MOTORS[0]]))
        measure = partial(measure_ensemble, changed, told(f"raising the voltage to {case.name}"))
        file.section(f"voltage {case.name}", [changed.sha256, starts()], measure)
    sought = [keys, made_of()]
    file.section("readings", sought, lambda: search_readings(motors, told("judging readings")))
    file.section("plane", sought, lambda: search_plane(motors, told("searching over J and c")))
    file.section("solvers", [keys, SOLVERS], lambda: measure_solvers(motors, told("trying other solvers")))
    return table_of(file.sections)


def table_of(sections: Mapping[str, Any]) -> Numbers:
    """The sections as the claims read them."""
    ensembles, voltages = (_of_cases(sections, kind) for kind in ("ensemble", "voltage"))
    search = {name: sections[name] for name in ("readings", "plane")}
    names = ("facts", "ends", "runs", "long_runs", "without_stop", "nearby", "gaps", "solvers")
    whole = {name: sections[name] for name in names}
    return {**whole, "ensembles": ensembles, "voltages": voltages, "search": search}


def _of_cases(sections: Mapping[str, Any], kind: str) -> Numbers:
    """The sections "KIND CASE" by case."""
    parted = {name: name.partition(" ") for name in sections}
    return {case: sections[name] for name, (head, _, case) in parted.items() if head == kind}


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


if __name__ == "__main__":
    main(sys.argv[1:])
