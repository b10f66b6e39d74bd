"""The Python call that runs a sweep."""

import warnings
from collections.abc import Iterable, Mapping
from fractions import Fraction
from os import PathLike
from pathlib import Path

from vibsim.analysis.cycles import parse_discard
from vibsim.cases import Case
from vibsim.cases.case import CaseLike, by_key, load_case, texts, whole_number
from vibsim.cases.quantities import parse_quantity
from vibsim.engine.blocks_ahead import available_cores
from vibsim.sweeps.axes import Axis, Members, range_and_unit, read_axis, read_members
from vibsim.sweeps.computations import read_computations
from vibsim.sweeps.quantities import quantities_of
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import PlanError, SweepPlan, probe_starts, read_directions
from vibsim.sweeps.sweep_result import SweepResult
from vibsim.sweeps.workers import ClusterWorkers, LocalWorkers, Watch, Workers, run

# a range as text, values, or values and their unit
AxisValues = str | Iterable[object] | tuple[Iterable[object], str]


def sweep(
    case: CaseLike,
    axes: Mapping[str, AxisValues] | None = None,
    *,
    direction: str | None = None,
    carry_state: bool = False,
    discard: str = "50 %",
    section: int = 100,
    every: str | None = None,
    compute: str | Iterable[str] = (),
    ensemble: int = 0,
    seed: int = 0,
    spread: Mapping[str, str] | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    out: str | PathLike[str] | None = None,
    force: bool = False,
    overrides: Mapping[str, object] | None = None,
) -> SweepResult:
    """Run a case at every point of a grid, in parallel, and take statistics of each run.

    Parameters
    ----------
    case : as of `load_case`: a Case, a file, a shipped name, a dict or YAML text
    axes : key -> range, e.g. {"excitation.Omega0": "3:7:0.05 Hz", "c": "0.01:0.05/9"}, or values, e.g.
        {"c": [0.01, "0.02 N s/m"]}, or values and their unit, e.g. {"Omega0": (np.linspace(3, 7, 81), "Hz")};
        "log 100:1e5/31 N/m" is spaced by ratio; one or more make a grid
    direction : "up", "down" or "both" along the first axis; by default in the order in which its values are
        written: "7:3:1 Hz" runs down, and "4, 3, 5 Hz" in this order
    carry_state : start each point from the end of the one before along the first axis; "both" goes there and
        back
    discard : transient left out of the statistics, a time ("100 s") or a share of t_end ("50 %")
    section : stroboscopic points kept per point, the last ones
    every : interval of the samples that verdicts on the regime are scaled with, such as "1 ms"; by default
        what suits the motion. All else is exact
    compute : names of what is computed besides, see `vibsim.sweeps.computations`, or "all"
    ensemble : members of an ensemble that is run at every point; 0: none
    seed : of the members' draws; member 7 of a seed is the same in an ensemble of any size
    spread : key -> what varies over the ensemble and by how much, e.g. {"x1": "1 mm", "v1": "normal 2 mm/s",
        "phi": "0:360 deg"}; with a motor by default the rotor angle, over the full turn
    jobs : points computed at a time; by default the available cores. The result is the same bit for bit
    scheduler : address of a dask.distributed scheduler whose workers compute the points, instead of this
        machine; the same bits
    out : HDF5 file; one that holds a part of this very sweep is completed, any other is an error unless
        `force`
    overrides : values of the case that are changed, as of `load_case`

    Raises CaseError, UnknownKeyError, RangeError, PlanError, ClusterError and ResultFileError. Points that
    fail are kept with their reason, see `SweepResult["status"]` and `["error"]`.

    >>> import numpy as np, vibsim
    >>> axes = {"Omega0": (np.linspace(5, 6, 3), "Hz")}
    >>> sweep = vibsim.sweep("II-B", axes, section=0, jobs=1, overrides={"run.t_end": "2 s"})
    >>> sweep["omega0"].tolist(), sweep["mean_speed"].shape
    ([5.0, 5.5, 6.0], (3, 1))
    """
    case = load_case(case, overrides)
    axes = by_key("axes", axes, "{'Omega0': '3:7:0.05 Hz'}")
    ensemble, seed = whole_number("ensemble", ensemble, 0), whole_number("seed", seed, 0)
    plan = make_plan(
        case,
        [(key, *range_and_unit(key, values), "axes") for key, values in axes.items()],
        direction,
        carry_state,
        discard,
        whole_number("section", section, 0),
        every,
        texts("compute", compute),
        read_ensemble(case, ensemble, seed, by_key("spread", spread, "{'x1': '1 mm'}")),
    )
    jobs = None if jobs is None else whole_number("jobs", jobs, 1)
    with open_workers(plan, jobs, scheduler) as workers:
        store = SweepStore(plan, None if out is None else Path(out), force)
        for note in store.notes:
            warnings.warn(note, stacklevel=2)
        return complete(store, workers)[0]


def make_plan(
    case: Case,
    axes: Iterable[tuple[str, ...]],
    direction: str | None = None,
    carry_state: bool = False,
    discard: str = "50 %",
    section: int = 100,
    every: str | None = None,
    compute: str | Iterable[str] = (),
    ensemble: tuple[Members, ...] = (),
) -> SweepPlan:
    """The plan of `sweep`, everything checked.

    axes : key, range and, as `read_axis` takes them, the unit of a range without one and the argument
        or option that messages name
    """
    if section < 0:
        raise PlanError(f"the number of stroboscopic points must not be negative, got {section}")
    try:
        every_axis: tuple[Axis | Members, ...] = (*(read_axis(case, *axis) for axis in axes), *ensemble)
        if not every_axis:
            raise PlanError("a sweep needs something to vary")
        computed = read_computations(compute, quantities_of(case))
        return SweepPlan(
            case=case,
            axes=every_axis,
            directions=read_directions(direction, every_axis[0], carry_state),
            carry=carry_state,
            discard=parse_discard(_text("discard", discard, "'100 s' or '50 %'")),
            section=section,
            every=None if every is None else _interval(_text("every", every, "'5 ms'")),
            compute=computed,
            probes=probe_starts(every_axis, computed, carry_state),
        )
    except ValueError as error:
        raise error if isinstance(error, PlanError) else PlanError(str(error)) from None


def _text(name: str, value: object, example: str) -> str:
    """An argument that is read as on the command line. Raises TypeError for a number, which says no unit."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a text with its unit, such as {example}, got {value!r}")
    return value


def read_ensemble(case: Case, count: int, seed: int, spread: Mapping[str, str]) -> tuple[Members, ...]:
    """The members' axis, or none. Raises PlanError, and CaseError where the case does not allow a value."""
    if not count:
        if spread:
            raise PlanError("a spread needs an ensemble: say how many members it has")
        return ()
    for key, how in spread.items():
        _text(f"spread of {key}", how, "'5 mm' or '0:360 deg'")
    try:
        return (read_members(case, count, seed, spread),)
    except ValueError as error:
        raise PlanError(str(error)) from None


def open_workers(plan: SweepPlan, jobs: int | None, scheduler: str | None) -> Workers:
    """Workers here, or those of a scheduler; to be entered. Raises PlanError for wishes that do not fit."""
    if scheduler is not None and jobs is not None:
        raise PlanError("jobs are the workers of this machine; with a scheduler its workers compute")
    if scheduler is not None:
        return ClusterWorkers(plan.point_settings, scheduler)
    if jobs is not None and jobs < 1:
        raise PlanError(f"jobs must be at least 1, got {jobs}")
    return LocalWorkers(plan.point_settings, jobs or available_cores())


def complete(store: SweepStore, workers: Workers, watch: Watch | None = None) -> tuple[SweepResult, bool]:
    """Complete a store; the result, and whether every point was reached."""
    with store:
        finished = run(store, workers, watch)
    return SweepResult(store.all_attrs, store.plan, store.table.column, store.table), finished


def _interval(text: str) -> Fraction:
    every = parse_quantity(text, "time").value
    if every <= 0:
        raise PlanError(f"the output interval must be positive, got {text}")
    return every
