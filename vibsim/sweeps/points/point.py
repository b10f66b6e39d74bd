"""One point of a sweep: computed here, in whatever thread, process or machine it falls to."""

import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import CaseError
from vibsim.engine.columns import state_columns
from vibsim.engine.errors import EngineError
from vibsim.engine.section import has_section
from vibsim.engine.trajectories.blocks import Block
from vibsim.physics.parts import Scene
from vibsim.physics.rates import source_rates
from vibsim.sweeps.computations.registry import COMPUTATIONS, Computation
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.plan.recipe import Recipe, Start
from vibsim.sweeps.plan.sweep_plan import Index
from vibsim.sweeps.statistics.columns import DONE, FAILED
from vibsim.sweeps.statistics.measured_run import GivenUpError, MeasuredRun
from vibsim.sweeps.statistics.point_statistics import Statistics
from vibsim.sweeps.statistics.resolution import TooFineError, sampled_for_statistics

Measured = tuple[dict[str, float], dict[str, np.ndarray]]

NOTHING_TO_CARRY = (
    "the run after the transient holds no whole excitation period, so there is no state to carry on from"
)
NO_PERIOD = "forces and base have no common period, so there is no state to carry on from"


@dataclass(frozen=True)
class Point:
    """What came of one point.

    Attributes
    ----------
    index : position on every axis, then of the direction
    status : DONE or FAILED
    sha256 : fingerprint of the point's case, its start included; empty where the case is not allowed
    error : why it failed
    values : statistics, totals and end state by name (see `columns`); what does not apply is missing
    arrays : what has a further dimension, such as the last stroboscopic points, by name
    """

    index: Index
    status: int
    sha256: str
    error: str = ""
    values: dict[str, float] = field(default_factory=dict)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """Whether it was computed and did not fail."""
        return self.status == DONE


def compute_point(
    recipe: Recipe,
    index: Index,
    changes: Mapping[str, str],
    start: Start | None,
    engine: str,
    go_on: Callable[[], bool] | None = None,
) -> Point | None:
    """Run one point and take its statistics.

    Parameters
    ----------
    changes : what the point replaces in the case of the recipe
    start : where a state is carried, the end of the point before
    go_on : asked every few milliseconds; the point is given up (None) when it says False

    A point that cannot be run is returned as FAILED with the reason; it raises nothing for that.
    """
    began = time.perf_counter()
    try:
        case = recipe.point_case(changes, start)
    except CaseError as error:
        return Point(index, FAILED, "", str(error))
    try:
        scene = sampled_for_statistics(case.scene(), recipe.every)
        values, arrays = measure(scene, recipe, engine, go_on)
    except (EngineError, TooFineError) as error:
        return Point(index, FAILED, case.sha256, str(error))
    except GivenUpError:
        return None
    except Exception as error:  # a bug that shows at one point must not cost all the others
        return Point(index, FAILED, case.sha256, described_bug(error))
    if recipe.carry and not any(name.startswith("end_") for name in values):
        return Point(index, FAILED, case.sha256, NOTHING_TO_CARRY if has_section(scene) else NO_PERIOD)
    values["wall_time"] = time.perf_counter() - began
    return Point(index, DONE, case.sha256, "", values, arrays)


def described_bug(error: Exception) -> str:
    """What went wrong and where, in one line."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{Path(frame.filename).name}:{frame.lineno}"
    return f"a bug in vibsim, please report it: {type(error).__name__}: {error} ({place})"


def measure(scene: Scene, recipe: Recipe, engine: str, go_on: Callable[[], bool] | None) -> Measured:
    """Statistics, totals and end state by name; sections and what else has a further dimension by name."""
    begin = recipe.discard.time(scene.t_end)
    kinds = [COMPUTATIONS[name] for name in recipe.compute]
    if not any(kind.samples for kind in kinds):
        scene = scene.without_samples()
    statistics = Statistics(scene, recipe.of, begin)
    computed = [kind.make(Task(scene, recipe.of, begin, recipe.section)) for kind in kinds]
    run = MeasuredRun(
        scene, recipe.of, begin, engine, go_on, any(kind.ledger for kind in kinds), _watchers(computed)
    )
    end: dict[str, float] = {}
    for block in run.blocks():
        statistics.update(block)
        for computation in computed:
            computation.update(block)
        end = _end_state(scene, block) or end
    values = {**statistics.values(run), **run.totals, "t_reached": run.t_reached, **end}
    measured: dict[str, Any] = dict(statistics.section(recipe.section))
    if run.late:
        for computation in computed:
            measured |= computation.values(statistics.window(run), run, measured)
    numbers = {name: value for name, value in measured.items() if isinstance(value, float)}
    arrays = {name: value for name, value in measured.items() if not isinstance(value, float)}
    return {**values, **numbers}, arrays


def _watchers(computed: list[Computation]) -> Callable[[Block], None] | None:
    """Shows blocks of the transient to those computations that take them; None where none does."""
    taking = [computation.transient for computation in computed if hasattr(computation, "transient")]
    if not taking:
        return None

    def show(block: Block) -> None:
        for take in taking:
            take(block)

    return show


def _end_state(scene: Scene, block: Block) -> dict[str, float]:
    """Where a carried sweep goes on, as far as this block tells.

    Forces and the base begin the next point as they began this one, so the last stroboscopic point is the end
    whose motion they continue.
    """
    table = block.section if scene.motor is None and source_rates(scene) else block.events
    states = {name: table[name] for name in state_columns(scene)}
    if scene.has_motor:
        states["phi"] = table["phase"]
    return {f"end_{name}": float(column[-1]) for name, column in states.items() if len(column)}
