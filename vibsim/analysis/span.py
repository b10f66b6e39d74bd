"""The span of a run that a verdict rests on, and until when the run is right."""

from dataclasses import dataclass
from fractions import Fraction
from numbers import Real

from vibsim.cases.quantities import QuantityError, decimal_text, parse_quantity
from vibsim.results.result import Result, Window

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
        return float(self.value * Fraction(t_end)) if self.relative else float(self.value)

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
