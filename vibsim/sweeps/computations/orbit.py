"""The periodic orbit that a point's run goes to, with its Floquet multipliers."""

from typing import Any

import numpy as np

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.physics.parts import Scene
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

TITLE = "stable periodic orbit that the run goes to, and its multipliers"


def columns(of: Quantities) -> Columns:
    """Period, multipliers and the largest exponent; none without a source."""
    if not of.has_source:
        return {}
    none = "NaN where the run goes to none"
    return {
        "orbit_periods": Column("1", f"excitation periods of the periodic orbit; {none}"),
        "orbit_exponent": Column("s-1", f"largest exponent of the orbit; {none}"),
        "multiplier_real": Column("1", "real part of its Floquet multipliers", dimension="multiplier"),
        "multiplier_imaginary": Column("1", "imaginary part of them", dimension="multiplier"),
    }


def multipliers(scene: Scene) -> int:
    """How many multipliers the orbits of a scene have; 0 without a section."""
    from vibsim.orbits.errors import OrbitError
    from vibsim.orbits.returns.coordinates import unknown_count
    from vibsim.orbits.returns.section import section_of

    try:
        return 0 if section_of(scene).turning else unknown_count(scene)
    except OrbitError:
        return 0


class Orbit:
    """Orbit of one run, by the same verdict as its regime."""

    def __init__(self, task: Task):
        from vibsim.analysis.streaming import StreamedVerdicts

        self._scene = task.scene
        self._verdicts = StreamedVerdicts(task.scene, task.begin)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._verdicts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """Period, largest exponent and multipliers; NaN where there is no orbit that the run goes to."""
        judged = self._verdicts.regime()
        count = multipliers(self._scene)
        if judged.multipliers is None or judged.exponents is None or judged.period is None:
            return {name: np.full(count, np.nan) for name in ("multiplier_real", "multiplier_imaginary")}
        real, imaginary = np.array(judged.multipliers).reshape(-1, 2).T
        largest = judged.exponents[0] if judged.exponents else None
        return {
            "orbit_periods": float(judged.period),
            "orbit_exponent": -np.inf if largest is None else largest,
            "multiplier_real": real,
            "multiplier_imaginary": imaginary,
        }
