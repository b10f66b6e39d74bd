"""What a sweep file holds, in labelled lines for people and as a dict for programs."""

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

from vibsim.cases.plain_text import one_line
from vibsim.cases.values.quantities import decimal_text
from vibsim.sweeps.plan.axis import Axis
from vibsim.sweeps.plan.members import Members
from vibsim.sweeps.plan.sweep_plan import DIRECTION_NAMES, Plan
from vibsim.sweeps.sweep_result import SweepResult, open_sweep

Lines = list[tuple[str, str]]


def describe(path: str | Path) -> tuple[Lines, dict[str, Any]]:
    """Lines (label, text) and facts of a sweep file. Raises ResultFileError where it holds none."""
    result = open_sweep(path)
    return [*sweep_lines(result), ("written", _written(result.attrs))], facts(result)


def sweep_lines(result: SweepResult) -> Lines:
    """What was swept, how, and what came of it."""
    attrs, plan = result.attrs, result.plan
    name, title = one_line(attrs["case_name"]), one_line(attrs["title"])
    lines = [("case", title if title == name else f"{name}  {title}")]
    lines += [(axis.name, axis_text(axis)) for axis in plan.axes]
    lines.append(("points", points_text(attrs)))
    lines.append(("start", start_text(result)))
    lines.append(("run", f"{_ends(plan)}, transient of {plan.discard} left out of the statistics"))
    if plan.compute:
        lines.append(("computed", ", ".join(plan.compute)))
    lines.append(("section", f"the last {plan.section} stroboscopic points of each"))
    failures = list(result.table.failures())
    lines += [("failed", f"{place_text(result, index)}: {reason}") for index, reason in failures[:5]]
    if len(failures) > 5:
        lines.append(("failed", f"and {len(failures) - 5} more"))
    return lines


def _ends(plan: Plan) -> str:
    """How long the runs are: 300 s, or the values of an axis."""
    for axis in plan.axes:
        if isinstance(axis, Axis) and "run.t_end" in (axis.key, *axis.also):
            return axis_text(axis)
    return str(plan.case.quantity("run.t_end"))


def facts(result: SweepResult) -> dict[str, Any]:
    """The attributes as plain data, the case as an object."""
    attrs = {name: value for name, value in result.attrs.items() if name != "case_yaml"}
    case, settings = json.loads(attrs.pop("case_resolved_json")), json.loads(attrs.pop("sweep_settings_json"))
    failed = [{"at": place_text(result, index), "error": reason} for index, reason in result.table.failures()]
    return {**attrs, "case": case, "sweep": settings, "failed": failed}


def axis_text(axis: Axis | Members) -> str:
    """The values of an axis: 3 to 7 Hz in steps of 0.05, 81 values."""
    if isinstance(axis, Members):
        return str(axis)
    values, count = axis.values, f"{len(axis)} value{'' if len(axis) == 1 else 's'}"
    steps = {after - before for before, after in pairwise(values)}
    if len(values) > 2 and len(steps) == 1:
        span = f"{decimal_text(values[0])} to {decimal_text(values[-1])} {axis.unit}".strip()
        return f"{span} in steps of {decimal_text(abs(steps.pop()))}, {count}"
    if axis.by_ratio:
        return (
            f"{decimal_text(values[0])} to {decimal_text(values[-1])} {axis.unit}".strip()
            + f" by ratio, {count}"
        )
    shown = [decimal_text(value) for value in values]
    listed = shown if len(shown) <= 6 else [*shown[:3], "...", shown[-1]]
    return f"{', '.join(listed)} {axis.unit}".strip() + f", {count}"


def points_text(attrs: dict[str, Any]) -> str:
    """How many were computed, failed and are missing."""
    total, done, failed = attrs["points"], attrs["points_done"], attrs["points_failed"]
    parts = [f"{done} of {total} done"]
    parts += [f"{failed} failed"] if failed else []
    parts += [f"{total - done - failed} missing"] if total > done + failed else []
    return ", ".join(parts)


def start_text(result: SweepResult) -> str:
    """How the points begin."""
    plan = result.plan
    if not plan.carry:
        return "every point from the state of its case"
    axis = plan.axes[0]
    if axis.way:
        way = " and back ".join(DIRECTION_NAMES[code] for code in plan.directions)
    else:
        way = "as listed" + (" and back" if len(plan.directions) > 1 else "")
    return f"every point from the end of the one before, {axis.name} {way}"


def place_text(result: SweepResult, index: tuple[int, ...]) -> str:
    """Where a point is: omega0 = 3.05 Hz, down."""
    places = [f"{axis.name} = {axis.text(i)}" for axis, i in zip(result.axes, index, strict=False)]
    direction = [DIRECTION_NAMES[result.directions[index[-1]]]] if result.plan.carry else []
    return ", ".join([*places, *direction])


def _written(attrs: dict[str, Any]) -> str:
    versions = (
        f"vibsim {attrs['vibsim_version']}, Python {attrs['python_version']}, numpy {attrs['numpy_version']}"
    )
    engine = {"c": "C", "python": "Python"}[attrs["engine"]]
    took = f"{attrs['wall_time_s']:.3g} s of {engine} engine"
    return f"{attrs['date_created']}, {took}; {versions}; {attrs['platform']}"
