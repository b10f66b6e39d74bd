"""The span of a run that a verdict rests on, and until when the run is right."""

from dataclasses import dataclass

from vibsim.analysis.discard import transient
from vibsim.results.result import Result
from vibsim.results.windows import Window

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
