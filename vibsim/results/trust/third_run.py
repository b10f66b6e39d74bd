"""The third run, which is asked once: for the end of what it has to show (see `trust_share`)."""

from collections.abc import Callable
from dataclasses import replace
from math import inf, nextafter

import numpy as np

from vibsim.physics.parts import Scene
from vibsim.results.blocks_ahead import PATIENCE
from vibsim.results.cores import Cores
from vibsim.results.trust.companion import (
    GIVEN_UP,
    OTHER_ORDER,
    PARTS,
    USUAL_ORDER,
    Beside,
    GoOn,
    Piece,
    with_numbers,
)

ORDERS = (22, OTHER_ORDER, USUAL_ORDER)


def third_scene(companion: Scene, scene: Scene) -> Scene:
    """The scene of a third run, whose steps are those of neither a run of `scene` nor its companion.

    Of its data that the companion has on one side of those of `scene`, half lie on the other: where what two
    of them do to the motion cancels in the companion, it adds up here.
    """
    order = next(order for order in ORDERS if order not in (scene.order, companion.order))
    sides = Sides()
    data = {name: with_numbers(getattr(scene, name), getattr(companion, name), sides.of) for name in PARTS}
    return replace(companion, method="taylor", order=order, **data)


class Sides:
    """On which sides the data of a third run lie: + - - + - + + - ..., so that no two sums of them cancel
    because of a period (the sequence of Thue and Morse).
    """

    def __init__(self) -> None:
        self._count = 0

    def of(self, ours: float, theirs: float) -> float:
        """The next double: that of the companion, or as far to the other side of ours."""
        if ours == theirs:
            return ours
        self._count += 1
        if (self._count - 1).bit_count() % 2 == 0:
            return theirs
        return nextafter(ours, inf if theirs < ours else -inf)


class LastSamples(Beside):
    """The `last` of the first `count` samples of a run of `scene`, which ends with them.

    most : events that it may take before it is given up
    """

    dither = 2  # the companion has 1

    def __init__(
        self,
        scene: Scene,
        engine: str,
        count: int,
        last: int,
        most: int,
        tell_news: Callable[[], None] = lambda: None,
        cores: Cores | None = None,
    ):
        super().__init__(scene, engine, tell_news, cores)
        self._first, self._last, self._seen, self._most = count - last, last, 0, most
        self._parts: list[np.ndarray] = []
        self._error: BaseException | None = None

    def told(self, seconds: float) -> np.ndarray | None:
        """Displacements [m], shape (blocks that move, last), NaN where the run has failed, infinite where it
        was given up; None where it goes on for more than so many `seconds`.
        """
        if self.t_reached < inf:
            self._thread.join(seconds)
        if self.t_reached < inf:
            return None
        if self._error:
            raise self._error
        if self.failure == GIVEN_UP:
            return np.full((len(self._names), self._last), inf)
        rest = self._first + self._last - max(self._seen, self._first)
        return np.concatenate([*self._parts, np.full((len(self._names), max(rest, 0)), np.nan)], axis=1)

    def _hand_on(self, piece: Piece) -> None:
        if piece.total > self._most:
            self.failure, self._closed = GIVEN_UP, True
        low, high = self._first - self._seen, self._first + self._last - self._seen
        self._seen += len(piece.events)
        self._parts.append(piece.x[:, max(low, 0) : max(high, 0)].copy())

    def _end(self, error: BaseException | None) -> None:
        self._error = error


class ThirdRun:
    """A third run beside a run of `scene` and its companion, set off when it is asked for the first time.

    tell_news, cores : as of `Beside`
    """

    def __init__(
        self, companion: Scene, scene: Scene, engine: str, tell_news: Callable[[], None], cores: Cores
    ):
        self._companion, self._scene, self._engine = companion, scene, engine
        self._tell_news, self._cores = tell_news, cores
        self._run: LastSamples | None = None

    @property
    def is_awaited(self) -> bool:
        """Whether it was asked and has not ended."""
        return self._run is not None and self._run.t_reached < inf

    @property
    def failure(self) -> str:
        """Why nothing is known of it, in words; empty where something is."""
        return GIVEN_UP if self._run is not None and self._run.failure == GIVEN_UP else ""

    def displacements(self, go_on: GoOn, count: int, last: int, until: float, most: int) -> np.ndarray | None:
        """What `LastSamples` of a run up to `until` [s], of `most` events, tells; None where it goes on when
        `go_on` says no.
        """
        if self._run is None:
            third = replace(third_scene(self._companion, self._scene), t_end=until)
            self._run = LastSamples(third, self._engine, count, last, most, self._tell_news, self._cores)
            self._run.start()
        while (told := self._run.told(PATIENCE if go_on() else 0.0)) is None and go_on():
            pass
        return told

    def close(self) -> None:
        """End it where it is."""
        if self._run:
            self._run.close()
