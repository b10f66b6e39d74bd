"""The terminal: what goes to its streams, progress, and commands as a shell reads them."""

from __future__ import annotations

import json
import os
import re
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from vibsim.cases.problems import Problem
    from vibsim.command_line.options import Settings


# A bar of how far the work is, on stderr where that is a terminal.


PROGRESS_AFTER = 1.0  # seconds before a bar appears of work that is often done sooner
FINE = 1000  # steps of a bar over what is not counted
WIDTH = 28  # characters of the name of a step, so that bars below each other are in line


class Progress:
    """A bar for each step of the work, to be entered; the time still to wait counts from where a step begins.

    patience : seconds that a step may take before its bar appears
    listed : whether there are several steps, which are said line by line where there is no terminal
    """

    def __init__(self, shown: bool, patience: float = 0.0, listed: bool = False):
        self._shown, self._patience, self._listed = shown, patience, listed
        self._step, self._done = "", 0.0
        self._began = time.time()
        self._bar: Any = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def show(self, step: str, done: float, total: float, item: str = "") -> None:
        """Say how far a step is: of a whole number of things, or of so many seconds of motion.

        item : what is being done, of a step whose things take unequal times: no time to wait is told
        """
        if not self._shown:
            return
        if step != self._step or done < self._done:  # the next step, or this one once more
            self._begin(step)
        self._done = done
        if not sys.stderr.isatty() or time.time() - self._began < self._patience:
            return
        if self._bar is None:
            self._bar = self._new_bar(total, item)
        reached = int(self._bar.length * done / total) if total else self._bar.length
        if reached > self._bar.pos:
            self._bar.update(reached - self._bar.pos, current_item=item or f"{done:.1f} of {total:g} s")

    def close(self) -> None:
        """Leave the terminal line as the bar left it."""
        if self._bar is not None:
            self._bar.render_finish()
            self._bar = None

    def _begin(self, step: str) -> None:
        self.close()
        if self._step:
            self._began = time.time()
        if self._listed and not sys.stderr.isatty():
            say(step, err=True)
        self._step = step

    def _new_bar(self, total: float, item: str) -> Any:
        from vibsim.cases.problems import plain_text

        counted = isinstance(total, int)
        label = plain_text(self._step)
        bar: Any = click.progressbar(
            length=int(total) if counted else FINE,
            label=f"{label:{WIDTH}}" if self._listed else label,
            file=sys.stderr,
            show_eta=not item,
            show_pos=counted,
            item_show_func=None if counted else lambda shown: shown,
        )
        bar.start = self._began  # on the clock of click; it counts what came before the bar
        bar.current_item = item or None
        bar.render_progress()
        return bar


# Says of a run that takes far longer than its span suggests how fast it goes and how long it may take.


SLOW_AFTER = 1.0  # seconds on the clock over which the rate is taken
SLOW = 100.0  # seconds of the motion in one on the clock; the cases of the paper take 10,000
STIFF = 1e6  # of the rate of a damper times the span: the tenth of it in steps, of 1 us each, is not felt
LONG = 60.0  # seconds; a run that ends sooner needs no word
TELL_AGAIN = 10.0  # times as long as was told: told anew
UNITS = (("years", 31_557_600.0), ("days", 86_400.0), ("hours", 3600.0), ("minutes", 60.0))


class SlowRun:
    """Tells, on stderr, that the run `label` to `t_end` [s] is slow, and again where it gets far slower; and
    what of its scene may be the reason.

    damping : the fastest damper or state, (name, rate [1/s]), which may ask for many steps
    states : names of the states
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
        states: Sequence[str] = (),
    ):
        self._damping, self._lossless, self._states = damping, lossless, states
        self._label, self._t_end, self._shown, self._clock = label, t_end, shown, clock
        self._since, self._t, self._worth = clock(), 0.0, LONG

    def note(self, t: float) -> None:
        """Learn that the run is worked out to `t` [s]."""
        now = self._clock()
        if not self._shown or now - self._since < SLOW_AFTER:
            return
        rate = (t - self._t) / (now - self._since)
        left = (self._t_end - t) / rate if rate > 0 else float("inf")
        self._since, self._t = now, t
        if 0 <= rate < SLOW and left > self._worth:
            self._worth = TELL_AGAIN * left
            say(f"{self._label}: {_told(t, rate, left)}{self._reason()}", err=True)

    def _reason(self) -> str:
        name, rate = self._damping
        if rate * self._t_end >= STIFF and name in self._states:
            return (
                f"; the state {name}, which comes to rest at {rate:.2g} 1/s, asks for steps of some"
                f" {9 / rate:.1g} s: with a formula of the value that it follows in its place the run is fast"
            )
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


# What the command prints: text in which nothing of the user's is obeyed, and JSON.


_OWN = f"\x1b{os.urandom(8).hex()}"  # begins the colours of vibsim's own until they are printed
# control and format characters that JSON may hold as they are, and surrogates, which UTF-8 does not take
_UNSAFE_IN_JSON = re.compile(
    "[\x7f-\x9f\u00ad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
)


def style(text: object, **look: Any) -> str:
    """A text in colour or bold, as `click.style`; `say` prints it so."""

    from vibsim.cases.problems import plain_text

    return click.style(plain_text(text), **look).replace("\x1b", _OWN)


def say(text: str = "", err: bool = False, nl: bool = True, lines: bool = False) -> None:
    """Print a line; control characters in it are written out (\\x1b), but for `style`.

    lines : whether the text may have line ends of its own; in a line they come from a name of the user's
    """

    from vibsim.cases.problems import plain_text

    allowed = "\n\t" if lines else "\t"
    parts = [plain_text(part, allowed) for part in text.split(_OWN)]
    click.echo("\x1b".join(parts), err=err, nl=nl)


def print_json(value: Any, indent: int | None = None) -> None:
    """Print JSON, on one line unless indented; null for what is not finite, because NaN is no JSON."""
    from vibsim.results.hdf5_reading import plain

    text = json.dumps(plain(value), allow_nan=False, ensure_ascii=False, indent=indent)
    click.echo(_UNSAFE_IN_JSON.sub(_escaped, text))


def print_written(settings: Settings, paths: Sequence[str]) -> None:
    """Print the paths of files that a command has written."""
    if settings.json:
        print_json({"written": paths})
    elif not settings.quiet:
        for path in paths:
            say(path)


def _escaped(match: re.Match[str]) -> str:
    return f"\\u{ord(match[0]):04x}"


# Standard streams that the caller closed (`<&-`, `>&-`, a service without them).


STREAMS = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))


def open_closed_streams() -> None:
    """Open the null device in place of every closed standard stream.

    Python has None for them, and the next file that is opened would get their number: what a library prints
    to number 2 would stand in a result.
    """
    for number, (name, mode) in enumerate(STREAMS):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 (until the end)


# Messages that name arguments of Python, in the words of the command line: force=True is --force here.


PLACES = {
    "overrides": "--set",
    "axes": "--param",
    "spread": "--spread",
    "free": "--free",
}  # of values of a case
PHRASES = (
    (r"\bforce=True (?=replaces|drops)", "--force "),
    (r"\(sweep with axes=\{KEY: RANGE\}\)", "(sweep with --param KEY=RANGE)"),
    (r"\(sweep with axes=\{KEY: RANGE\}, ensemble=N\)", "(sweep with --param KEY=RANGE, --ensemble N)"),
    (r"\(sweep with compute='([a-z-]+)'\)", r"(sweep with --compute \1)"),
    (r'\(continue_branch\(orbit, "Omega0", "FROM:TO"\)\)', "(vibsim continue --omega0)"),
    (r"\(search_orbits\), or give period=N$", "(--search), or give --period"),
    (r'such as spread=\{"x1": "1 mm"\}', "such as --spread x1=1mm"),
    (r"ask for none: ensemble=0$", "ask for none: --ensemble 0"),
)


def in_shell(text: str) -> str:
    """A message of the library with options in place of arguments."""
    for python, option in PHRASES:
        text = re.sub(python, option, text)
    return text


def problem_in_shell(problem: Problem, places: Mapping[str, str]) -> Problem:
    """A problem of a case; where an argument brought the value, its place is the option.

    places : options that stand for a key and were given, as --t-end does for run.t_end, by their keys
    """
    place, key = problem.file, problem.key
    if problem.line is None and key:
        place = PLACES.get(place, place)
    if place == "--set" and key in places:
        place, key = places[key], ""
    return replace(problem, file=place, key=key, message=in_shell(problem.message))
