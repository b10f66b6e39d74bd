"""vibsim itself as a contestant: its own engines, asked for the same states as its peers."""

from dataclasses import replace

import numpy as np

from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.attempt import Attempt, kinds_of
from vibsim.evidence.peers.time_limit import OutOfTime, TimeLimit
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene
from vibsim.results.columns import tables_of


class OwnEngine:
    """A scene for the engine "c" or "python" by `method`; order and tolerance of a Taylor series."""

    def __init__(self, scene: Scene, engine: str, method: str, order: int = 20, tol: float = 2.0**-53):
        self.scene, self.engine = replace(scene, method=method, order=order, tol=tol), engine

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at `times` [s], which are the instants that the scene is sampled at. Raises EngineError."""
        trajectory = open_trajectory(self.scene, self.engine)
        blocks, stopped = [], False
        try:
            for block in trajectory.blocks():
                blocks.append(block)
                limit.check()
        except OutOfTime:
            stopped = True
        names, compared = tables_of(self.scene).states, kinds_of(self.scene)
        samples = np.concatenate([np.column_stack([b.samples[name] for name in names]) for b in blocks])
        t, kinds = (np.concatenate([block.events[name] for block in blocks]) for name in ("t", "kind"))
        counted = np.isin(kinds, [EVENT_KINDS[name] for name in compared])
        events = list(zip(t[counted].tolist(), kinds[counted].tolist(), strict=True))
        steps = int(trajectory.totals["steps"])
        return Attempt(samples, blocks[-1].t_reached, steps, None, events, compared, stopped)
