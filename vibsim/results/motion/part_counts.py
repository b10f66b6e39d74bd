"""How often what happened to each part of a run."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.physics.modes import EVENT_KINDS, IMPACTS
from vibsim.physics.parts import Scene
from vibsim.results.columns import part_names

if TYPE_CHECKING:
    from vibsim.results.result import Result

COUNTED = {
    "impacts": IMPACTS,
    "transmitted": ("transmitted",),
    "chatters": ("chatter",),
    "rests": ("rest_begin",),
    "sticks": ("stick_begin",),
    "reversals": ("reversal",),
    "violations": ("violation_begin",),
}


def part_counts(result: "Result", scene: Scene) -> dict[str, dict[str, int]]:
    """By name of the part: numbers of impacts, sticks, reversals and so on; those that are 0 left out
    but for the impacts of a stop and the sticks of a friction.
    """
    names = part_names(scene)
    kind, part = np.asarray(result.events["kind"]), np.asarray(result.events["part"])
    counts: dict[str, dict[str, int]] = {name: {} for name in names}
    counts |= {stop.name: {"impacts": 0} for stop in scene.stops}
    counts |= {friction.name: {"sticks": 0} for friction in scene.frictions}
    for word, events in COUNTED.items():
        of_kind: Any = part[np.isin(kind, [EVENT_KINDS[event] for event in events]) & (part >= 0)]
        for name, count in zip(names, np.bincount(of_kind, minlength=len(names)).tolist(), strict=True):
            if count:
                counts[name][word] = count
    return {name: counts[name] for name in names}
