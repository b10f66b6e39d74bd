"""The derivative of a motion by its start: where small disturbances have moved by a later time.

Unit disturbances of all components make the monodromy matrix M(T) = d state(T) / d state(0), with the
saltation of every event on the way, impacts on rigid stops among them. Components are x of each body, v of
each body, then phi and w with a motor. Where ties hold at the start, disturbances are first made possible:
tied bodies get one velocity, those that rest on each other one displacement. A motion that just grazes a
rigid stop, or strikes several at one instant, has no such derivative: that is told.
"""

from __future__ import annotations

from functools import partial
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vibsim.engine.errors import State
from vibsim.engine.flows.accelerations import accelerations
from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.engine.modes.packing import harmonic_indices, scene_doubles
from vibsim.engine.modes.parametric_rows import Numbers, differences
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.status import Status
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.engine.tangent.carried import Carried, free_scene, state_of
from vibsim.engine.tangent.tangent_space import length
from vibsim.lazy import once
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine.tangent.carrying_run import CarryingRun


class _Shared:
    """A run on the C engine that carriers of several scenes use by turns, and the scene that it is on.

    first : the scene that it begins with
    pitches, harmonic_indices, doubles : of its harmonics, and its numbers
    """

    def __init__(self, first: Scene, form: NumberForm[Any]) -> None:
        self.first, self.form, self.pitches = first, form, pitches(first)
        self.harmonic_indices = harmonic_indices(first, self.pitches)
        self.doubles = scene_doubles(first, self.pitches, form)
        self.on: Scene | None = None

    @once
    def run(self) -> CarryingRun:
        from vibsim.engine.tangent.carrying_run import CarryingRun

        return CarryingRun(self.first, self.form)


class Carrier:
    """Carries states of one scene over any times, with disturbances. What the C engine knows of the scene's
    modes it keeps from one to the next.

    scene : a `vibsim.physics.parts.Scene`, whose start and end do not matter, on the numbers of `form`
    """

    def __init__(self, scene: Scene[Any], form: NumberForm[Any] = DOUBLES) -> None:
        self.scene, self._origin, self.kit = free_scene(scene), scene, form.kit
        self.size, self._shared, self._zero = length(scene), _Shared(self.scene, form), form.kit.number(0)
        self._doubles = self._shared.doubles
        self._numbers: Numbers = {}
        n = len(scene.bodies)
        rotor = (2 * n + 1, 2 * n + 2) if scene.motor is not None else ()
        # of the rows of a state in C: the time and then the components
        self._order = np.array([0, *range(1, 2 * n, 2), *range(2, 2 * n + 1, 2), *rotor])

    def __reduce__(self) -> tuple[object, ...]:
        """For pickle: what the engine knows of modes is made anew."""
        return Carrier, (self._origin,)

    def carry(self, state: ArrayLike, end: float, vectors: ArrayLike | None = None) -> Carried:
        """The motion from `state`, the components at t = 0, to `end` [s], as `Carried`.

        vectors: disturbances of the start, one per row; all unit ones where they are left out. Raises
        ValueError for components that are not as many as the scene has or not finite, or an end that is not
        after the start, EngineError where the run fails.
        """
        vectors = np.eye(self.size) if vectors is None else np.asarray(vectors, dtype="f8")
        vectors = vectors.reshape(-1, self.size) if vectors.size == 0 else vectors
        state = np.asarray(state, dtype="f8")
        if state.shape != (self.size,) or not _finite(state):
            raise ValueError(f"a state of this scene is {self.size} finite numbers")
        if vectors.ndim != 2 or vectors.shape[1] != self.size or not _finite(vectors):
            raise ValueError(f"a disturbance of this scene is {self.size} finite numbers")
        if not (isfinite(end) and end > 0):
            raise ValueError(f"the end must be after the start, got {end} s")
        return self.carried(state.tolist(), float(end), vectors)

    def carried(self, components: list[Any], end: Any, vectors: Any) -> Carried:
        """As `carry`, for those who know their arguments: finite numbers, a time after the start and one
        finite disturbance per row; of doubles a list, a double and an array. Other numbers come back as
        objects, and their precision has to be that of the thread; of events then only what happened is told.
        """
        run = self._tuned()
        run.restart(state_of(self.scene, self.kit, self._zero, components), end, vectors)
        states, codes = run.run_out()
        there = run.outcome(len(vectors))
        uncertified, margin, mode, undefined, undefined_time = self.kit.rounded(there.told)
        rates: Any = there.rates
        if not len(vectors):  # told when they are asked for
            rates = partial(self._rate_of, there.state, run.table.maker, run.statuses[int(mode)])
        return Carried(
            self._ends(there.state),
            rates,
            np.full_like(there.vectors, nan) if undefined else there.vectors,
            codes[:, 1:-1].T.copy(),  # without start and end
            states[:, 1:-1].T[:, self._order],
            int(uncertified),
            margin,
            undefined_time if undefined else nan,
        )

    def _ends(self, numbers: np.ndarray) -> np.ndarray:
        """The components of a state: t, x and v of each body, phase, turns, w."""
        components = numbers[1:-3]
        if self.scene.motor is None:
            return components
        phase, turns, w = numbers[-3:].tolist()
        return np.array([*components.tolist(), self.kit.unwind(phase, turns), w])

    def _rate_of(self, numbers: np.ndarray, maker: RowMaker[Any], status: Status) -> np.ndarray:
        """Rates of change of the components of such a state in a mode, whose rows know of no frequency."""
        n, (t, *values) = len(self.scene.bodies), numbers.tolist()
        state = State(t, values[:n], values[n : 2 * n], *values[2 * n :])
        a, alpha = accelerations(self.scene, self.kit, maker.rows(status), state)
        return np.array([*state.v, *a[:n], *((state.w, alpha) if self.scene.motor is not None else ())])

    def _tuned(self) -> CarryingRun:
        """The run on the C engine, on the numbers of this scene."""
        shared = self._shared
        if shared.on is not self.scene:
            shared.run.retune(self.scene, self._doubles, self._table)
        shared.on = self.scene
        return shared.run

    @once
    def _table(self) -> ModeTable:
        return self._shared.run.origin.retuned(self.scene, self._numbers)

    def of(self, scene: Scene) -> Carrier | None:
        """A carrier of another scene on the same run of the C engine, by turns; None where the modes of the
        two have not the same form.
        """
        shared = self._shared
        free, first, sounds = free_scene(scene), shared.first, shared.pitches
        numbers = differences(first, free)
        if numbers is None:
            return None
        if scene.forces is not first.forces or scene.base is not first.base:
            sounds = pitches(scene)
            if harmonic_indices(scene, sounds) != shared.harmonic_indices:
                return None
        other = object.__new__(Carrier)
        other.size, other._shared, other._order, other._zero = self.size, shared, self._order, self._zero
        other.scene, other._origin, other.kit, other._numbers = free, scene, self.kit, numbers
        other._doubles = scene_doubles(free, sounds)
        return other


def _finite(values: np.ndarray) -> bool:
    """Whether all values are finite: their sum says it at once, but for an overflow."""
    return isfinite(values.sum()) or bool(np.isfinite(values).all())
