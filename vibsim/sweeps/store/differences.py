"""What keeps a file from being continued: how the sweep in it differs from the one that is wanted."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from vibsim.cases import Case
from vibsim.sweeps.plan.members import axis_from_plain
from vibsim.sweeps.plan.sweep_plan import Plan

AT_MOST = 12  # lines; a sweep of another model differs in everything


def differences(plan: Plan, attrs: Mapping[str, Any]) -> list[str]:
    """Lines `what: in the file X, here Y`; empty for the same sweep.

    attrs : root attributes of the file
    """
    if attrs.get("sweep_sha256") == plan.fingerprint:
        return []
    stored = json.loads(attrs["sweep_settings_json"])
    listed = [*_settings(stored, plan.settings), *_cases(attrs["case_resolved_json"], plan, stored["axes"])]
    more = len(listed) - AT_MOST
    return [*listed[:AT_MOST], *([f"and {more} more"] if more > 0 else [])]


def _settings(stored: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[str]:
    axes = [{axis["key"]: axis for axis in side["axes"]} for side in (stored, settings)]
    for key in dict.fromkeys([*axes[1], *axes[0]]):
        yield from _line(key, *(_axis(side.get(key)) for side in axes))
    if set(axes[0]) == set(axes[1]):
        yield from _line("order of the axes", *map(", ".join, axes))
    for name in dict.fromkeys([*settings, *stored]):
        if name != "axes":
            yield from _line(name.replace("_", " "), *(_words(side.get(name)) for side in (stored, settings)))


def _cases(resolved: str, plan: Plan, stored_axes: list[dict[str, Any]]) -> Iterator[str]:
    """Values that no axis of either sweep varies and that are not the same number."""
    theirs, ours = Case.from_resolved_json(resolved), plan.case
    stored = {key for axis in stored_axes for key in axis_from_plain(axis).keys}
    swept = {key for axis in plan.axes for key in axis.keys} | stored | {"name", "title"}
    exact = [_exact_values(case) for case in (theirs, ours)]
    for key in dict.fromkeys([*ours.values, *theirs.values]):
        if key not in swept and exact[0].get(key) != exact[1].get(key):
            yield from _line(key, *(str(case.values.get(key, "absent")) for case in (theirs, ours)))


def _exact_values(case: Case) -> dict[str, Any]:
    return {
        key: (value.value, value.per_turn) if hasattr(value, "per_turn") else value
        for key, value in case.values.items()
    }


def _line(what: str, stored: str, planned: str) -> Iterator[str]:
    if stored != planned:
        yield f"{what}: in the file {stored}, here {planned}"


def _axis(axis: Mapping[str, Any] | None) -> str:
    if axis is None:
        return "not swept"
    if "seed" in axis:
        return str(axis_from_plain(axis))
    read = axis_from_plain(axis)
    values = [read.text(i).removesuffix(read.unit).strip() for i in _few(len(read))]
    text = ", ".join(values if len(read) <= 3 else [*values[:2], f"... {values[2]}"])
    return f"{text} {read.unit}".strip() + f" ({len(read)} values)"


def _few(count: int) -> list[int]:
    return list(range(count)) if count <= 3 else [0, 1, count - 1]


def _words(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, list):
        return " and ".join(map(str, value))
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)
