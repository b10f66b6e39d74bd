"""The Python call that runs a fit, and where its runs are kept."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any

from vibsim.cases.case import Case, CaseLike, by_key, load_case, texts
from vibsim.engine.blocks_ahead import available_cores
from vibsim.fitting.fit_result import FitResult
from vibsim.fitting.measures import FitError, FitInterrupted
from vibsim.fitting.plan import METHODS, FitPlan, Search, origin, read_fit, write_fit
from vibsim.fitting.search import Evaluation, Runs, Watch, measure_all, search
from vibsim.fitting.statements import Candidate, parse_statement, read_free, read_reading
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.store import Store
from vibsim.sweeps.axes import Members, read_members, rotor_angles
from vibsim.sweeps.points import SweepPoint
from vibsim.sweeps.sweep_plan import PlanError
from vibsim.sweeps.sweeping import read_ensemble
from vibsim.sweeps.workers import LocalWorkers


def fit(
    cases: CaseLike | Sequence[CaseLike],
    free: Mapping[str, str] | None = None,
    statements: Iterable[str] = (),
    *,
    readings: Iterable[str] = (),
    leave: Mapping[str, float] | None = None,
    ensemble: int = 8,
    spread: Mapping[str, str] | None = None,
    method: str = "quasi-random",
    candidates: int = 256,
    at_most: int | None = None,
    screen: int = 2,
    confirm: int = 3,
    fresh: int = 24,
    seed: int = 0,
    jobs: int | None = None,
    engine: str = "auto",
    out: str | PathLike[str] | None = None,
    force: bool = False,
) -> FitResult:
    """Search for values under which the runs of one or more cases do what statements say of them.

    Parameters
    ----------
    cases : one case or several, each as of `load_case`; a value that is changed is changed in all of them
    free : key -> range, e.g. {"J": "0.5:20 g m^2", "c": "log 0.001:0.05"}; none: only the readings are judged
    statements : one or several, such as "captured until the end" or "II-C: settles between 6.1 and 6.3 Hz",
        see docs/fit.md
    readings : changes to judge beside what is found, e.g. "J=0.006 kg m^2, c=0.005 N s/m"
    leave : key -> price of leaving the printed value by a factor of 10; 0.1 by default
    ensemble : starts that are drawn, besides each case's own; 0: none
    spread : key -> what varies over them, as of `vibsim.sweep`; with a motor by default the rotor angle
    method : "quasi-random" or "evolution"
    candidates : how many are tried
    at_most : parameters changed at a time; by default all together
    screen : starts that quasi-random candidates are judged from first; the best quarter is from all
    confirm, fresh : so many of the best are judged again, from so many starts that the search has not seen
    seed : of the search and of the starts
    jobs : runs computed at a time; by default the available cores. The result is the same bit for bit
    engine : "auto", "c" or "python"
    out : HDF5 file; one that holds a part of this very fit is completed, any other is an error unless `force`

    Raises CaseError, FitError and ResultFileError. A run that fails counts as one that fulfils no statement.

    >>> import vibsim
    >>> free, statement = {"drive.A": "0.05:0.5 N"}, "impacts per cycle between 0.9 and 1.1"
    >>> result = vibsim.fit(
    ...     "gallery/impact-oscillator-coco", free, [statement], candidates=4, confirm=0, ensemble=0, jobs=1
    ... )
    >>> len(result.candidates), result.best.price <= min(each.price for each in result.ranking)
    (5, True)
    """
    listed = [cases] if isinstance(cases, (Case, str, PathLike, Mapping)) else list(cases)
    read = [load_case(case) for case in listed]
    settings = Search(method, candidates, seed, at_most, screen, confirm, fresh)
    free, leave = by_key("free", free, "{'J': '0.5:20 g m^2'}"), by_key("leave", leave, "{'J': 0.05}")
    spread = by_key("spread", spread, "{'x1': '1 mm'}")
    statements, readings = texts("statements", statements), texts("readings", readings)
    for key, text in free.items():
        if not isinstance(text, str):
            raise TypeError(f"free {key}: a range is a text such as '0.5:20 g m^2', got {text!r:.60}")
    plan = make_plan(read, free, statements, readings, leave, ensemble, spread, settings)
    result, _ = run_fit(plan, out, jobs, engine, force)
    return result


def make_plan(
    cases: list[Case],
    free: Mapping[str, str],
    statements: Iterable[str],
    readings: Iterable[str],
    leave: Mapping[str, float],
    ensemble: int,
    spread: Mapping[str, str],
    settings: Search,
) -> FitPlan:
    """The plan of `fit`, everything checked."""
    _check(settings)
    if not cases:
        raise FitError("a fit needs a case")
    prices = dict(leave)
    read = tuple(read_free(cases, key, text, prices.pop(key, None)) for key, text in free.items())
    if prices:
        raise FitError(f"leave {next(iter(prices))}: must name a free parameter: {', '.join(free)}")
    plan = FitPlan(
        tuple(cases),
        read,
        tuple(read_reading(cases, text) for text in readings),
        tuple(parse_statement(text, cases) for text in statements),
        _members(cases, ensemble, settings.seed, spread),
        settings,
    )
    plan.check()
    return plan


def _check(settings: Search) -> None:
    if settings.method not in METHODS:
        raise FitError(f"the method must be {' or '.join(METHODS)}, got {settings.method}")
    least = {"candidates": 0, "seed": 0, "screen": 1, "confirm": 0, "fresh": 0}
    for name, low in least.items():
        if getattr(settings, name) < low:
            raise FitError(f"{name} must be at least {low}, got {getattr(settings, name)}")
    if settings.at_most is not None and settings.at_most < 1:
        raise FitError(f"at least one parameter must be changed at a time, got {settings.at_most}")


def _members(cases: list[Case], ensemble: int, seed: int, spread: Mapping[str, str]) -> Members | None:
    if ensemble < 0:
        raise FitError(f"the number of starts must not be negative, got {ensemble}")
    if not ensemble and not spread:
        return None
    if not spread and not rotor_angles(cases[0]):
        raise FitError(
            'say what varies over the starts, such as spread={"x1": "1 mm"}, or ask for none: ensemble=0'
        )
    try:
        (members,) = read_ensemble(cases[0], ensemble, seed, spread)
        for case in cases[1:]:
            read_members(case, ensemble, seed, spread)
    except (PlanError, ValueError) as error:
        raise FitError(str(error)) from None
    return members


def run_fit(
    plan: FitPlan,
    out: str | PathLike[str] | None = None,
    jobs: int | None = None,
    engine: str = "auto",
    force: bool = False,
    watch: Watch | None = None,
) -> tuple[FitResult, bool]:
    """Run a fit, or complete it; the result, and whether the search reached its end."""
    if jobs is not None and jobs < 1:
        raise FitError(f"jobs must be at least 1, got {jobs}")
    store = FitStore(plan, None if out is None else str(out), engine, force)
    for note in store.notes:
        warnings.warn(note, stacklevel=2)
    with store, LocalWorkers(plan.work, jobs or available_cores(), engine, measure_all) as workers:
        evaluation = Evaluation(plan, store.runs, store.candidates, workers, store.add, watch)
        with suppress(FitInterrupted):
            search(evaluation)
            store.complete = True
    return store.result, store.complete


# The runs of a fit: in memory, and on file as they come, so that none is computed twice.


class FitStore(Store[SweepPoint]):
    """The runs of one fit, by index; `candidates` are those that the search has made."""

    what, record = "fit", SweepPoint
    patient = True

    def make_memory(self) -> None:
        self.runs: Runs = {}
        self.candidates: list[Candidate] = []

    def origin(self) -> dict[str, Any]:
        return origin(self.plan, self.engine)

    def take(self, record: SweepPoint) -> None:
        self.runs[record.index] = record  # type: ignore[index]

    def take_stored(self) -> dict[str, Any]:
        attrs, there, _, points = read_fit(Path(self.shown))
        if attrs["fit_sha256"] != self.plan.fingerprint:
            others = " and ".join(_differences(self.plan, there.cases, attrs["fit_settings_json"]))
            raise ResultFileError(
                f"{self.shown}: holds another fit, of other {others}; kept (force=True replaces it)"
            )
        for point in points:
            self.take(point)
        return attrs

    def write(self, path: Path) -> None:
        write_fit(path, self.result)

    @property
    def result(self) -> FitResult:
        """The fit as far as it is computed."""
        attrs = {**self.attrs, "complete": int(self.complete), "runs": len(self.runs)}
        return FitResult(attrs, self.plan, self.candidates, self.runs)


NAMES = {"free": "free parameters", "starts": "starts", "search": "search settings", "scipy": "scipy",
         "fitting": "version of vibsim"}  # fmt: skip


def _differences(plan: FitPlan, cases: Sequence[Case], stored: str) -> list[str]:
    """Differences between a plan and the fit on file, in words."""
    ours, theirs = json.loads(json.dumps(plan.settings)), json.loads(stored)
    named = [NAMES.get(key, key) for key in ours if ours[key] != theirs.get(key)]
    same_cases = [case.sha256 for case in plan.cases] == [case.sha256 for case in cases]
    return named if same_cases else ["cases", *named]
