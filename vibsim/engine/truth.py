"""Runs of many digits of scenes made of parts: the engine in C on numbers of so many words.

    trajectory = open_truth(case.exact_scene, 40)
    for block in trajectory.blocks(): ...

Sampled states and events come twice: as doubles, like those of any run, and as decimal texts of all digits.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibsim.engine.blocks import Block
from vibsim.engine.columns import stored_columns
from vibsim.engine.errors import EngineError
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.trajectory import Trajectory
from vibsim.physics.numbers import Number
from vibsim.physics.parts import Scene
from vibsim.physics.precision import number_kit


@dataclass(frozen=True)
class TruthBlock(Block):
    """A block and its digits: ASCII texts of sampled states, and of the times and states of the events."""

    sample_digits: dict[str, np.ndarray]
    event_digits: dict[str, np.ndarray]


class WordsTrajectory(Trajectory):
    """A run in C on numbers of words, of which Python decides the events without a clear rule on those of
    `form.kit`; see `open_truth`.
    """

    def __init__(self, scene: Scene[Any], form: WordsForm[Any], ledger: bool, momentum: bool) -> None:
        from vibsim.engine.c_engine import CRun

        with _failing_in_doubles():
            super().__init__(CRun(scene, form=form, ledger=ledger, momentum=momentum))
        self.form, self.kit = form, form.kit

    def blocks(self) -> Iterator[TruthBlock]:
        """Yield `TruthBlock`s until the run ends; raises EngineError when it fails."""
        filled = self.run.blocks()
        while True:
            self.kit.activate()
            with _failing_in_doubles():
                rows = next(filled, None)
            if rows is None:
                return
            yield self._truth_block(*rows)

    def _truth_block(
        self,
        samples: np.ndarray,
        codes: np.ndarray,
        events: np.ndarray,
        event_codes: np.ndarray,
        section: np.ndarray,
        reached: tuple[Number, Number],
    ) -> TruthBlock:
        in_doubles = self.form.doubles
        to, worked_to = self.kit.rounded(reached)
        block = self.columns.block(
            in_doubles(samples), codes, in_doubles(events), event_codes, in_doubles(section), (to, worked_to)
        )
        names = stored_columns(self.scene)
        at = self._texts(names, samples[1:])
        after = self._texts(("t", *names), events)
        return TruthBlock(**vars(block), sample_digits=at, event_digits=after)

    def _texts(self, names: Sequence[str | None], rows: np.ndarray) -> dict[str, np.ndarray]:
        return {
            name: self.form.texts(row) for name, row in zip(names, rows, strict=False) if name is not None
        }

    @property
    def totals(self) -> dict[str, Any]:
        """Counts and margins so far, and the ledgers where they are kept, as doubles."""
        self.kit.activate()
        return super().totals


@contextmanager
def _failing_in_doubles() -> Iterator[None]:
    """Give the state of an EngineError in doubles."""
    try:
        yield
    except EngineError as error:
        raise EngineError(error.reason, error.state.rounded(), error.parts) from error


def open_truth(
    exact_scene: Callable[..., Scene[Number]], digits: int, ledger: bool = False, momentum: bool = False
) -> WordsTrajectory:
    """A run of `digits` decimal digits, not yet computed.

    Parameters
    ----------
    exact_scene : makes the scene from (number, pi), as `Case.exact_scene` does
    digits : 20 to 1000
    ledger, momentum : as of `open_trajectory`; their quadrature is that of doubles, 16 digits

    Returns an object as `open_trajectory` does; its blocks are `TruthBlock`s, without section. Raises
    ValueError for other digits, MultiprecisionMissing where the engine was not built on words.
    """
    kit = number_kit(digits)
    scene = exact_scene(kit.number, kit.pi)
    return WordsTrajectory(scene, WordsForm(kit), ledger=ledger, momentum=momentum)
