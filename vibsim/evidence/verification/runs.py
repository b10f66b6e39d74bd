"""The runs that are verified: through the Python interface, as a user has them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibsim.cases import Case, load_case
from vibsim.cases.loading import load_case_text
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.results import Result, simulate

BOTH = ("closed_form", "taylor")


def run(case: Case, engine: str, flow: str | None = None) -> Result:
    """Run a case, by one flow where it is named."""
    own_case = case if flow is None else case.with_values({"run.method": flow})
    return simulate(own_case, engine=engine, trust=False)


def bare_run(scene: TwoBlocks, engine: str, flow: str) -> Result:
    """Run a scene by one flow, without energy ledger: a million seconds of it take longer than the run."""
    trajectory = open_trajectory(replace(scene.as_parts(), method=flow), engine)
    blocks = list(trajectory.blocks())
    samples, events = (_joined([getattr(block, name) for block in blocks]) for name in ("samples", "events"))
    attrs = {**trajectory.totals, "method": flow, "t_reached_s": float(scene.t_end)}
    return Result(attrs, samples, events)


def _joined(tables: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def made_case(text: str, name: str, **values: Any) -> Case:
    """A case from YAML text; values as excitation__A=0.1, where a float stands for all its digits."""
    return load_case_text(text, overrides(values), name)


def named_case(name: str, **values: Any) -> Case:
    """A shipped case, changed likewise."""
    return load_case(name, overrides(values))


def overrides(values: Mapping[str, Any]) -> dict[str, object]:
    """Dotted keys for those of a call."""
    return {key.replace("__", "."): value for key, value in values.items()}


def flows_of(case: Case) -> tuple[str, ...]:
    """The flows that a case can be run by."""
    return ("taylor",) if case.two_blocks().has_motor else BOTH
