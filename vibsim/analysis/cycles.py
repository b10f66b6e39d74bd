"""The span of a run that a verdict rests on, the words of verdicts, and the cycles of the source within it.

Cycles end with the multiples of the common period of forces and base; with a motor at the first passages of
phi through multiples of 2 pi, on the line between two samples.
"""

from collections import deque
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from math import ceil, floor, inf, pi
from numbers import Real

import numpy as np

from vibsim.cases.quantities import QuantityError, decimal_text, parse_quantity
from vibsim.physics import elementary
from vibsim.physics.elementary import mean
from vibsim.physics.parts import Motor, Scene
from vibsim.physics.rates import common_period, turning_columns
from vibsim.results.result import Result, Window, pieces, rows_within

TRANSIENT = 0.5  # share of a run that is left out where its steady motion is judged, as in sweeps


@dataclass(frozen=True)
class Span:
    """From `begin` to `end` [s] of a run; its displacements are right until `trust_horizon` [s].

    `trust_horizon` is None where it was not worked out.
    """

    begin: float
    end: float
    trust_horizon: float | None = None

    @property
    def length(self) -> float:
        return self.end - self.begin

    @property
    def window(self) -> Window:
        return self.begin, self.end

    @property
    def trusted(self) -> bool | None:
        """Whether the whole span is right; None where that is not known."""
        return None if self.trust_horizon is None else self.end <= self.trust_horizon


def span_of(result: Result, window: Window | None = None) -> Span:
    """The part of `window` [s] that the run covers; without a window, all of the run.

    Raises ValueError where the run covers nothing of it.
    """
    begin, end = window or (0.0, result.t_reached)
    span = Span(max(begin, 0.0), min(end, result.t_reached), result.trust_horizon)
    if not span.begin < span.end and window is not None:
        raise ValueError(f"the window {begin:g}:{end:g} s lies outside the run, 0 to {result.t_reached:g} s")
    return span


def steady_span(result: Result, window: Window | None = None) -> Span:
    """The part of `window` [s] that the run covers; without a window, the second half of the run."""
    return span_of(result, window or (TRANSIENT * result.t_reached, result.t_reached))


def later_part(result: Result, window: Window | None, discard: float | str | None) -> Window:
    """The window [s] without its transient, see `transient`.

    discard : None: nothing where a window is given, else half the run

    Raises ValueError where nothing is left, and for a window outside the run.
    """
    whole = span_of(result, window)
    left_out = 0.0 if window and discard is None else transient(discard, whole.length)
    if not 0 <= left_out < whole.length:
        raise ValueError(
            f"a transient of {left_out:g} s leaves nothing of {whole.begin:g} to {whole.end:g} s"
        )
    return whole.begin + left_out, whole.end


# How much of a run is left out at its start, where its steady motion is judged: the transient.


@dataclass(frozen=True)
class Discard:
    """A time [s], or a fraction of t_end where `relative`; exact."""

    value: Fraction
    relative: bool

    def time(self, t_end: float) -> float:
        """Time [s] at which the statistics begin, in a run up to t_end [s]."""
        top, bottom = t_end.as_integer_ratio() if self.relative else (1, 1)
        return (self.value.numerator * top) / (self.value.denominator * bottom)

    def __str__(self) -> str:
        return f"{decimal_text(self.value * 100)} %" if self.relative else f"{decimal_text(self.value)} s"


HALF = Discard(Fraction(1, 2), True)


def transient(discard: object, length: float) -> float:
    """Time [s] that is left out at the start of a span of `length` [s].

    discard : a time [s], or a text such as "100 s", "0.5" (of the span) or "50 %"; None: half of the span

    Raises ValueError for a text that is neither, TypeError for anything else.
    """
    if isinstance(discard, str):
        try:
            return parse_discard(discard).time(length)
        except ValueError as error:
            raise ValueError(f"discard: {error}") from None
    if isinstance(discard, Real) and not isinstance(discard, bool):
        return float(discard)
    if discard is not None:
        raise TypeError(
            f"discard must be a time in s, or a text such as '100 s' or '50 %', got {discard!r:.60}"
        )
    return HALF.time(length)


def parse_discard(text: str) -> Discard:
    """The transient that `text` spells: `100 s`, `0.5` (of t_end) or `50 %`. Raises ValueError."""
    word = text.strip()
    number, percent, rest = word.partition("%")
    try:
        if percent and not rest:
            fraction = parse_quantity(number, "number").value / 100
        elif word[-1:].isdigit() or word[-1:] == ".":
            fraction = parse_quantity(word, "number").value
        else:
            return _time(parse_quantity(word, "time").value, word)
    except QuantityError:
        raise ValueError(f"must be a time or a fraction, such as 100s, 0.5 or 50%, got {text!r}") from None
    return _fraction(fraction, word)


def _time(time: Fraction, word: str) -> Discard:
    if time < 0:
        raise ValueError(f"the time {word} is negative")
    return Discard(time, False)


def _fraction(value: Fraction, word: str) -> Discard:
    if not 0 <= value < 1:
        raise ValueError(
            f"a fraction must be at least 0 and below 1, got {word}; a time needs its unit, such as 100s"
        )
    return Discard(value, True)


# The words of verdicts, as enumerations whose members are these very texts.


class Verdict(str, Enum):
    """A word out of a few; equal to its text, printed and written as it.

    >>> from vibsim.analysis import CaptureVerdict
    >>> CaptureVerdict.NOT_MET == "not met", f"{CaptureVerdict.NOT_MET}", CaptureVerdict("passed")
    (True, 'not met', <CaptureVerdict.PASSED: 'passed'>)
    """

    __str__ = str.__str__

    def __format__(self, format_spec: str) -> str:
        return str.__format__(self, format_spec)


class CaptureVerdict(Verdict):
    """Was a motor captured: see `vibsim.analysis.capture`."""

    CAPTURED = "captured"
    ESCAPED = "escaped"
    PASSED = "passed"
    NOT_MET = "not met"
    UNDECIDED = "undecided"


class DriftVerdict(Verdict):
    """Direction of the drift of a body; undecided where the interval of the rate contains 0 and more."""

    FORWARD = "forward"
    BACKWARD = "backward"
    NONE = "none"
    UNDECIDED = "undecided"


class ImpactsVerdict(Verdict):
    """In how many cycles of the source there are impacts, or of a friction stick phases."""

    EVERY_CYCLE = "every cycle"
    SOME_CYCLES = "some cycles"
    NO_IMPACTS = "no impacts"
    NO_STICKS = "no sticks"
    UNDECIDED = "undecided"


class RegimeVerdict(Verdict):
    """Verdict on the kind of motion: rest, periodic, quasi-periodic, chaotic."""

    AT_REST = "at rest"
    PERIODIC = "periodic"
    TRANSIENT = "transient"
    QUASI_PERIODIC = "quasi-periodic"
    CHAOTIC = "chaotic"
    UNDECIDED = "undecided"


class FrequenciesVerdict(Verdict):
    """Whether a displacement has dominant frequencies; still: nothing vibrates."""

    LINES = "lines"
    STILL = "still"
    UNDECIDED = "undecided"


class ComparisonVerdict(Verdict):
    """Whether two runs are the same."""

    IDENTICAL = "identical"
    AGREE = "agree"
    AGREE_UNTIL = "agree_until"
    AGREE_IN_STATISTICS = "agree_in_statistics"
    DIFFER = "differ"


def name_verdict(judged: object, kind: type[Verdict]) -> None:
    """Make the verdict of a frozen dataclass a member of its enumeration. Raises ValueError for others."""
    object.__setattr__(judged, "verdict", kind(judged.verdict))  # type: ignore[attr-defined]


# Stretches in which the mean speed of a motor stays within a narrow band, and how much they delay it.
#
# Without vibration the motor would run up as Omega0 (1 - exp(-t/T)), T = Omega0 (J + m3 e^2)/M0, and pass the
# band from w1 to w2 in T ln((Omega0 - w1)/(Omega0 - w2)). A hold that lasts n times as long is one in which
# the vibration takes up the share 1 - 1/n of the torque.


TURNS = 12  # to average over: a multiple of the periods 1, 2, 3, 4 and 6 that the motion may have
BAND = 0.03  # half width of the band, relative; beside a resonance the mean speed beats by about 2 %
LEAST_TURNS = 20  # of a hold
DELAY = 3.0  # least delay that is called lingering
MOST_MEANS = 20_000  # of a run; longer ones are thinned


@dataclass(frozen=True)
class Hold:
    """A stretch in which the mean speed stays within the band.

    Attributes
    ----------
    begin, end : [s]
    speed_hz : mean over it [Hz]
    turns : of the rotor
    below_no_load : 1 - speed / no-load speed, the share of the stall torque that drives
    delay : its length over the time in which the free motor would pass the band; 0 where it never would
    at_end : whether it lasts to the end of the span
    """

    begin: float
    end: float
    speed_hz: float
    turns: float
    below_no_load: float
    delay: float
    at_end: bool

    @property
    def absorbed(self) -> float:
        """Share of the driving torque that the vibration takes up: 1 - 1/delay."""
        return max(0.0, 1 - 1 / self.delay) if self.delay else 0.0


def mean_speeds(turn_times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean speeds over TURNS turns [Hz] and the middles of those turns [s], from the ends of the turns."""
    step = max(1, len(turn_times) // MOST_MEANS)
    first, last = turn_times[:-TURNS:step], turn_times[TURNS::step]
    return (first + last) / 2, TURNS / (last - first)


def run_up_time(motor: Motor) -> float:
    """Time constant of the motor without vibration [s]: Omega0 (J + m3 e^2)/M0; inf without torque."""
    return motor.Omega0 * motor.inertia / motor.M0 if motor.M0 else inf


def holds_of(times: np.ndarray, speeds: np.ndarray, motor: Motor) -> list[Hold]:
    """All holds among the mean speeds [Hz] at `times` [s], the longest taken first, in order of time."""
    spans = [(0, len(speeds))]
    holds = []
    while spans:
        start, stop = spans.pop()
        first, last = longest_stretch(speeds[start:stop])
        first, last = first + start, last + start
        hold = _hold(times, speeds, first, last, motor)
        if hold is not None:
            holds.append(hold)
            spans += [(start, first), (last + 1, stop)]
    return sorted(holds, key=lambda hold: hold.begin)


def _hold(times: np.ndarray, speeds: np.ndarray, first: int, last: int, motor: Motor) -> Hold | None:
    """The means from `first` to `last` as a hold; None where it has too few turns."""
    if last <= first:
        return None
    length = float(times[last] - times[first])
    speed = float(mean(speeds[first : last + 1]))
    if speed * length < LEAST_TURNS:
        return None
    no_load = motor.Omega0 / TURN
    return Hold(
        float(times[first]),
        float(times[last]),
        speed,
        speed * length,
        1 - speed / no_load,
        length / free_passage(motor, speed),
        last == len(speeds) - 1,
    )


def free_passage(motor: Motor, speed: float) -> float:
    """Time in which the motor would pass the band about `speed` [Hz] without vibration [s]; inf: never."""
    low, high = speed * (1 - BAND), speed * (1 + BAND)
    no_load = motor.Omega0 / TURN
    return run_up_time(motor) * elementary.log((no_load - low) / (no_load - high)) if high < no_load else inf


def longest_stretch(speeds: np.ndarray) -> tuple[int, int]:
    """First and last of the longest stretch of consecutive positive values within the band; (0, -1): none."""
    ratio = (1 + BAND) / (1 - BAND)
    highest: deque[int] = deque()  # candidates for the greatest value from `start` on, descending
    lowest: deque[int] = deque()
    start, best = 0, (0, -1)
    values = speeds.tolist()
    for i, value in enumerate(values):
        if value <= 0:
            highest.clear()
            lowest.clear()
            start = i + 1
            continue
        while highest and values[highest[-1]] <= value:
            highest.pop()
        while lowest and values[lowest[-1]] >= value:
            lowest.pop()
        highest.append(i)
        lowest.append(i)
        while values[highest[0]] > ratio * values[lowest[0]]:
            start += 1
            if highest[0] < start:
                highest.popleft()
            if lowest[0] < start:
                lowest.popleft()
        if i - start > best[1] - best[0]:
            best = start, i
    return best


TURN = 2 * pi
ROWS = 1 << 20  # samples read at a time


def cycle_ends(result: Result, window: Window) -> np.ndarray:
    """Ascending times within the window at which a cycle of the source ends [s]; none without a source, and
    where several have no common period.
    """
    scene = result.case.scene()
    turning = turning_columns(scene)
    if turning is not None:
        return _turn_ends(result, window, turning[0])
    return period_ends(scene, window)


def period_ends(scene: Scene, window: Window) -> np.ndarray:
    """Ascending ends of the common periods of forces and base within the window [s]; none without one."""
    period = common_period(scene)
    if period is None:
        return np.empty(0)
    first, last = (edge * period.cycles / period.turns for edge in window)
    times = np.asarray(period.end(np.arange(ceil(first), floor(last) + 1)))
    return times[(times >= window[0]) & (times <= window[1])]


def _turn_ends(result: Result, window: Window, angle: str) -> np.ndarray:
    """Instants at which the furthest angle so far passes a whole turn, on the line between two samples."""
    rows = rows_within(result.column("time"), window)
    ends, reached = [np.empty(0)], -np.inf
    for piece in pieces(rows, ROWS):
        joined = slice(max(piece.start - 1, rows.start), piece.stop)  # no interval is lost between pieces
        t, phi = (np.asarray(result.column(name)[joined]) for name in ("time", angle))
        ends.append(_passages(t, phi, reached))
        reached = max(reached, float(phi.max()))
    return np.concatenate(ends)


def _passages(t: np.ndarray, phi: np.ndarray, reached: float) -> np.ndarray:
    """Times [s] at which phi (n) first passes a whole turn above `reached`, the furthest angle before."""
    furthest = np.maximum.accumulate(phi)
    first = ceil(furthest[0] / TURN) if reached == -np.inf else floor(reached / TURN) + 1
    turns = TURN * np.arange(first, floor(furthest[-1] / TURN) + 1)
    right = np.searchsorted(furthest, turns, side="left")
    left = np.maximum(right - 1, 0)  # the first sample itself may end a turn
    rise = phi[right] - phi[left]
    share = np.divide(turns - phi[left], rise, out=np.zeros_like(rise), where=rise > 0)
    return np.asarray(t[left] + share * (t[right] - t[left]))


# The events of a span; of a file only their rows are read.


def events_within(result: Result, window: Window, *names: str, before: int = 0) -> dict[str, np.ndarray]:
    """Event columns by name (all without names) within the window [s], both ends included.

    before : how many events before the window to add, as far as there are any
    """
    rows = rows_within(result.event_column("t"), window)
    rows = slice(max(0, rows.start - before), rows.stop)
    return {name: np.asarray(result.event_column(name)[rows]) for name in names or result.events}
