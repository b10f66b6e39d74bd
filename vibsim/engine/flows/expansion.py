"""Derivatives of event functions at a state, from the Taylor coefficients of the motion there.

C computes them, by the recurrences of every run, in any mode and in any of its number types; and bounds of
their rounding, by which alone signs may be told.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic

from vibsim.engine.errors import State
from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.modes.mode_table import ModeTable, bytes_of
from vibsim.engine.modes.packing import pack_scene, pack_state
from vibsim.engine.modes.rows import HOLD, PUSH, Event, ModeRows
from vibsim.engine.modes.status import Status
from vibsim.lazy import once
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine._engine import Run
    from vibsim.engine.number_forms import NumberForm

LEAST_JET, MOST_JET = 7, 21  # of bounds of `highest_derivative`
MOST_BYTES = 1 << 23  # of packed modes that are told of before all are forgotten


def highest_derivative(scene: Scene[N]) -> int:
    """Order of the highest derivative consulted where lower ones vanish: two for each body that a change
    passes on its way through a chain, and three for where it comes from. Beyond MOST_JET no double tells.
    """
    return min(max(LEAST_JET, 2 * len(scene.bodies) + 3), MOST_JET)


class Expansion(Generic[N]):
    """The motion of a scene about one state at a time, in a mode of `table`, whose numbers it is on.

    It serves one thread. The event functions that are asked for are those of the rows looked at last.

    step : longest step [s] of the series from there
    furthest : order of the highest derivative that may be asked for, about the last that the series of a run
        have. Those beyond `highest_derivative` are seldom asked for; longer series are made then.
    """

    def __init__(self, scene: Scene[N], table: ModeTable, order: int = 0) -> None:
        self.scene, self.table = scene, table
        self.form: NumberForm[N] = table.form
        self.kit: Kit[N] = self.form.kit
        self.order = order or highest_derivative(scene) + 1
        self.furthest = max(self.order, self.kit.order(scene)) - 1
        self._numbers: dict[Status, int] = {}
        self._told = 0  # bytes of the modes that C knows
        self._place: tuple[ModeRows[N], bytes] | None = None  # rows and packed state looked at last

    @once
    def run(self) -> Run:
        """The run in C, which is never started."""
        scene = self.scene
        return self.form.run(*pack_scene(scene, pitches(scene), self.form, self.order))

    @once
    def further(self) -> Expansion[N]:
        """The same by series that have all derivatives up to `furthest`."""
        return Expansion(self.scene, self.table, self.furthest + 1)

    def _that_has(self, count: int) -> Expansion[N]:
        """This, or `further`, whichever has the derivative of order `count` where was looked at last."""
        assert self._place is not None  # else nothing was looked at
        if count < self.order:
            return self
        self.further._look(*self._place)
        return self.further

    def look(self, state: State[N], rows: ModeRows[N]) -> None:
        """Expand the motion at `state` in the mode of `rows`; what was looked at last is not
        expanded anew.
        """
        self._look(rows, pack_state(state, self.form))

    def _look(self, rows: ModeRows[N], packed: bytes) -> None:
        if self._place is None or self._place[0] is not rows or self._place[1] != packed:
            self._place = None
            number = self._number(rows)  # which may begin another run
            self.step: N = self.run.look(number, packed)
            self._place = rows, packed

    def _number(self, rows: ModeRows[N]) -> int:
        """Number of a mode in C; adds it where it is new."""
        number = self._numbers.get(rows.status)
        if number is None:
            if self._told > MOST_BYTES:
                self.__dict__.pop("run")
                self._numbers, self._told = {}, 0
            packed = self.table.packed_without_closed_form(rows)
            number = self._numbers[rows.status] = self.run.add_mode(*packed)
            self._told += bytes_of(packed)
        return number

    def _event(self, event: Event[N]) -> int:
        """Number of an event function of the rows looked at last."""
        assert self._place is not None  # else nothing was looked at
        return next(i for i, one in enumerate(self._place[0].events) if one is event)

    def derivatives(self, event: Event[N], count: int) -> list[N]:
        """Those of order 0 to `count` of an event function, `furthest` at most."""
        return self._that_has(count).run.derivatives(self._event(event), count)

    def bounds(self, event: Event[N], count: int, exact: bool, span: N | int = 0) -> list[N]:
        """Bounds of the rounding of `derivatives`. exact: whether the state is a start, and not what a motion
        led to.

        span : time [s] before the state for which the series are taken to tell how large displacements and
            velocities were, whose rounding it has, however small it is itself; 0 for its own
        """
        assert self._place is not None
        summed = has_rounded_constant(self._place[0], event)
        return self._that_has(count).run.bounds(self._event(event), count, exact, summed, span)

    def forces(self) -> N:
        """Sum of the magnitudes of all forces in the mode [N]."""
        forces: N = self.run.forces()
        return forces

    def formulas(self) -> list[N]:
        """Values of the outputs of the tape of the mode."""
        return self.run.formulas()


def has_rounded_constant(rows: ModeRows[N], event: Event[N]) -> bool:
    """Whether the constant of an event function is a sum, and no number of the scene itself."""
    if event.kind == HOLD:
        return bool(rows.constants) or len(rows.cuts[event.part].ties) > 1
    return event.kind == PUSH
