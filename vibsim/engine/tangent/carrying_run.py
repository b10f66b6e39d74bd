"""A run on the C engine that goes from one start after another, and carries disturbances as they are."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from vibsim.engine.c_engine import REASONS, UNDECIDED, CRun, touch_alike
from vibsim.engine.errors import State
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.engine.tangent.packing_tangent import bundle_form, bundle_numbers
from vibsim.engine.tangent.tangent_space import plainly_weighed_alike
from vibsim.physics.parts import Scene

OF_OUTCOME = 5  # numbers that an outcome tells before the state


class Outcome(NamedTuple):
    """End of a motion that carries disturbances.

    told : doubts, margin, number of the mode, events without a derivative, when the first was
    state : t, x and v of each body, phase, turns, w
    rates : of change of the components; empty where no disturbances were carried
    vectors : disturbances (count, components)

    All are arrays of doubles, or of objects where the run is on other numbers.
    """

    told: list[Any]
    state: np.ndarray
    rates: np.ndarray
    vectors: np.ndarray


class CarryingRun(CRun):
    """A run of a scene made of parts, each motion of which begins with `restart`."""

    def __init__(self, scene: Scene[Any], form: NumberForm[Any] = DOUBLES) -> None:
        self._forms: dict[int, bytes] = {}  # of disturbances, by how many there are
        self._measures: bytes | None = None  # of the scene: what they are measured by
        super().__init__(scene, carries=True, form=form)

    def retune(self, scene: Scene, doubles: bytes, table: ModeTable) -> None:
        """As of any run, and with what disturbances are measured by."""
        alike = touch_alike(self.scene, scene) and plainly_weighed_alike(self.scene, scene)
        self._measures = self._measures if alike else None
        super().retune(scene, doubles, table)

    def restart(self, state: State[Any], end: Any, vectors: Any) -> None:
        """Begin anew from `state` at t = 0 and run to `end` [s], with disturbances to be carried as they are:
        one per row, an array where they are doubles.
        """
        self.described.clear()
        self.run.rewind(end)
        self.moving = len(vectors) > 0
        if self.moving:
            count = len(vectors)
            if count not in self._forms:
                self._forms[count] = bundle_form(self.scene, True, count, self.maker.ends)
            if self._measures is None:
                self._measures = bundle_numbers(self.scene, 0.0, self.form)
            self.run.keep_tangent(self._forms[count], self._measures + self.form.packed_rows(vectors))
        self._set_off(*self._begun(state))

    def run_out(self) -> tuple[np.ndarray, np.ndarray]:
        """Run to the end: (states, codes) of the events, one row per column, which hold until a restart.
        Raises EngineError.
        """
        self.advanced = self.run.advance()
        *counts, finished, status = self.advanced
        if finished and status != UNDECIDED and status not in REASONS:
            self.advanced = None
            _, _, states, codes, _ = self.arrays
            return states[:, : counts[1]], codes[:, : counts[1]]
        blocks = [(states, codes) for _, _, states, codes, *_ in self.blocks()]
        return (
            np.concatenate([states for states, _ in blocks], axis=1),
            np.concatenate([codes for _, codes in blocks], axis=1),
        )

    @cached_property
    def _room(self) -> np.ndarray:
        """Room for what a motion with all disturbances comes to."""
        return self._room_for(self.size)

    def _room_for(self, count: int) -> np.ndarray:
        room: np.ndarray = self.form.empty(1, 9 + 2 * self.n + self.size * (1 + count))[0]
        return room

    def outcome(self, count: int) -> Outcome:
        """End of the motion with `count` disturbances."""
        if count > self.size:
            self._room = self._room_for(count)
        numbers = self.form.all_taken(self._room[: self.run.outcome(self._room)])
        told, state = OF_OUTCOME, 9 + 2 * self.n
        rates = state + self.size
        return Outcome(
            numbers[:told].tolist(),
            numbers[told:state],
            numbers[state:rates],
            numbers[rates:].reshape(-1, self.size),
        )
