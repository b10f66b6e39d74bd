"""End of a motion from a start to a time, with disturbances of that start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import nan
from typing import Any

import numpy as np

from vibsim.engine.errors import State
from vibsim.lazy import once
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import EVENT_NAMES, Scene


@dataclass(eq=False)
class Carried:
    """A motion from a start to a time, and disturbances of its start. Not frozen: there are several in each
    point of a branch, and they would take five times as long to make.

    state : components at the end [m, m/s, rad, rad/s]; rate_there : their rates of change there, or what
        tells them
    vectors : the disturbances at the end, one per row
    happened : kind and number of the part among its sort of what happened on the way, -1 for none, and the
        states of the parts behind it (`Status.codes`), one row each
    table : when [s], and the components behind it, one row each
    uncertified : number of doubts of the certificate; 0 where it is sure that no event was missed
    margin : smallest gap at a turn without contact [m], inf without any
    undefined_at : time [s] of the first event that has no derivative, a grazing touch of a rigid stop say,
        or from which the derivative of a formula is infinite and has no integral; NaN where all have one.
        `vectors` are NaN then
    """

    state: np.ndarray
    rate_there: np.ndarray | Callable[[], np.ndarray]
    vectors: np.ndarray
    happened: np.ndarray
    table: np.ndarray
    uncertified: int
    margin: float
    undefined_at: float = nan

    def __reduce__(self) -> tuple[object, ...]:
        """For pickle: with the rates, which need no run then."""
        counted = self.uncertified, self.margin, self.undefined_at
        return Carried, (self.state, self.rate, self.vectors, self.happened, self.table, *counted)

    @once
    def rate(self) -> np.ndarray:
        """Rates of change of the components at the end."""
        return self.rate_there() if callable(self.rate_there) else self.rate_there

    @once
    def events(self) -> tuple[tuple[str, int], ...]:
        """(kind, part) of what happened on the way, in order."""
        return _named(self.happened[:, :2].tobytes())

    @property
    def times(self) -> np.ndarray:
        """When these happened [s]."""
        return self.table[:, 0]

    @property
    def states(self) -> np.ndarray:
        """The components behind them, one row each."""
        return self.table[:, 1:]

    @property
    def codes(self) -> np.ndarray:
        """The states of the parts behind them (`Status.codes`), one row each."""
        return self.happened[:, 2:]

    @property
    def matrix(self) -> np.ndarray:
        """Column j: what became of disturbance j. The monodromy matrix where these were the unit ones."""
        return np.transpose(self.vectors)


@lru_cache(maxsize=1024)
def _named(happened: bytes) -> tuple[tuple[str, int], ...]:
    """(kind, part) of events by two signed bytes each: branches meet few orders of them."""
    numbers = np.frombuffer(happened, dtype="i1").reshape(-1, 2)
    return tuple((EVENT_NAMES[kind], part) for kind, part in numbers.tolist())


# Components of a state: x of each body, v of each body, phi and w with a motor.


def state_of(scene: Scene[N], kit: Kit[N], t: N, components: list[N]) -> State[N]:
    """The state of components at the time t [s]."""
    n, zero = len(scene.bodies), kit.number(0)
    x, v, rotor = components[:n], components[n : 2 * n], components[2 * n :]
    phase, turns = kit.reduce_angle(rotor[0]) if rotor else (zero, zero)
    return State(t, x, v, phase, turns, rotor[1] if rotor else zero)


def free_scene(scene: Scene[N]) -> Scene[N]:
    """The scene without samples and what only its own start and end have a say in."""
    return scene.but(
        stops=scene.stops and _not_at_start(scene.stops),
        clearances=scene.clearances and _not_at_start(scene.clearances),
        stop_on_violation=False,
        every_num=10**9,
        every_den=1,
    )


def _not_at_start(parts: Any) -> Any:
    """Stops or clearances that no start is exactly at; the same object where none is."""
    if not any(part.at_start for part in parts):
        return parts
    return tuple(replace(part, at_start=False) if part.at_start else part for part in parts)
