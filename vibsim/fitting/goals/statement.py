"""A statement on the runs of a case: what is measured, which range it should be in, from how many starts."""

from __future__ import annotations

from dataclasses import dataclass

from vibsim.fitting.goals.bounds import Bounds
from vibsim.fitting.goals.observables import OBSERVABLES, Observable
from vibsim.results.windows import Window

MOST = 0.8  # share of the starts from which a statement should hold, unless it says otherwise


@dataclass(frozen=True)
class Asked:
    """What is to be measured of a run: an observable by name, with its argument and window if it has them."""

    name: str
    argument: float = 0.0
    window: Window | None = None
    last: float = 0.0  # [s] before the end, in place of a window

    @property
    def observable(self) -> Observable:
        """What it is, and how it is measured."""
        return OBSERVABLES[self.name]

    def window_in(self, t_end: float) -> Window | None:
        """The window [s] in a run of this length."""
        if self.last:
            return max(0.0, t_end - self.last), t_end
        return None if self.window is None else (self.window[0], min(self.window[1], t_end))


@dataclass(frozen=True)
class Statement:
    """One statement.

    Attributes
    ----------
    text : as given, without the name of the case
    case : position of its case
    asked, bounds : what is measured, and where it should be
    share : of the starts from which it should hold
    weight : against the other statements
    """

    text: str
    case: int
    asked: Asked
    bounds: Bounds
    share: float = MOST
    weight: float = 1.0

    def shortfall(self, value: float) -> float:
        """0 where a measured value fulfils it, up to 1 where it is far off."""
        if self.asked.observable.words is not None:
            return 0.0 if self.bounds.contain(value) else 1.0
        return self.bounds.shortfall(value)

    def decided_at(self, value: float, t_reached: float) -> float:
        """Time [s] up to which a run must be right for the value to be."""
        if self.asked.observable.instant and value == value:
            return value
        window = self.asked.window_in(t_reached)
        return t_reached if window is None else window[1]
