"""The companion of a run: the same case integrated a second time, differently, beside the first.

What two runs share, their difference cannot show. So the companion takes other steps, at full
tolerance: those of the other flow where there are two, else of another order (the same flow from other
data alone misses some growth). Sequences of impacts whose hops friction hides it ends at hops four times as
fast: what the run leaves out there is not left out by both. And its data lie on the other side of the true
ones: a decimal such as 0.297 kg is no double, and every number that is none is moved by one unit in the last
place towards its exact value. Without that the phase error of a motor that turns evenly, which comes of the
data, would be missed: after 10,000 s it is 70 times the distance of two runs from equal data.
"""

import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from math import inf, nextafter
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.values.pi import FIRST_BITS, two_pi_bounds
from vibsim.engine.choice import flow_of
from vibsim.engine.events.impacts.chatter import LOWEST
from vibsim.engine.trajectories.blocks import Block, Trajectory
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import Scene
from vibsim.results.blocks_ahead import LONGEST, PATIENCE
from vibsim.results.columns import tables_of
from vibsim.results.cores import Cores

if TYPE_CHECKING:
    from vibsim.cases import Case

PARTS = ("bodies", "links", "stops", "frictions", "forces", "base", "motor")
TURNS = ("cycles", "cycles_lo")
USUAL_ORDER, OTHER_ORDER = 20, 25  # of the Taylor flow; both cost the same
TOLERANCE = 2.0**-53
HIGHER = 16  # hops, at the end of sequences of impacts under friction: four times as fast
BLOCKS_AHEAD = 8  # bounds the memory of a companion that is faster than the run
GoOn = Callable[[], bool]


def companion_scene(case: "Case", scene: Scene) -> Scene:
    """The scene of the companion of a run of `scene`, that of `case`.

    Samples are at the same times. Limits that are only watched are left out: they never change the motion.
    """
    exact = case.exact_scene(Fraction, pi=two_pi_bounds(FIRST_BITS)[0] / 2)
    method, order = _other_flow(scene)
    return replace(
        scene,
        method=method,
        order=order,
        tol=TOLERANCE,
        clearances=(),
        **{name: with_numbers(getattr(scene, name), getattr(exact, name), towards) for name in PARTS},
    )


def _other_flow(scene: Scene) -> tuple[str, int]:
    """Method and order of a companion: the other flow where a run has two, else another order."""
    if scene.has_motor:
        return "taylor", _other_order(scene.order)
    if scene.method == "taylor":
        return flow_of(replace(scene, method="auto")), _other_order(scene.order)
    return "taylor", USUAL_ORDER if flow_of(scene) == "closed_form" else _other_order(scene.order)


def _other_order(order: int) -> int:
    return OTHER_ORDER if order < (USUAL_ORDER + OTHER_ORDER) // 2 else USUAL_ORDER


def described(companion: Scene) -> str:
    """The companion in words, for the file."""
    series = f"Taylor series of order {companion.order}"
    both = f"closed form or {series}"
    stepping = {"taylor": series, "closed_form": "closed form", "auto": both}[companion.method]
    return f"difference from a second run by {stepping}, its data one ulp towards their decimal values"


def with_numbers(value: Any, other: Any, change: Callable[[float, Any], float]) -> Any:
    """A number, part or tuple of these, its numbers changed, each by what stands at its place in `other`.

    The turns of a harmonic stay: they are carried as two doubles, and right to 32 digits.
    """
    if isinstance(value, tuple):
        return tuple(with_numbers(one, another, change) for one, another in zip(value, other, strict=True))
    if is_dataclass(value):
        names = [each.name for each in fields(value) if each.name not in TURNS]
        pairs = {name: (getattr(value, name), getattr(other, name)) for name in names}
        return replace(value, **{name: with_numbers(*pair, change) for name, pair in pairs.items()})  # type: ignore[type-var]
    return change(value, other) if isinstance(value, float) else value


def towards(value: float, exact: Fraction) -> float:
    """A double one ulp towards its exact value; itself where it is exact."""
    error = Fraction(exact) - Fraction(value)
    return nextafter(value, inf if error > 0 else -inf) if error else value


class Beside:
    """A run of `scene` in a thread of its own, of which only the displacements at the samples are used.

    The C engine lets go of the interpreter while it computes: on two cores it costs hardly any time.
    tell_news : called in that thread whenever it has come further; cores : asked for one, block by block
    """

    def __init__(
        self,
        scene: Scene,
        engine: str,
        tell_news: Callable[[], None] = lambda: None,
        cores: Cores | None = None,
    ):
        self._scene, self._engine, self._tell_news = scene, engine, tell_news
        self._cores = cores or Cores(1)
        self._names = tables_of(scene).displacements
        self._closed = False
        self._trajectory: Trajectory[float] | None = None
        self.t_reached = 0.0  # [s]; infinite once it has ended
        self._thread = threading.Thread(target=self._run, name="vibsim companion", daemon=True)

    def start(self) -> None:
        """Set off, where that has not been done."""
        if self._thread.ident is None:
            self._thread.start()

    def close(self) -> None:
        """End it where it is; waits for that for LONGEST at most."""
        self._closed = True
        if self._trajectory:
            self._trajectory.stop()
        if self._thread.ident is not None:
            self._thread.join(LONGEST)

    def _run(self) -> None:
        from vibsim.engine.errors import EngineError

        error: BaseException | None = None
        try:
            for block in self._blocks():
                self._hand_on(np.stack([block.samples[name] for name in self._names]))
                if self._closed:
                    return
                self.t_reached = max(block.t_reached, *block.samples["time"][-1:].tolist(), self.t_reached)
                self._tell_news()
        except EngineError:
            pass  # the run went on where this one failed: nothing more to compare with
        except BaseException as raised:  # raised again where the samples are asked for
            error = raised
        self._end(error)
        self.t_reached = inf
        self._tell_news()

    def _blocks(self) -> Iterator[Block]:
        with self._cores:
            self._trajectory = open_trajectory(self._scene, self._engine, lowest=HIGHER * LOWEST)
            blocks = self._trajectory.blocks()
        while not self._closed:
            with self._cores:
                block = next(blocks, None)
            if block is None:
                return
            yield block

    def _hand_on(self, piece: np.ndarray) -> None:
        """Take the next samples, shape (blocks that move, samples)."""
        raise NotImplementedError

    def _end(self, error: BaseException | None) -> None:
        """Note the end, and what it was if not that of the run."""
        raise NotImplementedError


class Companion(Beside):
    """A run beside the first, which may be as far ahead of it as a few blocks."""

    def __init__(
        self,
        scene: Scene,
        engine: str,
        tell_news: Callable[[], None] = lambda: None,
        cores: Cores | None = None,
    ):
        super().__init__(scene, engine, tell_news, cores)
        self._queue: SimpleQueue[np.ndarray | BaseException | None] = SimpleQueue()
        self._room = threading.Semaphore(BLOCKS_AHEAD)
        self._ended = False
        self._waiting: deque[np.ndarray] = deque()

    def has(self, count: int) -> bool:
        """Whether the next `count` samples, or all that there are, can be taken without waiting."""
        while not self._ended and not self._queue.empty() and self._at_hand < count:
            piece = self._arrived(lambda: True)
            if piece is not None:
                self._waiting.append(piece)
        return self._ended or self._at_hand >= count

    @property
    def _at_hand(self) -> int:
        return sum(piece.shape[1] for piece in self._waiting)

    def take(self, count: int, go_on: GoOn = lambda: True) -> np.ndarray:
        """Displacements [m] at the next `count` samples, shape (blocks that move, count).

        NaN from where the companion has failed, or where `go_on` says no: it is asked while they are waited
        for, since the companion may be far slower than the run.
        """
        rows = len(self._names)
        parts = [np.empty((rows, 0))]
        while count:
            piece = self._next(go_on)
            if piece is None:
                piece = np.full((rows, count), np.nan)
            if piece.shape[1] > count:
                self._waiting.appendleft(piece[:, count:])
            parts.append(piece[:, :count])
            count -= parts[-1].shape[1]
        return np.concatenate(parts, axis=1)

    def close(self) -> None:
        """End the companion where it is."""
        self._closed = True
        self._room.release()
        super().close()

    def _next(self, go_on: GoOn) -> np.ndarray | None:
        """The next samples; None after the last, or when not to go on."""
        return self._waiting.popleft() if self._waiting else self._arrived(go_on)

    def _arrived(self, go_on: GoOn) -> np.ndarray | None:
        """The next samples of those that have not been looked at; None as in `_next`."""
        piece = None if self._ended else self._awaited(go_on)
        if isinstance(piece, BaseException):
            raise piece
        self._ended = piece is None
        self._room.release()
        return piece

    def _awaited(self, go_on: GoOn) -> np.ndarray | BaseException | None:
        """The next block, or what ended it; None when not to go on, which is asked whenever it waits."""
        while True:
            if self._queue.empty() and not go_on():
                return None
            try:
                return self._queue.get(timeout=PATIENCE)
            except Empty:
                continue

    def _hand_on(self, piece: np.ndarray) -> None:
        self._room.acquire()
        self._queue.put(piece)

    def _end(self, error: BaseException | None) -> None:
        self._queue.put(error)
