"""Options and parameters that several commands share."""

import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import click
from click.shell_completion import CompletionItem

# Kinds of command-line values that several commands share.


class OneOf(click.Choice):
    """One of a few words; of another, the nearest is named."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value not in self.choices:
            from vibsim.cases.problems import did_you_mean

            near = did_you_mean(str(value), self.choices)
            self.fail(f"{value!r} is not one of {', '.join(self.choices)}{near}", param, ctx)
        return super().convert(value, param, ctx)


class CaseSource(click.ParamType):
    """A case: completed from the shipped cases' names and the files at hand."""

    name = "case"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        from vibsim.cases.sources import PathText

        return PathText(value)

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
        from vibsim.evidence.verification.catalogue import all_checks, spellings

        return [CompletionItem(name) for name in spellings(all_checks()) if name.startswith(incomplete)]


class NameList(click.ParamType):
    """Names separated by commas, as a tuple, each completed by itself.

    allowed : the names there are; check : takes the names and the text, and raises ValueError for others
    """

    def __init__(
        self, name: str, allowed: Sequence[str], check: Callable[[Sequence[str], str], object] | None = None
    ) -> None:
        self.name, self.allowed, self.check = name, allowed, check

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        if isinstance(value, tuple):
            return value
        names = tuple(name.strip() for name in value.split(",") if name.strip())
        try:
            if self.check is not None:
                self.check(names, value)
        except ValueError as error:
            self.fail(str(error), param, ctx)
        return names

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        done, comma, begun = incomplete.rpartition(",")
        return [CompletionItem(done + comma + name) for name in self.allowed if name.startswith(begun)]


class PairType(click.ParamType):
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


class WindowType(click.ParamType):
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


class DiscardType(click.ParamType):
    """A transient that is left out: a time or a share of the run, as a `vibsim.analysis.cycles.Discard`."""

    name = "discard"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        from vibsim.analysis.cycles import parse_discard

        try:
            return parse_discard(value) if isinstance(value, str) else value
        except ValueError as error:
            self.fail(str(error), param, ctx)


class DigitCount(click.ParamType):
    """A number of decimal digits, or auto."""

    name = "digits"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int | str:
        from vibsim.physics.precision import FEWEST_DIGITS, MOST_DIGITS

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
DISCARD = DiscardType()
DIGITS = DigitCount()
EXPONENTS = ExponentCount()
ASSIGNMENT = PairType("KEY=VALUE, such as excitation.Omega0='6.5 Hz'")
KEY_RANGE = PairType("KEY=RANGE, such as c=0.01:0.05/9", some_text, several=True)
KEY_SPREAD = PairType("KEY=HOW, such as x1=1mm", some_text)
RAMP = PairType("KEY=FROM:TO, such as Omega0=3:7Hz", some_text)
WINDOW = WindowType()
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
    given = {key: value for key, value in options.items() if value is not None}
    for key in given:
        name = key.rpartition(".")[2]
        option = "--" + name.replace("_", "-")
        if key in values or name in values:
            raise click.UsageError(
                f"{option} and --set {key if key in values else name} say the same; choose one"
            )
        click.get_current_context().ensure_object(Settings).places[key] = option
    return values | given


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


# The options that every command has: -v, -q, --json, --color. They may stand before or after its name.


@dataclass
class Settings:
    """The global options; `ctx.obj` of every command.

    verbose : print more; quiet : print nothing but errors; json : results as JSON on stdout
    places : options that gave values of a case, by the keys that they stand for; not one of the options
    """

    verbose: bool = False
    quiet: bool = False
    json: bool = False
    color: str = "auto"
    places: dict[str, str] = field(default_factory=dict)


def global_options() -> list[click.Option]:
    """New copies of the global options; they fill in `ctx.obj` and are not passed to the command."""

    def option(*names: str, **rest: Any) -> click.Option:
        return click.Option(names, expose_value=False, callback=_remember, default=None, **rest)

    return [
        option("-v", "--verbose", is_flag=True, help="Print more."),
        option("-q", "--quiet", is_flag=True, help="Print nothing but errors."),
        option("--json", is_flag=True, help="Print results as JSON."),
        option(
            "--color",
            type=OneOf(["auto", "always", "never"]),
            help="Color the output; auto: on a terminal, unless NO_COLOR is set.",
        ),
    ]


def add_global_options(command: click.Command) -> None:
    """Let a command take the global options after its name, except those that it defines itself."""
    taken = {name for parameter in command.params for name in parameter.opts}
    command.params += [option for option in global_options() if not taken.intersection(option.opts)]


def _remember(ctx: click.Context, option: click.Parameter, value: Any) -> None:
    settings = ctx.ensure_object(Settings)
    if value is not None and option.name is not None:
        setattr(settings, option.name, value)
    ctx.color = _wants_color(settings.color)


def _wants_color(choice: str) -> bool | None:
    """For click: True or False, or None to color on a terminal."""
    if choice == "auto":
        return False if os.environ.get("NO_COLOR") else None
    return choice == "always"


# Options that several commands have, each written once.


Decorator = Callable[[Any], Any]
every_end_option = click.option("--t-end", metavar="TIME", help="End of every run, such as 100s.")
stored_force_option = click.option(
    "--force", is_flag=True, help="Replace an output file that holds something else."
)


def count_option(
    name: str, words: str, default: int | None = None, least: int = 0, metavar: str = "N"
) -> Decorator:
    """An option that takes a whole number, no less than `least`; words : its help, behind it a default."""
    kind, shown = click.IntRange(min=least), default is not None
    return click.option(name, type=kind, default=default, metavar=metavar, show_default=shown, help=words)


def jobs_option(what: str) -> Decorator:
    """-j; what : what is computed at a time, "Runs" or "Points"."""
    return click.option(
        "-j",
        "--jobs",
        type=click.IntRange(min=1),
        metavar="N",
        help=f"{what} at a time. [default: all cores]",
    )


def output_option(default: str) -> Decorator:
    """-o; default : the name of the file, in words."""
    return click.option(
        "-o", "--output", type=FILE, metavar="FILE", help=f"Output file. [default: {default}]"
    )


def spread_option(over: str) -> Decorator:
    """--spread, each key once; over : what it varies, "the ensemble" or "the starts"."""
    return click.option(
        "--spread", "spreads", metavar="KEY=HOW", multiple=True, callback=once_each, type=KEY_SPREAD,
        help=f"What varies over {over}: WIDTH (uniform, either side of the case's value), FROM:TO, or "
        "'normal DEVIATION'; repeatable. [default: the motor's phi, over the full turn]",
    )  # fmt: skip


# An option that is given twice is an error: the second one would silently take the place of the first. So is
# an empty value, such as that of an unset variable of a script: it would pass for an option not given.


def refuse_unclear(command: click.Command) -> None:
    """Let a command refuse empty values, and an option twice that is not meant to be; flags may be."""
    if getattr(command.make_parser, "refuses", False):
        return
    make = command.make_parser

    def make_parser(ctx: click.Context) -> Any:
        parser = make(ctx)
        parse = parser.parse_args

        def parse_args(args: list[str]) -> Any:
            options, rest, order = parse(args)
            for option in _repeated(order):
                name = max(option.opts, key=len)
                raise click.UsageError(f"{name} is given twice, and takes one value", ctx)
            for param in _empty(order, options):
                name = (
                    max(param.opts, key=len) if isinstance(param, click.Option) else param.make_metavar(ctx)
                )
                otherwise = "" if param.required else ", or leave it out"
                raise click.UsageError(f"{name} is empty: give it a value{otherwise}", ctx)
            return options, rest, order

        parser.parse_args = parse_args  # type: ignore[method-assign]
        return parser

    make_parser.refuses = True  # type: ignore[attr-defined]
    command.make_parser = make_parser  # type: ignore[method-assign]


def _repeated(order: list[click.Parameter]) -> list[click.Option]:
    """Options that came more than once and keep only one value; --yes/--no pairs are such."""
    return [
        option
        for option, count in Counter(order).items()
        if count > 1 and isinstance(option, click.Option) and not (option.multiple or option.count)
        if not option.is_flag or option.secondary_opts
    ]


def _empty(order: list[click.Parameter], options: Mapping[str, Any]) -> list[click.Parameter]:
    """Parameters one of whose values is an empty text."""
    given = {param: options.get(str(param.name)) for param in order}
    return [
        param
        for param, value in given.items()
        if "" in (value if isinstance(value, list | tuple) else [value])
    ]


# The examples at the end of a command's --help.


def examples(*lines: str, before: str = "") -> str:
    """An epilog: `before` as a paragraph, then the example lines as they are."""
    block = "\n".join(["\b", "Examples:", *(f"  {line}" for line in lines)])
    return f"{before}\n\n{block}" if before else block
