"""Scenes and their truth for the peers."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from vibsim.cases import load_case
from vibsim.engine.tangent.error_growth import error_growth
from vibsim.engine.truth import open_truth
from vibsim.evidence.peers.solvers import EVERY_KIND
from vibsim.physics.parts import EVENT_KINDS

DIGITS = 30
CODES = [EVENT_KINDS[name] for name in EVERY_KIND]


@dataclass(frozen=True)
class Known:
    """A scene, its instants, the true displacements there (n, 2), the true events (n, 2: t, kind), and the
    factor by which small errors grow until its end.
    """

    scene: object
    times: np.ndarray
    displacements: np.ndarray
    events: np.ndarray
    growth: float


@cache
def known(name, t_end):
    """A shipped case over its first `t_end`, by the engine of any precision."""
    case = load_case(name, {"run.t_end": t_end, "run.every": "50 ms"})
    blocks = list(open_truth(case.exact_scene, DIGITS).blocks())
    columns = {key: np.concatenate([block.samples[key] for block in blocks]) for key in ("time", "x1", "x2")}
    events = np.column_stack(
        [np.concatenate([block.events[key] for block in blocks]) for key in ("t", "kind")]
    )
    events = events[np.isin(events[:, 1], CODES)]
    displacements = np.column_stack([columns["x1"], columns["x2"]])
    scene = case.scene()
    return Known(scene, columns["time"], displacements, events, 10 ** error_growth(scene))


def error(attempt, truth):
    """Largest error of the displacements of an attempt [m]."""
    return float(np.abs(attempt.states[:, [0, 2]] - truth.displacements).max())
