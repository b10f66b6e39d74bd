"""The companion of a run: the same case integrated a second time, differently, beside the first.

What two runs share, their difference cannot show. So the companion takes other steps, at full
tolerance: those of the other flow where there are two, else of another order (the same flow from other
data alone misses some growth). Infinite sequences of impacts it ends at least one whole hop earlier: what the
run leaves out there is not left out by both. And its data lie on the other side of the true
ones: a decimal such as 0.297 kg is no double, and every number that is none is moved by one unit in the last
place towards its exact value. Without that the phase error of a motor that turns evenly, which comes of the
data, would be missed: after 10,000 s it is 70 times the distance of two runs from equal data. And its events
lie on other points of the grid of time: an impact comes between two doubles, and a run takes the nearer one.
Where motions forget their start, as a body does that has rested on a shaken base, that is nearly all of the
error, and runs that round to the same double share it.
"""

import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from math import inf, nextafter
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.values.pi import FIRST_BITS, two_pi_bounds
from vibsim.engine.choice import flow_of
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
# A run beside another may take so many times its events, and so many more, up to any sample: runs of one
# motion take the same ones, of sequences of impacts that a sample falls into thousands more or less
TIMES, MORE = 2, 4096
BLOCKS_AHEAD = 8  # bounds the memory of a companion that is faster than the run
GoOn = Callable[[], bool]
GIVEN_UP = f"took more than {TIMES} times the events of the run and {MORE} besides"


def most_events(taken: np.ndarray) -> np.ndarray:
    """How many events a run beside another may take where that has `taken` so many. Counts and no times: what
    comes of them is the same on every machine.
    """
    return TIMES * taken + MORE


@dataclass(frozen=True)
class Piece:
    """The next samples of a run beside another.

    x : displacements [m], shape (blocks that move, samples); events : how many it took up to each sample, and
    in `total` up to where it is
    """

    x: np.ndarray
    events: np.ndarray
    total: int


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
    moved = "its data one ulp towards their decimal values, its events one ulp aside"
    return f"difference from a second run by {stepping}, {moved}"


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
    dither : how its events are moved on the grid of time, as of `open_trajectory`
    """

    dither = 1

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
        self._taken = 0  # events
        self.t_reached = 0.0  # [s]; infinite once it has ended
        self.failure = ""  # why it ended before the run, in words
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
        from vibsim.engine.errors import REASONS, EngineError

        error: BaseException | None = None
        try:
            for block in self._blocks():
                self._hand_on(self._piece(block))
                if self._closed:
                    break
                self.t_reached = max(block.t_reached, *block.samples["time"][-1:].tolist(), self.t_reached)
                self._tell_news()
        except EngineError as raised:  # the run went on where this one failed: nothing more to compare with
            self.failure = self.failure or f"ended at {raised.state.t:.6g} s: {REASONS[raised.reason][0]}"
        except BaseException as raised:  # raised again where the samples are asked for
            error = raised
        self._end(error)
        self.t_reached = inf
        self._tell_news()

    def _blocks(self) -> Iterator[Block]:
        with self._cores:
            self._trajectory = open_trajectory(self._scene, self._engine, early=True, dither=self.dither)
            blocks = self._trajectory.blocks()
        while not self._closed:
            with self._cores:
                block = next(blocks, None)
            if block is None:
                return
            yield block

    def _piece(self, block: Block) -> Piece:
        x = np.stack([block.samples[name] for name in self._names])
        begun, happened = self._taken, block.events["t"]
        self._taken += len(happened)
        counts = begun + np.searchsorted(happened, block.samples["time"], side="right")
        return Piece(x, counts, self._taken)

    def _hand_on(self, piece: Piece) -> None:
        """Take the next samples."""
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
        self._queue: SimpleQueue[Piece | BaseException | None] = SimpleQueue()
        self._room = threading.Semaphore(BLOCKS_AHEAD)
        self._ended = False
        self._waiting: deque[Piece] = deque()
        self._total = 0  # events by the last piece that has arrived

    def has(self, most: np.ndarray) -> bool:
        """Whether the next samples, as many as `most` has (see `take`), or all that there are, can be taken
        without waiting.
        """
        while not self._ended and not self._queue.empty() and self._at_hand < len(most):
            piece = self._arrived(lambda: True)
            if piece is not None and len(piece.events):
                self._waiting.append(piece)
            if self._at_hand < len(most) and self._total > most[self._at_hand]:
                return True
        return self._ended or self._at_hand >= len(most)

    @property
    def _at_hand(self) -> int:
        return sum(len(piece.events) for piece in self._waiting)

    def take(self, most: np.ndarray, go_on: GoOn = lambda: True) -> np.ndarray:
        """Displacements [m] at the next samples, shape (blocks that move, samples).

        most : how many events the companion may take up to each of them: where it takes more it is given up.
        NaN from there, from where it has failed, or where `go_on` says no: it is asked while they are waited
        for, since the companion may be far slower than the run.
        """
        taken = np.full((len(self._names), len(most)), np.nan)
        done = 0
        while done < len(most) and (piece := self._next(go_on, most[done])) is not None:
            count = min(len(piece.events), len(most) - done)
            within = piece.events[:count] <= most[done : done + count]
            if not within.all():
                count = int(np.argmin(within))
                self._give_up()
            elif count < len(piece.events):
                rest = Piece(piece.x[:, count:], piece.events[count:], piece.total)
                self._waiting.appendleft(rest)
            taken[:, done : done + count] = piece.x[:, :count]
            done += count
        return taken

    def _give_up(self) -> None:
        """End it, with what it has computed by now."""
        self.failure, self._ended, self._closed, self.t_reached = GIVEN_UP, True, True, inf
        self._waiting.clear()
        self._room.release()

    def close(self) -> None:
        """End the companion where it is."""
        self._closed = True
        self._room.release()
        super().close()

    def _next(self, go_on: GoOn, most: int) -> Piece | None:
        """The next samples; None after the last, when not to go on, and where more than `most` events came
        before them.
        """
        if self._waiting:
            return self._waiting.popleft()
        if not self._ended and self._total > most:
            self._give_up()
        return self._arrived(go_on)

    def _arrived(self, go_on: GoOn) -> Piece | None:
        """The next samples of those that have not been looked at; None as in `_next`."""
        piece = None if self._ended else self._awaited(go_on)
        if isinstance(piece, BaseException):
            raise piece
        self._ended = piece is None
        self._total = self._total if piece is None else piece.total
        self._room.release()
        return piece

    def _awaited(self, go_on: GoOn) -> Piece | BaseException | None:
        """The next block, or what ended it; None when not to go on, which is asked whenever it waits."""
        while True:
            if self._queue.empty() and not go_on():
                return None
            try:
                return self._queue.get(timeout=PATIENCE)
            except Empty:
                continue

    def _hand_on(self, piece: Piece) -> None:
        self._room.acquire()
        self._queue.put(piece)

    def _end(self, error: BaseException | None) -> None:
        self._queue.put(error)
