"""Where a trajectory comes from and what came of it: the root attributes of a file.

What is not known is left out; an attribute is never a made-up number.
"""

import math
from typing import TYPE_CHECKING, Any

from vibsim.files.provenance import provenance

if TYPE_CHECKING:
    from vibsim.cases import Case

LEDGER = (
    "energy_start",
    "energy_end",
    "work_source",
    "work_base",
    "work_belt",
    "loss_viscous",
    "loss_friction",
    "loss_stops",
    "energy_residual",
    "energy_residual_relative",
)
RIGID_TOTALS = ("transmitted", "chatters", "rests", "chatter_time", "chatter_speed", "chatter_distance")
TOTALS = (
    "impacts",
    "sticks",
    "reversals",
    "events",
    "steps",
    "evaluations",
    "uncertified",
    "first_uncertified_time",
    "grazing_margin",
    "grazing_time",
    "violations",
    "first_violation_time",
    *RIGID_TOTALS,
    *LEDGER,
)
OF_A_PART = "."  # in the name of a total: loss.stops.anvil


def origin(case: "Case", scene: Any, engine: str, method: str) -> dict[str, Any]:
    """Attributes known before the first step: format, case, method, versions, platform."""
    attrs: dict[str, Any] = {
        **provenance("trajectory", case),
        "method": method,
        "engine": engine,
        "t_end_s": float(scene.t_end),
        "complete": 0,
    }
    if method != "closed_form":
        attrs |= {"taylor_order": scene.order, "taylor_tolerance": float(scene.tol)}
    return attrs


def outcome(
    totals: dict[str, Any],
    t_reached: float,
    distances: dict[str, Any],
    wall_time: float,
    complete: bool,
) -> dict[str, Any]:
    """Attributes known at the end of a run; `certified` is 1 where every event is proved.

    Times in s, `grazing_margin` and the `distances` needed in m.
    """
    certified = {"certified": int(totals["uncertified"] == 0)} if "uncertified" in totals else {}
    names = [name for name in totals if name in TOTALS or OF_A_PART in name]
    known = {name: totals[name] for name in names if math.isfinite(totals[name])}
    if not complete and not _ledger_has_begun(known):
        known = {name: value for name, value in known.items() if not _of_ledger(name)}
    return {
        **known,
        **certified,
        **distances,
        "t_reached_s": t_reached,
        "wall_time_s": wall_time,
        "complete": int(complete),
    }


def _of_ledger(name: str) -> bool:
    return name in LEDGER or name.startswith(("work.", "loss."))


def _ledger_has_begun(known: dict[str, Any]) -> bool:
    """Whether the energy ledger has a stretch of motion: it gets one when all of it is done, and before the
    first its residual is zero without meaning anything.
    """
    entries = [name for name in known if name.startswith(("work", "loss"))]
    return any(known.get(name) for name in entries) or known.get("energy_end") != known.get("energy_start")
