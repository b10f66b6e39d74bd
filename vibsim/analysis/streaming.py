"""Verdicts on a run while it is computed, for those who keep no trajectory, such as sweeps."""

import numpy as np

from vibsim.analysis.capture import Capture, capture_of_turns
from vibsim.analysis.regime.approached_orbit import decided
from vibsim.analysis.regime.points import Exponent, Judged, judge_points
from vibsim.analysis.regime.section import MOST, Coordinates
from vibsim.analysis.span import Span
from vibsim.engine.trajectories.blocks import Block
from vibsim.physics.parts import Scene
from vibsim.results.motion.closing_velocity import IMPACT_CODES


class StreamedVerdicts:
    """Gathers what the verdicts on capture and regime need from the blocks of a run.

    scene : what is run; begin : the regime is judged from then on [s], capture on everything taken

    The blocks carry the stroboscopic section. Memory grows with the cycles and impacts, not with the samples.
    """

    def __init__(self, scene: Scene, begin: float = 0.0):
        self.scene, self.begin = scene, begin
        self._points: list[dict[str, np.ndarray]] = []
        self._impacts: list[np.ndarray] = []
        self._coordinates = Coordinates(scene)
        self._low, self._high = np.inf, -np.inf  # of each coordinate
        self._span = (np.inf, 0.0)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._points.append(dict(block.section))
        begun = np.isin(block.events["kind"], IMPACT_CODES)
        self._impacts.append(block.events["t"][begun])
        later = block.samples["time"] >= self.begin
        values = self._coordinates.of(block.samples)[:, later]
        self._low = np.minimum(self._low, values.min(axis=1, initial=np.inf))
        self._high = np.maximum(self._high, values.max(axis=1, initial=-np.inf))
        first = min([self._span[0], *block.events["t"][:1].tolist(), *block.samples["time"][:1].tolist()])
        self._span = first, block.t_reached

    def capture(self) -> Capture | None:
        """The verdict on a motor; None for another source."""
        if not self.scene.has_motor:
            return None
        return capture_of_turns(
            self._section()["time"], np.concatenate([[], *self._impacts]), self.scene, Span(*self._span)
        )

    def regime(self, exponent: Exponent | None = None) -> Judged:
        """The verdict on the stroboscopic section from `begin` on."""
        section = self._section()
        rows = np.flatnonzero(section["time"] >= self.begin)[-MOST:]
        if not len(rows):
            return Judged("undecided", "no cycle of a source")
        states = {name: column[rows] for name, column in section.items()}
        sizes = self._coordinates.sizes(np.asarray(self._low), np.asarray(self._high))
        judged = judge_points(self._coordinates.points(states, sizes), exponent)
        return decided(judged, self.scene, states, self._coordinates, sizes)

    def _section(self) -> dict[str, np.ndarray]:
        """The stroboscopic points so far: time and states by name, each (n)."""
        if not self._points:
            return {"time": np.empty(0)}
        return {name: np.concatenate([part[name] for part in self._points]) for name in self._points[0]}
