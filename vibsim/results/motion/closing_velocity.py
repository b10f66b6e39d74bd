"""How fast the ends of a stop approach each other where it is struck."""

from collections.abc import Mapping

import numpy as np

from vibsim.physics.modes import EVENT_KINDS, IMPACTS
from vibsim.physics.parts import Scene
from vibsim.results.motion.relative_motion import RelativeMotion

IMPACT_CODES = [EVENT_KINDS[kind] for kind in IMPACTS]


def closing_velocities(scene: Scene, events: Mapping[str, np.ndarray]) -> np.ndarray:
    """Rate of the depth of the stop at each impact [m/s], > 0; NaN for all other events; shape (n).

    events : columns of the table of events by name, each (n). Contact with an elastic stop begins with the
    velocities of its row, an impact at a rigid one turns those before it round.
    """
    kind, values = events["kind"], np.full(len(events["kind"]), np.nan)
    struck, rigid = np.isin(kind, IMPACT_CODES), kind == EVENT_KINDS["impact"]
    for number, stop in enumerate(scene.stops):
        rows, motion = struck & (events["part"] == number), RelativeMotion(scene, stop)
        states = {"t": events["t"][rows]}
        for name in motion.columns:
            before = events.get(f"before_{name}", events[name])
            states[name] = np.where(rigid, before, events[name])[rows]
        values[rows] = -stop.sense * motion(states, "t")[2]
    return values
