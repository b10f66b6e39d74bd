"""The root attributes of a sweep file: what was swept, how, by what, and what came of it."""

import json
from math import fsum, isnan
from typing import Any

from vibsim.engine.choice import engine_name, flow_of
from vibsim.files.provenance import provenance
from vibsim.sweeps.plan.sweep_plan import Plan
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.statistics.columns import DEFINITIONS, DONE, FAILED


def origin(plan: Plan, engine: str) -> dict[str, Any]:
    """Attributes that are known before the first point."""
    case, scene = plan.case, plan.case.scene()
    attrs: dict[str, Any] = {
        **provenance("sweep", case),
        "sweep_settings_json": json.dumps(plan.settings),
        "sweep_sha256": plan.fingerprint,
        "definitions": DEFINITIONS,
        "method": flow_of(scene),
        "engine": engine_name(engine),
    }
    if attrs["method"] == "taylor":
        attrs |= {"taylor_order": scene.order, "taylor_tolerance": float(scene.tol)}
    return attrs


def outcome(table: Table) -> dict[str, Any]:
    """Attributes of what came of the sweep so far; wall_time_s adds up the points."""
    times = table.numbers["wall_time"].ravel().tolist()
    return {
        "complete": int(table.complete),
        "points": table.status.size,
        "points_done": table.count(DONE),
        "points_failed": table.count(FAILED),
        "wall_time_s": fsum(value for value in times if not isnan(value)),
    }
