"""Runs of as many digits as are asked for, and how many of them are right."""

import time
from collections.abc import Callable, Collection, Mapping
from decimal import Context, Decimal
from fractions import Fraction
from math import ceil, floor, log10
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibsim.engine.columns import state_columns
from vibsim.engine.errors import EngineError, State
from vibsim.engine.tangent.error_growth import error_growth, last_states
from vibsim.engine.trajectory import flow_of
from vibsim.engine.truth import open_truth
from vibsim.physics.numbers import Number
from vibsim.physics.parts import Scene
from vibsim.physics.precision import FEWEST_DIGITS, MOST_DIGITS, digits_in_c
from vibsim.results.columns import Digits, Distances, tables_of
from vibsim.results.file_contents import origin, outcome
from vibsim.results.recording import MemorySink, Sink, TruthWriter, Watch
from vibsim.results.result import Result
from vibsim.results.trajectory_file import TrajectoryFile, doubt_attributes
from vibsim.results.trust_horizon import Rows
from vibsim.signals import held_back

if TYPE_CHECKING:
    from vibsim.cases import Case


# How many digits a run must carry, and how many of them are right at its end.
#
# Two runs of different precision follow each other until the errors of the coarser one have grown to the size
# of the motion. Where they still agree to `a` digits at the end, the coarser run, of p digits, has lost p -
# a; the finer one loses as many of its own. The coarser run is one in doubles where that says enough: it
# costs next to nothing.


EndState = dict[str, Decimal]

DOUBLE_DIGITS = 53 * log10(2)
WANTED = 10  # right digits at the end of a run with digits "auto"
TELLING = 3  # agreement below so many digits may be chance
ORDINARY = 30  # digits of a run without chaos
MARGIN, SHARE = 6, 1.15  # digits beyond the growth found in doubles, which is an estimate
CLOSER = 8  # the same where digits are chosen by the number types of C
FINER = 12  # digits that a run carries beyond the one it is compared with
LEAST = Decimal("1e-6")
EXACT = Context(prec=2 * MOST_DIGITS)
ROUGH = Context(prec=20)  # for numbers of digits


class DigitsPlan:
    """The precision of a run: `digits` for the next attempt, `enough` once a verdict has found them so.

    digits : the digits, or "auto" for as many as leave WANTED right ones at the end
    """

    def __init__(self, case: "Case", digits: int | str, watch: Watch | None = None):
        self.case, self.watch = case, watch
        self.in_c = digits_in_c()
        self.automatic = digits == "auto"
        self.enough = not self.automatic
        self.scene = case.scene()
        self._growth: float | None = None
        self.coarse_digits, self.coarse = DOUBLE_DIGITS, end_in_doubles(self.scene)
        self.digits = self._first_choice() if self.automatic else _whole(digits)

    @property
    def growth(self) -> float:
        """Digits lost over the run, as kicks in doubles tell; a guess where doubles fail altogether."""
        if self._growth is None:
            try:
                self._growth = error_growth(self.scene)
            except EngineError:
                self._growth = 2 * DOUBLE_DIGITS
        return self._growth

    def _first_choice(self) -> int:
        if self.growth + TELLING <= DOUBLE_DIGITS and self.coarse is not None:
            return max(ORDINARY, ceil(self.growth) + WANTED + MARGIN)
        digits = max(FEWEST_DIGITS, ceil(SHARE * self.growth) + MARGIN)
        finer = digits + FINER
        if self.in_c and finer > self.in_c[-1]:  # C may do: of long runs twice the growth is estimated
            finer = next((most for most in self.in_c if most >= self.growth / 2 + WANTED), self.in_c[-1])
            digits = finer - CLOSER
        self._compare_with(digits)
        return self._within_reach(finer)

    def _compare_with(self, digits: int) -> None:
        self.coarse_digits = self._within_reach(digits)
        self.coarse = end_in_digits(self.case, self.coarse_digits, self.watch)

    def _within_reach(self, digits: float) -> int:
        if digits > MOST_DIGITS:
            scene = self.scene
            x, v = [body.x for body in scene.bodies], [body.v for body in scene.bodies]
            raise EngineError("precision", State(scene.t_end, x, v, 0.0, 0.0, 0.0))
        return ceil(digits)

    def verdict(self, end: EndState | None, events: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """Knowledge of the digits of a run with the state `end` at its end, as attributes of its file.

        end is None where the run did not reach it; events: its event table in doubles. Sets `enough`, and
        `digits` for another attempt.
        """
        if end is None:
            self.enough = True
            return {}
        tables = tables_of(self.scene)
        others = set(tables.states) - {*tables.displacements, *tables.velocities}
        agreed = None if self.coarse is None else agreement(self.coarse, end, others)
        if self.automatic and self.coarse_digits == DOUBLE_DIGITS and not (agreed and agreed >= TELLING):
            fewer = max(FEWEST_DIGITS, ceil(self.growth) + 2 * TELLING)
            if fewer < self.digits:  # these may do: a coarser run that tells costs less than a finer one
                self._compare_with(fewer)
                agreed = None if self.coarse is None else agreement(self.coarse, end, others)
        if agreed is not None and agreed >= TELLING:
            right = floor(self.digits - max(self.coarse_digits - agreed, 0))
            return self._judged(max(right, 0), self._source(), end)
        if self.automatic:
            return self._judged(0, "", end)
        growth = error_growth(self.scene, along=events)
        return self._judged(max(floor(self.digits - growth - 1), 0), "growth of small kicks, estimated", end)

    def _source(self) -> str:
        coarse = (
            "in doubles" if self.coarse_digits == DOUBLE_DIGITS else f"of {self.coarse_digits:.0f} digits"
        )
        return f"agreement with a run {coarse}"

    def _judged(self, right: int, source: str, end: EndState) -> dict[str, Any]:
        self.enough = not self.automatic or right >= WANTED
        if not self.enough:
            self.coarse_digits, self.coarse = self.digits, end
            more = self._within_reach(1.5 * self.digits + FINER)
            self.digits = next((most for most in self.in_c if most >= self.digits + FINER), more)
        return {"digits_right": right, "digits_right_from": source}


def agreement(
    first: Mapping[str, Decimal], second: Mapping[str, Decimal], others: Collection[str] = ()
) -> float:
    """Decimal digits to which two states agree, the fewest of any quantity relative to its size.

    A displacement or velocity of a body counts by LEAST of the largest one at least: that of a body which
    has come to rest is 0 but for rounding, and has no digits. Infinite where the states are equal.

    others : names of what is neither, as states are
    """
    fewest = float("inf")
    of_bodies = {name: value for name, value in first.items() if name not in others}
    for name, value in first.items():
        apart = EXACT.abs(EXACT.subtract(value, second[name]))
        if apart:
            size = max(abs(value), abs(second[name]), LEAST * _largest(of_bodies, name))
            fewest = min(fewest, max(float(ROUGH.log10(ROUGH.divide(size, apart))), 0.0))
    return fewest


def _largest(state: Mapping[str, Decimal], name: str) -> Decimal:
    """The largest |x|, or |v|, of all bodies where `name` is one of them; 0 else."""
    alike = (abs(value) for other, value in state.items() if other[0] == name[0] in "xv")
    return max(alike, default=Decimal(0)) if name in state else Decimal(0)


def end_in_doubles(scene: Scene) -> EndState | None:
    """Time and state at the end of a run in doubles; None where it fails."""
    try:
        table = last_states(scene)
    except EngineError:
        return None
    return {name: Decimal(float(table[name][-1])) for name in ("t", *state_columns(scene))}


def end_in_digits(case: "Case", digits: int, watch: Watch | None = None) -> EndState | None:
    """The same in so many digits; None where `watch` stopped the run."""

    def without_samples(number: Callable[[Fraction], Number], pi: Number) -> Scene[Number]:
        return case.exact_scene(number, pi).without_samples()

    end = None
    for block in open_truth(without_samples, digits).blocks():
        end = end_of(block.event_digits) or end
        if watch is not None and not watch(block.t_reached):
            return None
    return end


def end_of(event_digits: Mapping[str, Any]) -> EndState | None:
    """Time and state in the last row of a block of event digits; None without rows."""
    if not len(event_digits["t"]):
        return None
    return {name: Decimal(column[-1].decode()) for name, column in event_digits.items()}


def _whole(digits: object) -> int:
    """A number of digits. Raises ValueError for what is no whole number."""
    if not isinstance(digits, Integral):
        raise ValueError(f"digits must be a whole number or 'auto', got {digits!r}")
    return int(digits)


# Run a case with any number of digits, into memory or straight into a file.


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
            **origin(case, self.scene, flow_of(self.scene)),
            "digits": digits,
            "precision_bits": kit.bits,
            "number_type": kit.name,
            "number_library": kit.library,
        }
        if "taylor_tolerance" in self.start:
            self.start["taylor_order"] = kit.order()
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
        known = outcome(self.trajectory.totals, self.t_reached, self._rest.attrs, wall_time, self.complete)
        return {**known, **doubt_attributes(self.trajectory.doubts)}


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


def truth(case: "Case", digits: int | str) -> Result:
    """Run a case with so many digits ("auto": as many as leave ten right ones at its end), in memory."""
    recording, sink, attrs = _run(case, digits, TruthMemory)
    samples, events = sink.tables()
    return Result({**recording.start, **attrs}, samples, events, case=case, digits=sink.digits())


def truth_to_file(
    case: "Case",
    path: str | Path,
    digits: int | str,
    force: bool = False,
    watch: Watch | None = None,
) -> Result:
    """The same straight into an HDF5 file; `watch`, errors and what is kept as with `simulate_to_file`."""

    def writer(recording: TruthRecording) -> TruthWriter:
        return TruthWriter(
            path, tables_of(recording.scene), recording.start, recording.start["digits"], force
        )

    recording, sink, attrs = _run(case, digits, writer, watch)
    file = TrajectoryFile(sink.finish(attrs), tables_of(recording.scene))
    return Result({**recording.start, **attrs}, file.samples, file.events, case=case, digits=file.digits)


def _run(
    case: "Case",
    digits: int | str,
    open_sink: Callable[..., Any],
    watch: Watch | None = None,
) -> Any:
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
