"""Kinds of command-line values that several commands share."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isfinite
from typing import Any

import click
from click.shell_completion import CompletionItem


class OneOf(click.Choice):
    """One of a few words; of another, the nearest is named."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value not in self.choices:
            from vibsim.cases.spelling import did_you_mean

            near = did_you_mean(str(value), self.choices)
            self.fail(f"{value!r} is not one of {', '.join(self.choices)}{near}", param, ctx)
        return super().convert(value, param, ctx)


class CaseSource(click.ParamType):
    """A case: completed from the shipped cases' names and the files at hand."""

    name = "case"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from vibsim.cases import gallery_case_names, hard_case_names, shipped_case_names

        names = [*shipped_case_names(), *gallery_case_names(), *hard_case_names()]
        shipped = [CompletionItem(name) for name in names if name.startswith(incomplete)]
        return [*shipped, CompletionItem(incomplete, type="file")]


class CheckName(click.ParamType):
    """A check of `vibsim verify`, or how it begins."""

    name = "check"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from vibsim.evidence.verification.catalogue import all_checks
        from vibsim.evidence.verification.selection import spellings

        return [CompletionItem(name) for name in spellings(all_checks()) if name.startswith(incomplete)]


class Pair(click.ParamType):
    """KEY=TEXT, as a pair.

    form : how it is written, with an example; read : makes of the text what it says, or raises ValueError
    several : whether there may be several keys, KEY=KEY=TEXT
    """

    name = "pair"

    def __init__(self, form: str, read: Callable[[str], Any] = str, several: bool = False) -> None:
        self.form, self.read, self.several = form, read, several

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, Any]:
        if isinstance(value, tuple):
            return value
        parts = value.rpartition("=") if self.several else value.partition("=")
        key, equals, text = (part.strip() for part in parts)
        try:
            if key and equals:
                return key, self.read(text)
        except ValueError:
            pass
        self.fail(f"{value!r} is not {self.form}", param, ctx)


def some_text(text: str) -> str:
    """The text itself. Raises ValueError where there is none."""
    if not text:
        raise ValueError
    return text


class FiniteRange(click.FloatRange):
    """A number in a range; nan, which no comparison keeps out, and inf are none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"{value} is no finite number", param, ctx)
        return number


class Window(click.ParamType):
    """A:B, a span of time in seconds; either end may be left out."""

    name = "window"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float]:
        if isinstance(value, tuple):
            return value
        start, colon, stop = value.partition(":")
        try:
            window = float(start or 0), float(stop or "inf")
        except ValueError:
            window = 1.0, 0.0
        if not colon or not window[0] < window[1]:
            self.fail(f"{value!r} is not A:B with A < B in seconds, such as 100:110", param, ctx)
        return window


class DigitCount(click.ParamType):
    """A number of decimal digits, or auto."""

    name = "digits"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int | str:
        from vibsim.physics.arithmetic.working_precision import FEWEST_DIGITS, MOST_DIGITS

        if value == "auto":
            return "auto"
        try:
            digits = int(value)
        except ValueError:
            self.fail(f"must be a whole number or auto, got {value!r}", param, ctx)
        if not FEWEST_DIGITS <= digits <= MOST_DIGITS:
            allowed = f"{FEWEST_DIGITS} to {MOST_DIGITS}"
            self.fail(f"{digits} is not in the range {allowed}; doubles have 16", param, ctx)
        return digits


class OrbitDigitCount(DigitCount):
    """A number of decimal digits; an orbit is no run that loses them."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int | str:
        if value == "auto":
            self.fail("'auto' is for runs; give a whole number", param, ctx)
        return super().convert(value, param, ctx)


class ExponentCount(click.ParamType):
    """A number of Lyapunov exponents, or all."""

    name = "exponents"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int | str:
        if value == "all":
            return "all"
        if isinstance(value, int):
            return value
        if not value.isdecimal() or int(value) == 0:
            self.fail(f"must be a whole number above 0, or all, got {value!r}", param, ctx)
        return int(value)


CASE = CaseSource()
CHECK = CheckName()
DIGITS = DigitCount()
EXPONENTS = ExponentCount()
ASSIGNMENT = Pair("KEY=VALUE, such as excitation.Omega0='6.5 Hz'")
KEY_RANGE = Pair("KEY=RANGE, such as c=0.01:0.05/9", some_text, several=True)
KEY_SPREAD = Pair("KEY=HOW, such as x1=1mm", some_text)
WINDOW = Window()
FILE = click.Path(path_type=str, readable=False)  # who opens it says why it cannot be read


def once_each(
    ctx: click.Context, param: click.Parameter, pairs: Sequence[tuple[str, Any]]
) -> Sequence[tuple[str, Any]]:
    """KEY=... pairs, each key once: of two values one would be ignored."""
    keys = [key for key, _ in pairs]
    for key in keys:
        if keys.count(key) > 1:
            raise click.BadParameter(f"{key} is given twice", ctx, param)
    return pairs


def joined(pairs: Iterable[tuple[str, str]], options: Mapping[str, str | None]) -> dict[str, str]:
    """Values by key: those of --set, and of options (key -> value or None) that stand for a key.

    Raises UsageError where one key has both.
    """
    values = dict(pairs)
    for key, value in options.items():
        name = key.rpartition(".")[2]
        if value is not None and (key in values or name in values):
            option = "--" + name.replace("_", "-")
            raise click.UsageError(
                f"{option} and --set {key if key in values else name} say the same; choose one"
            )
    return values | {key: value for key, value in options.items() if value is not None}


set_option = click.option(
    "-s",
    "--set",
    "changes",
    metavar="KEY=VALUE",
    multiple=True,
    type=ASSIGNMENT,
    callback=once_each,
    help="Change a value; repeatable.",
)
