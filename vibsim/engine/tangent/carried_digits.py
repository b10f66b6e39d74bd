"""End of a motion from a start to a time in many digits, with disturbances of that start: in C on numbers of
words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic

from vibsim.engine.errors import State, start_of
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.tangent.carried import components_of, free_scene, started
from vibsim.engine.tangent.carrying_run import CarryingRun
from vibsim.physics.numbers import N
from vibsim.physics.parts import EVENT_NAMES, Scene
from vibsim.physics.precision import DigitsKit


@dataclass
class CarriedDigits(Generic[N]):
    """A motion from a start to a time, and disturbances of its start, as `Carried`, on numbers of a kit.

    state, rate : components at the end, and their rates of change there
    vectors : the disturbances at the end, one per row; of no use where `undefined` events on the way have no
        derivative
    events : (kind, part) of what happened on the way, in order
    """

    state: list[N]
    rate: list[N]
    vectors: list[list[N]]
    events: tuple[tuple[str, int], ...]
    undefined: int


class DigitsCarrier(Generic[N]):
    """Carries states of one scene over any times, with disturbances, on the numbers of `kit`, whose precision
    has to be that of the process.

    scene : its start and end do not matter
    """

    def __init__(self, scene: Scene[N], kit: DigitsKit[N]) -> None:
        self.scene, self.kit = free_scene(scene), kit
        self.run = CarryingRun(self.scene, WordsForm(kit))

    def carry(self, components: Sequence[N], end: N, vectors: Sequence[Sequence[N]]) -> CarriedDigits[N]:
        """The motion from `components` at t = 0 to `end` [s] with `vectors`, disturbances of the start, one
        per row. Raises EngineError where the run fails.
        """
        scene, run = started(self.scene, components, end), self.run
        run.restart(start_of(scene, self.kit), scene.t_end, vectors)
        _, codes = run.run_out()
        there, n = run.outcome(len(vectors)), len(scene.bodies)
        t, *values = there.state.tolist()
        state = State(t, values[:n], values[n : 2 * n], *values[2 * n :])
        return CarriedDigits(
            components_of(scene, self.kit, state),
            there.rates.tolist(),
            there.vectors.tolist(),
            _named(codes[0].tolist(), codes[1].tolist()),
            int(float(there.told[-2])),
        )


def _named(kinds: Sequence[int], parts: Sequence[int]) -> tuple[tuple[str, int], ...]:
    """(kind, part) of events, without start and end."""
    return tuple((EVENT_NAMES[kind], part) for kind, part in zip(kinds[1:-1], parts[1:-1], strict=True))
