"""Says of a run that takes far longer than its span suggests how fast it goes and how long it may take."""

import time
from collections.abc import Callable, Sequence
from math import isfinite

from vibsim.command_line.terminal.printing import say

PATIENCE = 1.0  # seconds on the clock over which the rate is taken
SLOW = 100.0  # seconds of the motion in one on the clock; the cases of the paper take 10,000
STIFF = 1e6  # of the rate of a damper times the span: the tenth of it in steps, of 1 us each, is not felt
LONG = 60.0  # seconds; a run that ends sooner needs no word
AGAIN = 10.0  # times as long as was told: told anew
UNITS = (("years", 31_557_600.0), ("days", 86_400.0), ("hours", 3600.0), ("minutes", 60.0))


class SlowRun:
    """Tells, on stderr, that the run `label` to `t_end` [s] is slow, and again where it gets far slower; and
    what of its scene may be the reason.

    damping : the fastest damper, (name, rate [1/s]), which may ask for many steps
    lossless : names of the rigid stops with e = 1, on which hops that die out never end
    """

    def __init__(
        self,
        label: str,
        t_end: float,
        shown: bool = True,
        clock: Callable[[], float] = time.monotonic,
        damping: tuple[str, float] = ("", 0.0),
        lossless: Sequence[str] = (),
    ):
        self._damping, self._lossless = damping, lossless
        self._label, self._t_end, self._shown, self._clock = label, t_end, shown, clock
        self._since, self._t, self._worth = clock(), 0.0, LONG

    def note(self, t: float) -> None:
        """Learn that the run is worked out to `t` [s]."""
        now = self._clock()
        if not self._shown or now - self._since < PATIENCE:
            return
        rate = (t - self._t) / (now - self._since)
        left = (self._t_end - t) / rate if rate > 0 else float("inf")
        self._since, self._t = now, t
        if 0 <= rate < SLOW and left > self._worth:
            self._worth = AGAIN * left
            say(f"{self._label}: {_told(t, rate, left)}{self._reason()}", err=True)

    def _reason(self) -> str:
        name, rate = self._damping
        if rate * self._t_end >= STIFF:
            return (
                f"; the damper of {name} (c / m = {rate:.2g} 1/s) asks for steps of some {9 / rate:.1g} s:"
                " with a smaller c, or one body in place of the two that it holds together, the run is fast"
            )
        if self._lossless:
            names = ", ".join(self._lossless)
            return (
                f"; hops on {names} (e = 1) that die out come ever faster and never end; with e < 1 they end"
            )
        return ""


def _told(t: float, rate: float, left: float) -> str:
    if not isfinite(left):
        return f"slow: no further than t = {t:.3g} s in the last second; Ctrl-C ends it"
    return f"slow: {rate:.2g} s of the motion per second, about {duration(left)} more; Ctrl-C ends it"


def duration(seconds: float) -> str:
    """So many seconds in the unit that suits, to two digits: "3.1 hours", "1.2e+09 years"."""
    for unit, length in UNITS:
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.0f} seconds"
