"""The Python engine at any precision: the truth that runs in doubles are judged by.

    trajectory = open_truth(case.exact_scene, digits=60)
    for block in trajectory.blocks(): ...

Blocks hold doubles as those of any engine do, each the nearest one to the number computed, and beside them
the numbers' digits. Start values and parameters are the case's exact decimals; samples lie at the very
instants of a run in doubles.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, nan
from typing import Any

import numpy as np

from vibsim.kernel import flow_method
from vibsim.kernel.block import EVENT_STATE, Block, select
from vibsim.kernel.driver import Driver
from vibsim.kernel.errors import KernelError
from vibsim.kernel.python_engine import FLOWS, SECONDS, PythonTrajectory
from vibsim.kernel.totals import totals_of
from vibsim.physics.exact_decimals import text_width
from vibsim.physics.number_kits import number_kit
from vibsim.physics.scene import Scene
from vibsim.physics.state import State

SAMPLES, EVENTS, PIECES = 512, 256, 8  # a stretch of 60 digits takes some ten milliseconds


@dataclass(frozen=True)
class TruthBlock(Block):
    """A block and its digits: ASCII texts of sampled states, and of the times and states of the events."""

    sample_digits: dict[str, np.ndarray]
    event_digits: dict[str, np.ndarray]


class TruthTrajectory(PythonTrajectory):
    """A run on the numbers of `kit`; see `open_truth`."""

    kit: Any

    def __init__(self, scene: Scene, kit: Any, method: str):
        self.scene, self.kit, self.method = scene, kit, method
        self.flow = FLOWS[method](scene, kit)
        self.driver = Driver(scene, kit, self.flow)

    @property
    def order(self) -> int | None:
        """Order of the Taylor flow; None in closed form."""
        return self.kit.order() if self.method == "taylor" else None

    def blocks(self):
        """Yield `TruthBlock`s until the run ends; raises KernelError when it fails."""
        while True:
            self.kit.activate()
            try:
                self.driver.run(SAMPLES, EVENTS, PIECES, SECONDS)
            except KernelError as error:
                values = self.kit.rounded(vars(error.state).values())
                raise KernelError(error.reason, State(*values)) from error
            yield self._block()
            if self.driver.finished:
                return

    def _block(self):
        samples, events, _ = self.driver.take()
        rows = self._numbers([state for state, _ in samples])
        table = self._numbers([state for _, state, _ in events])
        table["t"], table["phase"] = table["time"], [state.phase for _, state, _ in events]
        doubles, happened = self._doubles(rows), self._doubles(table)
        doubles |= mode_columns([mode for _, mode in samples])
        happened |= mode_columns([mode for _, _, mode in events])
        happened["kind"] = np.array([code for code, _, _ in events], dtype="i1")
        here = select(self.scene, doubles, happened, self._doubles(self._numbers([])), *self._now())
        names = digit_columns(self.scene)
        texts = self._texts(rows, names), self._texts(table, ("t", *names))
        return TruthBlock(**vars(here), sample_digits=texts[0], event_digits=texts[1])

    def _now(self):
        return self.kit.rounded([self.driver.state.t, self.driver.worked_to])

    def _numbers(self, states):
        """Columns of states in the kit's numbers, under their file names."""
        columns = {name: [getattr(state, name) for state in states] for name in ("x1", "v1", "x2", "v2")}
        columns["time"] = [state.t for state in states]
        columns["phi"] = [self.kit.unwind(state.phase, state.turns) for state in states]
        columns["phidot"] = [state.w for state in states]
        return columns

    def _doubles(self, columns):
        return {name: np.array(self.kit.rounded(values), dtype="f8") for name, values in columns.items()}

    def _texts(self, columns, names):
        width = text_width(self.kit.digits)
        return {name: np.array(self.kit.texts(columns[name]), dtype=f"S{width}") for name in names}

    @property
    def totals(self):
        """Counts and margins so far."""
        driver, flow = self.driver, self.flow
        kept = flow.certificate
        margin = inf if kept.margin == inf else self.kit.rounded([kept.margin])[0]
        times = self.kit.rounded([kept.first_doubt, kept.margin_time])
        violated = nan if driver.first_violation is None else self.kit.rounded([driver.first_violation])[0]
        certificate = (kept.uncertified, times[0], margin, times[1])
        return totals_of(driver.counts, (flow.steps, flow.evaluations), certificate, violated)


def digit_columns(scene: Scene) -> tuple[str, ...]:
    """Names of the columns that come with digits: the states that the scene has, in file order."""
    return tuple(name for name in scene.columns() if name in EVENT_STATE)


def mode_columns(modes):
    """Columns of modes, under their file names."""
    columns = {name: [getattr(mode, name) for mode in modes] for name in ("contact", "friction")}
    return {name: np.array(values, dtype="i1") for name, values in columns.items()}


def open_truth(exact_scene: Callable[..., Scene], digits: int) -> TruthTrajectory:
    """A run of `digits` decimal digits, not yet computed.

    Parameters
    ----------
    exact_scene : makes the scene from (number, pi), as `Case.exact_scene` does
    digits : 20 to 1000

    Returns an object as `open_trajectory` does; its blocks are `TruthBlock`s. Raises ValueError for other
    digits, MultiprecisionMissing where neither python-flint nor mpmath is installed.
    """
    kit = number_kit(digits)
    scene = exact_scene(kit.number, kit.pi)
    return TruthTrajectory(replace(scene, t_end=kit.exact(scene.t_end)), kit, flow_method(scene))
