"""Runs of many digits of scenes made of parts: the Python engine on python-flint's or mpmath's numbers.

    trajectory = open_truth(case.exact_scene, 40)
    for block in trajectory.blocks(): ...

Sampled states and events come twice: as doubles, like those of any run, and as decimal texts of all digits.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from vibsim.engine.blocks import Block
from vibsim.engine.columns import stored_columns
from vibsim.engine.errors import EngineError, State
from vibsim.engine.python_trajectory import PythonTrajectory
from vibsim.physics.numbers import Number, text_width
from vibsim.physics.parts import Scene
from vibsim.physics.precision import DigitsKit, number_kit, one_precision

SAMPLES, PIECES, SECONDS = 512, 8, 0.1  # a stretch of 60 digits takes some ten milliseconds


@dataclass(frozen=True)
class TruthBlock(Block):
    """A block and its digits: ASCII texts of sampled states, and of the times and states of the events."""

    sample_digits: dict[str, np.ndarray]
    event_digits: dict[str, np.ndarray]


class TruthTrajectory(PythonTrajectory[Number]):
    """A run on the numbers of `kit`; see `open_truth`."""

    kit: DigitsKit[Number]

    @property
    def order(self) -> int:
        """Order of the Taylor flow."""
        return self.kit.order()

    def blocks(self) -> Iterator[TruthBlock]:
        """Yield `TruthBlock`s until the run ends; raises EngineError when it fails."""
        finished = False
        while not finished:
            with one_precision:
                block, finished = self._next_block(), self.driver.finished
            yield block

    def _next_block(self) -> TruthBlock:
        self.kit.activate()
        try:
            self.driver.run(PIECES, SAMPLES, SECONDS)
        except EngineError as error:
            raise EngineError(error.reason, self._rounded(error.state)) from error
        samples, events, section, _ = self.driver.take()
        block = self._block(samples, events, section, ())
        names = stored_columns(self.scene)
        at = self._texts(names, [self._row(state)[1:] for state, _ in samples])
        after = self._texts(("t", *names), [self._row(one[2]) for one in events])
        return TruthBlock(**vars(block), sample_digits=at, event_digits=after)

    def _rounded(self, state: State[Number]) -> State:
        values = self.kit.rounded([state.t, *state.x, *state.v, state.phase, state.turns, state.w])
        n = len(state.x)
        return State(values[0], values[1 : n + 1], values[n + 1 : 2 * n + 1], *values[-3:])

    def _texts(self, names: Sequence[str | None], rows: Sequence[Sequence[Number]]) -> dict[str, np.ndarray]:
        width = text_width(self.kit.digits)
        return {
            name: np.array(self.kit.texts([row[i] for row in rows]), dtype=f"S{width}")
            for i, name in enumerate(names)
            if name is not None
        }


def open_truth(
    exact_scene: Callable[..., Scene[Number]], digits: int, ledger: bool = False, momentum: bool = False
) -> TruthTrajectory:
    """A run of `digits` decimal digits, not yet computed.

    Parameters
    ----------
    exact_scene : makes the scene from (number, pi), as `Case.exact_scene` does
    digits : 20 to 1000
    ledger, momentum : as of `open_trajectory`; their quadrature is that of doubles, 16 digits

    Returns an object as `open_trajectory` does; its blocks are `TruthBlock`s, without section. Raises
    ValueError for other digits, MultiprecisionMissing where neither python-flint nor mpmath is installed.
    """
    with one_precision:
        kit = number_kit(digits)
        scene = exact_scene(kit.number, kit.pi)
        return TruthTrajectory(bare(scene, kit), kit, ledger=ledger, momentum=momentum)


def bare(part: Any, kit: DigitsKit[Number]) -> Any:
    """A part, or a scene of them, whose numbers carry no radius; formulas, whose numbers are exact, as they
    are.
    """
    if isinstance(part, tuple) and part and isinstance(part[0], str):
        return part
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{field.name: bare(getattr(part, field.name), kit) for field in fields(part)})
    if isinstance(part, tuple):
        return tuple(bare(one, kit) for one in part)
    if part is None or isinstance(part, str | int | float | Fraction):
        return part
    return kit.exact(part)
