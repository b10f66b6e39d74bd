"""vibsim itself as a contestant: its own engines, asked for the same states as its peers."""

from dataclasses import replace

import numpy as np

from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.attempt import EVERY_KIND, Attempt
from vibsim.evidence.peers.time_limit import OutOfTime, TimeLimit
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.two_blocks import TwoBlocks

STATES = ("x1", "v1", "x2", "v2", "phi", "phidot")
COUNTED = [EVENT_KINDS[name] for name in EVERY_KIND]


class OwnEngine:
    """A scene for the engine "c" or "python" by `method`; order and tolerance of a Taylor series."""

    def __init__(self, scene: TwoBlocks, engine: str, method: str, order: int = 20, tol: float = 2.0**-53):
        self.scene, self.engine = replace(scene, method=method, order=order, tol=tol), engine

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at `times` [s], which are the instants that the scene is sampled at. Raises EngineError."""
        trajectory = open_trajectory(self.scene.as_parts(), self.engine)
        blocks, stopped = [], False
        try:
            for block in trajectory.blocks():
                blocks.append(block)
                limit.check()
        except OutOfTime:
            stopped = True
        names = [name for name in STATES if name in blocks[0].samples]
        samples = np.concatenate([np.column_stack([b.samples[name] for name in names]) for b in blocks])
        if not self.scene.has_block2:
            samples = np.insert(samples, 2, np.zeros((2, 1)), axis=1)
        t, kinds = (np.concatenate([block.events[name] for block in blocks]) for name in ("t", "kind"))
        counted = np.isin(kinds, COUNTED)
        events = list(zip(t[counted].tolist(), kinds[counted].tolist(), strict=True))
        steps = int(trajectory.totals["steps"])
        return Attempt(samples, blocks[-1].t_reached, steps, None, events, EVERY_KIND, stopped)
