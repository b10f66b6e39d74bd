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

from vibsim.engine.blocks import Block
from vibsim.engine.blocks_ahead import LONGEST, PATIENCE, Cores
from vibsim.engine.errors import REASONS, EngineError
from vibsim.engine.trajectory import Trajectory, flow_of, open_trajectory
from vibsim.physics.elementary import FIRST_BITS, two_pi_bounds
from vibsim.physics.formulas import Node, children
from vibsim.physics.parts import Scene
from vibsim.results.columns import tables_of

if TYPE_CHECKING:
    from vibsim.cases import Case


PARTS = ("bodies", "links", "stops", "frictions", "forces", "base", "motor", "rotors", "base_formula")
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
class RunPiece:
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
    """A number, part or tuple of these, its numbers changed, each by what stands at its place in `other`;
    those of a formula, which are exact, from the nearest double.

    The turns of a harmonic stay: they are carried as two doubles, and right to 32 digits.
    """
    if isinstance(value, tuple) and value and isinstance(value[0], str):
        return _with_formula_numbers(value, change, {})
    if isinstance(value, tuple):
        return tuple(with_numbers(one, another, change) for one, another in zip(value, other, strict=True))
    if is_dataclass(value):
        names = [each.name for each in fields(value) if each.name not in TURNS]
        pairs = {name: (getattr(value, name), getattr(other, name)) for name in names}
        return replace(value, **{name: with_numbers(*pair, change) for name, pair in pairs.items()})  # type: ignore[type-var]
    return change(value, other) if isinstance(value, float) else value


def _with_formula_numbers(node: Node, change: Callable[[float, Any], float], known: dict[Node, Node]) -> Node:
    """A formula in which each number, and pi, is what `change` makes of the nearest double."""
    if node not in known:
        if node[0] in ("num", "pi"):
            exact = two_pi_bounds(FIRST_BITS)[0] / 2 if node[0] == "pi" else node[1]
            known[node] = ("num", Fraction(change(float(exact), exact)))
        else:
            below = [_with_formula_numbers(child, change, known) for child in children(node)]
            known[node] = (node[0], *below, *node[1 + len(below) :]) if below else node
    return known[node]


def towards(value: float, exact: Fraction) -> float:
    """A double one ulp towards its exact value; itself where it is exact."""
    error = Fraction(exact) - Fraction(value)
    return nextafter(value, inf if error > 0 else -inf) if error else value


class ParallelRun:
    """A run of `scene` in a thread of its own, of which only the displacements at the samples are used.

    The C engine lets go of the interpreter while it computes: on two cores it costs hardly any time.
    tell_news : called in that thread whenever it has come further; cores : asked for one, block by block
    dither : how its events are moved on the grid of time, as of `open_trajectory`
    """

    dither = 1

    def __init__(
        self,
        scene: Scene,
        tell_news: Callable[[], None] = lambda: None,
        cores: Cores | None = None,
    ):
        self._scene, self._tell_news = scene, tell_news
        self._cores = cores or Cores(1)
        self._names = tables_of(scene).deciding
        self._closed = False
        self._trajectory: Trajectory | None = None
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
            self._trajectory = open_trajectory(self._scene, early=True, dither=self.dither)
            blocks = self._trajectory.blocks()
        while not self._closed:
            with self._cores:
                block = next(blocks, None)
            if block is None:
                return
            yield block

    def _piece(self, block: Block) -> RunPiece:
        x = np.stack([block.samples[name] for name in self._names])
        begun, happened = self._taken, block.events["t"]
        self._taken += len(happened)
        counts = begun + np.searchsorted(happened, block.samples["time"], side="right")
        return RunPiece(x, counts, self._taken)

    def _hand_on(self, piece: RunPiece) -> None:
        """Take the next samples."""
        raise NotImplementedError

    def _end(self, error: BaseException | None) -> None:
        """Note the end, and what it was if not that of the run."""
        raise NotImplementedError


class Companion(ParallelRun):
    """A run beside the first, which may be as far ahead of it as a few blocks."""

    def __init__(
        self,
        scene: Scene,
        tell_news: Callable[[], None] = lambda: None,
        cores: Cores | None = None,
    ):
        super().__init__(scene, tell_news, cores)
        self._queue: SimpleQueue[RunPiece | BaseException | None] = SimpleQueue()
        self._room = threading.Semaphore(BLOCKS_AHEAD)
        self._ended = False
        self._waiting: deque[RunPiece] = deque()
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
                rest = RunPiece(piece.x[:, count:], piece.events[count:], piece.total)
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

    def _next(self, go_on: GoOn, most: int) -> RunPiece | None:
        """The next samples; None after the last, when not to go on, and where more than `most` events came
        before them.
        """
        if self._waiting:
            return self._waiting.popleft()
        if not self._ended and self._total > most:
            self._give_up()
        return self._arrived(go_on)

    def _arrived(self, go_on: GoOn) -> RunPiece | None:
        """The next samples of those that have not been looked at; None as in `_next`."""
        piece = None if self._ended else self._awaited(go_on)
        if isinstance(piece, BaseException):
            raise piece
        self._ended = piece is None
        self._total = self._total if piece is None else piece.total
        self._room.release()
        return piece

    def _awaited(self, go_on: GoOn) -> RunPiece | BaseException | None:
        """The next block, or what ended it; None when not to go on, which is asked whenever it waits."""
        while True:
            if self._queue.empty() and not go_on():
                return None
            try:
                return self._queue.get(timeout=PATIENCE)
            except Empty:
                continue

    def _hand_on(self, piece: RunPiece) -> None:
        self._room.acquire()
        self._queue.put(piece)

    def _end(self, error: BaseException | None) -> None:
        self._queue.put(error)


# By how much a companion is too near: told by a third run, where the distance has grown.
#
# A run and its companion may share the error in the direction that grows, and then the distance is too small
# from there on. Where it has grown by four decades it lies in that direction: if a third run lies further
# away there, the distance is multiplied by as much behind it. To be far too low by bad luck takes two runs
# that share the error of the first.


GROWN = 1e4  # of a distance by its rounding, where the third run is asked
WINDOW = 16  # samples at which it is
MOST = 2.0**200  # of a factor: nothing is known
# displacements [m] of the third run, shape (bodies, last), as third(count, last, until): at the `last` of its
# first `count` samples, which end at the time `until` [s]. NaN where it has failed, infinite where nothing
# will be known of it. Raises NotYet
Third = Callable[[int, int, float], np.ndarray]
Window = list[tuple[np.ndarray, np.ndarray]]  # the run at these samples, and its distances


class NotYet(Exception):
    """The third run has not come so far; who asks may ask again."""


class ThirdRunFactor:
    """Factor of distances, sample after sample, wherever the blocks of samples begin and end."""

    def __init__(self) -> None:
        self._count = 0  # of the samples so far
        self._asked: int | None = None  # number of the first sample at which the third run is asked
        self._window: Window = []
        self._share: float | None = None  # at least 1

    def of(
        self,
        time: np.ndarray,
        ours: np.ndarray,
        apart: np.ndarray,
        distance: np.ndarray,
        rounding: np.ndarray,
        third: Third,
    ) -> np.ndarray | None:
        """The factors at the next samples; None where all are 1. Where the third run raises NotYet, all is as
        it was.

        ours, apart : displacements of the run (bodies, samples), its distances to the companion; distance :
        the same, held; rounding : of it, all [m]
        """
        begin, asked, window = self._count, self._asked, self._window
        if asked is None:
            grown = distance > GROWN * rounding
            if not grown.any():
                self._count += len(time)
                return None
            asked = begin + int(np.argmax(grown))
        low, high = max(asked - begin, 0), asked + WINDOW - begin
        if self._share is None:
            window = [*window, (ours[:, low:high], apart[low:high])]
            if high <= len(time):
                self._share = compared(window, third(begin + high, WINDOW, float(time[high - 1])))
        self._count, self._asked, self._window = begin + len(time), asked, window
        if self._share is None:
            return None
        self._window = []
        return np.where(np.arange(len(time)) >= high, self._share, 1.0) if self._share > 1 else None


def compared(window: Window, theirs: np.ndarray) -> float:
    """Ratio of the distance of the third run to that of the companion, at least 1; 1 where it has failed."""
    ours, apart = (np.concatenate(parts, axis=-1) for parts in zip(*window, strict=True))
    share = float(np.abs(ours - theirs).max() / apart.max())
    return min(share, MOST) if share > 1 else 1.0


# The third run, which is asked once: for the end of what it has to show (see `trust_share`).


ORDERS = (22, OTHER_ORDER, USUAL_ORDER)


def third_scene(companion: Scene, scene: Scene) -> Scene:
    """The scene of a third run, whose steps are those of neither a run of `scene` nor its companion.

    Of its data that the companion has on one side of those of `scene`, half lie on the other: where what two
    of them do to the motion cancels in the companion, it adds up here.
    """
    order = next(order for order in ORDERS if order not in (scene.order, companion.order))
    sides = PerturbationSigns()
    data = {name: with_numbers(getattr(scene, name), getattr(companion, name), sides.of) for name in PARTS}
    return replace(companion, method="taylor", order=order, **data)


class PerturbationSigns:
    """Signs of the one-ulp perturbations of a third run: + - - + - + + - ..., so that no two sums of
    them cancel because of a period (the sequence of Thue and Morse).
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


class LastSamples(ParallelRun):
    """The `last` of the first `count` samples of a run of `scene`, which ends with them.

    most : events that it may take before it is given up
    """

    dither = 2  # the companion has 1

    def __init__(
        self,
        scene: Scene,
        count: int,
        last: int,
        most: int,
        tell_news: Callable[[], None] = lambda: None,
        cores: Cores | None = None,
    ):
        super().__init__(scene, tell_news, cores)
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

    def _hand_on(self, piece: RunPiece) -> None:
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

    def __init__(self, companion: Scene, scene: Scene, tell_news: Callable[[], None], cores: Cores):
        self._companion, self._scene = companion, scene
        self._tell_news, self._cores = tell_news, cores
        self._run: LastSamples | None = None

    @property
    def is_awaited(self) -> bool:
        """Whether it was asked and has not ended."""
        return self._run is not None and self._run.t_reached < inf

    @property
    def failure(self) -> str:
        """Reason why nothing is known of it, in words; empty where something is."""
        return GIVEN_UP if self._run is not None and self._run.failure == GIVEN_UP else ""

    def displacements(self, go_on: GoOn, count: int, last: int, until: float, most: int) -> np.ndarray | None:
        """Displacements by `LastSamples` of a run up to `until` [s], of `most` events; None where it goes on
        when `go_on` says no.
        """
        if self._run is None:
            third = replace(third_scene(self._companion, self._scene), t_end=until)
            self._run = LastSamples(third, count, last, most, self._tell_news, self._cores)
            self._run.start()
        while (told := self._run.told(PATIENCE if go_on() else 0.0)) is None and go_on():
            pass
        return told

    def close(self) -> None:
        """End it where it is."""
        if self._run:
            self._run.close()
