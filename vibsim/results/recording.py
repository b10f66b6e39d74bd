"""A run of the engine recorded as it comes, sample by sample, and judged on the way."""

import time
from collections.abc import Callable, Iterable
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibsim.engine.blocks import Block, Trajectory
from vibsim.engine.choice import flow_of
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory
from vibsim.results.blocks_ahead import BlocksAhead, Thinning, instants_per_sample, sampled_finer
from vibsim.results.columns import Distances, Tables, tables_of
from vibsim.results.file_contents import Column, origin, outcome
from vibsim.results.parallel_runs import GoOn
from vibsim.results.trajectory_file import exponent_attributes
from vibsim.results.trust_horizon import NoTrust, Rows, Trust

if TYPE_CHECKING:
    from vibsim.cases import Case


# A run of the engine, recorded block by block into memory or a file.


Watch = Callable[[float], bool]  # given how far the run is worked out [s]; False stops it there


class Sink(Protocol):
    """Takes the blocks of a run."""

    def append(self, samples: Rows, events: Rows) -> None: ...


class Recording:
    """One run of a case: `start` has the attributes known before it, `into` runs it, `end` has the rest.

    The engine runs in a thread of its own, from `set_off` on where something is to be done before `into`.
    With `trust`, a second run beside it tells until when it is right. tangent : number of Lyapunov exponents
    that it takes along, and the time [s] from which they count.
    """

    def __init__(
        self, case: "Case", engine: str = "auto", trust: bool = True, tangent: tuple[int, float] = (0, 0.0)
    ):
        self.scene = case.scene()
        self.began = time.perf_counter()
        instants = instants_per_sample(self.scene) if trust else 1
        judged = sampled_finer(self.scene, instants)
        self._thinning = Thinning(instants)
        count, begin = tangent
        self.trajectory = open_trajectory(judged, engine, ledger=True, tangent=count, tangent_from=begin)
        self._ahead = BlocksAhead(self.trajectory, partial(left_out, self.trajectory))
        engine = self.trajectory.engine
        self._origin = partial(origin, case, self.scene, engine, flow_of(self.scene))
        self.t_reached = self._known_to = self._worked_to = 0.0
        self.complete = False
        self._distances = Distances(case, self.scene)
        self._trust: NoTrust[tuple[Rows, float]] = NoTrust()
        if trust:
            self._trust = Trust(case, judged, engine, self._ahead.tell_news)
        self.tables = tables_of(self.scene).judged(self._trust.columns)

    @cached_property
    def start(self) -> dict[str, Any]:
        """Attributes known before the run."""
        return self._origin()

    def set_off(self) -> None:
        """Let the engine begin; to be followed by `into` or `close`."""
        self._ahead.start()
        self._trust.start()

    def close(self) -> None:
        """Let go of the engine, where it is."""
        self._ahead.close()
        self._trust.close()

    def into(self, sink: Sink, watch: Watch | None = None) -> None:
        """Run to the end, or until `watch` says stop; raises EngineError when the run fails."""

        def go_on() -> bool:
            return watch is None or watch(self.progress)

        self.set_off()
        try:
            try:
                self._run(sink, go_on)
            except EngineError:
                self._hand_on(sink, self._trust.rest(go_on))
                raise
            self._hand_on(sink, self._trust.rest(go_on))
        finally:
            self.close()

    def _run(self, sink: Sink, go_on: GoOn) -> None:
        """Hand on what the engine tells; where `go_on` says no, what it has computed by then."""
        going = True

        def goes_on() -> bool:
            nonlocal going
            going = going and go_on()
            return going

        def judge_what_waits() -> None:
            self._hand_on(sink, self._trust.ready(goes_on))

        for block, missing in self._ahead.blocks(goes_on, judge_what_waits):
            times = block.samples["time"][-1:].tolist()
            self._known_to = max(float(block.t_reached), *times, self._known_to)
            self._worked_to = block.worked_to
            tag = block.events, self._known_to
            self._hand_on(
                sink, self._trust.judged(block.samples, block.events["t"], missing, tag, go_on, going)
            )
            if not goes_on():
                self._ahead.stop()
        self.complete = going

    def _hand_on(self, sink: Sink, judged: Iterable[tuple[Rows, tuple[Rows, float]]]) -> None:
        """Give the sink blocks of samples, each with its events and the time [s] that is known then."""
        for rows, (events, known_to) in judged:
            samples = self._thinning.thinned(rows)
            sink.append(samples, events)
            self._distances.update(samples, events)
            self.t_reached = known_to

    @property
    def progress(self) -> float:
        """How far the run is worked out [s]: a third is the motion, a third what goes with it, such as the
        energy ledger, which a long stretch without events gets after its samples, and a third the companion,
        which may be a few blocks behind.
        """
        known = self._known_to
        return known - ((known - self._worked_to) + max(known - self._trust.t_reached, 0.0)) / 3

    def end(self) -> dict[str, Any]:
        """Attributes of what came of the run so far."""
        wall_time = time.perf_counter() - self.began
        totals = self.trajectory.totals
        known = outcome(totals, self.t_reached, self._distances.attrs, wall_time, self.complete)
        return {**known, **exponent_attributes(totals), **self._trust.attrs(self.t_reached)}


def left_out(trajectory: Trajectory[float], block: Block) -> np.ndarray | float:
    """Distance that completed chatter has left out at the samples of a block [m], wherever that ends."""
    ends = trajectory.left_out if trajectory.scene.rigid_stops else []
    if not ends:
        return 0.0
    times, distances = np.array([(-np.inf, 0.0), *ends]).T
    return np.asarray(distances[np.searchsorted(times, block.samples["time"], side="right") - 1])


class MemorySink:
    """Keeps the blocks of a run as arrays."""

    def __init__(self, tables: Tables):
        self._columns = tables
        self._samples: dict[str, list[np.ndarray]] = {name: [] for name in tables.samples}
        self._events: dict[str, list[np.ndarray]] = {name: [] for name in tables.events}

    def append(self, samples: Rows, events: Rows) -> None:
        for name, parts in self._samples.items():
            parts.append(samples[name])
        for name, parts in self._events.items():
            parts.append(events[name])

    def tables(self) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Samples and events, name -> 1-D array."""
        return _joined(self._samples, self._columns.samples), _joined(self._events, self._columns.events)


def _joined(parts: dict[str, list[np.ndarray]], columns: dict[str, Column]) -> dict[str, np.ndarray]:
    return {name: _one(arrays, columns[name].dtype) for name, arrays in parts.items()}


def _one(arrays: list[np.ndarray], dtype: Any) -> np.ndarray:
    if len(arrays) == 1:
        return arrays[0].astype(dtype, copy=False)
    return np.concatenate(arrays, dtype=dtype)
