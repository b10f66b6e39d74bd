"""Run a case with any number of digits, into memory or straight into a file."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibsim.engine.choice import flow_of
from vibsim.engine.columns import state_columns
from vibsim.engine.truth import open_truth
from vibsim.files.signals import held_back
from vibsim.results.columns import tables_of
from vibsim.results.digits import Digits
from vibsim.results.many_digits.right_digits import DigitsPlan, EndState, end_of
from vibsim.results.motion.rest_distance import Distances
from vibsim.results.recording.recording import MemorySink, Sink, Watch
from vibsim.results.result import Result
from vibsim.results.stored.provenance import origin, outcome
from vibsim.results.trust.trust import Rows

if TYPE_CHECKING:
    from vibsim.cases import Case


class TruthSink(Sink, Protocol):
    """Takes the blocks of a run and their digits."""

    def append_digits(self, samples: Rows, events: Rows) -> None: ...


class TruthRecording:
    """One run of `digits` digits: `start` has the attributes known before it, `into` runs it, `end` has the
    rest.

    `end_state` is that of its last event, exactly as the digits have it; None before the end.
    """

    def __init__(self, case: "Case", digits: int):
        self.scene = case.scene()
        self.began = time.perf_counter()
        self.trajectory = open_truth(case.exact_scene, digits)
        kit = self.trajectory.kit
        self.start = {
            **origin(case, self.scene, self.trajectory.engine, flow_of(self.scene)),
            "digits": digits,
            "precision_bits": kit.bits,
            "number_type": kit.name,
            "number_library": kit.library,
        }
        if "taylor_tolerance" in self.start:
            self.start["taylor_order"] = self.trajectory.order
            del self.start["taylor_tolerance"]  # that of doubles; here the working precision is the tolerance
        self.t_reached, self.complete = 0.0, False
        self.end_state: EndState | None = None
        self._events: list[Rows] = []
        self._rest = Distances(case, self.scene)

    def into(self, sink: TruthSink, watch: Watch | None = None) -> None:
        """Run to the end, or until `watch` says stop; raises EngineError when the run fails."""
        for block in self.trajectory.blocks():
            sink.append_digits(block.sample_digits, block.event_digits)
            sink.append(block.samples, block.events)
            self._rest.update(block.samples, block.events)
            self._events.append(block.events)
            self.t_reached = max(block.t_reached, *block.samples["time"][-1:].tolist(), self.t_reached)
            last = end_of(block.event_digits)
            if watch is not None and not watch(self.t_reached):
                return
        self.complete, self.end_state = True, last

    def events(self) -> Rows:
        """The event table so far, in doubles."""
        return {name: np.concatenate([part[name] for part in self._events]) for name in self._events[0]}

    def end(self) -> dict[str, Any]:
        """Attributes of what came of the run so far."""
        wall_time = time.perf_counter() - self.began
        return outcome(self.trajectory.totals, self.t_reached, self._rest.attrs, wall_time, self.complete)


class TruthMemory(MemorySink):
    """Keeps the blocks of a run and their digits."""

    def __init__(self, recording: TruthRecording):
        super().__init__(tables_of(recording.scene))
        names = state_columns(recording.scene)
        self._sample_digits: dict[str, list[np.ndarray]] = {name: [] for name in names}
        self._event_digits: dict[str, list[np.ndarray]] = {name: [] for name in ("t", *names)}

    def append_digits(self, samples: Rows, events: Rows) -> None:
        for name, parts in self._sample_digits.items():
            parts.append(samples[name])
        for name, parts in self._event_digits.items():
            parts.append(events[name])

    def digits(self) -> Digits:
        """The digits as `Result.digits` offers them."""
        samples = {name: np.concatenate(parts) for name, parts in self._sample_digits.items()}
        events = {name: np.concatenate(parts) for name, parts in self._event_digits.items()}
        return Digits(samples, events)


def truth(case: "Case", digits: int | str, engine: str = "auto") -> Result:
    """Run a case with so many digits ("auto": as many as leave ten right ones at its end), in memory."""
    check_engine(engine)
    recording, sink, attrs = _run(case, digits, TruthMemory)
    samples, events = sink.tables()
    return Result({**recording.start, **attrs}, samples, events, case=case, digits=sink.digits())


def truth_to_file(
    case: "Case",
    path: str | Path,
    digits: int | str,
    engine: str = "auto",
    force: bool = False,
    watch: Watch | None = None,
) -> Result:
    """The same straight into an HDF5 file; `watch`, errors and what is kept as with `simulate_to_file`."""
    from vibsim.results.many_digits.truth_writer import TruthWriter
    from vibsim.results.stored.trajectory_file import TrajectoryFile

    check_engine(engine)

    def writer(recording: TruthRecording) -> TruthWriter:
        return TruthWriter(
            path, tables_of(recording.scene), recording.start, recording.start["digits"], force
        )

    recording, sink, attrs = _run(case, digits, writer, watch)
    file = TrajectoryFile(sink.finish(attrs), tables_of(recording.scene))
    return Result({**recording.start, **attrs}, file.samples, file.events, case=case, digits=file.digits)


def check_engine(engine: str) -> None:
    """ValueError where the C engine is asked for, which has doubles only."""
    if engine == "c":
        raise ValueError("digits need the Python engine; the C engine has doubles only")


def _run(case: "Case", digits: int | str, open_sink: Callable[..., Any], watch: Watch | None = None) -> Any:
    """Recording, sink and last attributes of the run whose digits are enough."""
    plan = DigitsPlan(case, digits, watch)
    while True:
        recording = TruthRecording(case, plan.digits)
        sink = None
        try:
            with held_back():
                sink = open_sink(recording)
            recording.into(sink, watch)
            verdict = plan.verdict(recording.end_state, recording.events())
        except BaseException:
            _keep(sink, recording)
            raise
        if plan.enough:
            return recording, sink, {**recording.end(), **verdict}
        _drop(sink)


def _keep(sink: Any, recording: TruthRecording) -> None:
    """Leave a file with what was computed under its partial name; memory needs nothing."""
    if hasattr(sink, "keep"):
        sink.keep(recording.end())


def _drop(sink: Any) -> None:
    """Make room for the run of more digits that takes the place of this one."""
    if hasattr(sink, "drop"):
        sink.drop()
