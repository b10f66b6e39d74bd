"""vibsim analyse: verdicts on runs."""

from typing import Any

import click
from click.shell_completion import CompletionItem

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import CASE, WINDOW, set_option

VERDICTS = ("capture", "drift", "impacts", "regime", "frequencies")


class Verdicts(click.ParamType):
    """Names of verdicts, separated by commas."""

    name = "verdicts"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        if isinstance(value, tuple):
            return value
        names = tuple(name.strip() for name in value.split(",") if name.strip())
        for name in names or (value,):
            if name not in VERDICTS:
                self.fail(f"{name!r}{_hint(name)}", param, ctx)
        return names

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        done, comma, begun = incomplete.rpartition(",")
        return [CompletionItem(done + comma + name) for name in VERDICTS if name.startswith(begun)]


def _hint(name: str) -> str:
    from vibsim.cases.spelling import nearest

    near = nearest(name, VERDICTS)
    return f": did you mean {near}?" if near else f"; allowed: {', '.join(VERDICTS)}"


@click.command(
    "analyse",
    short_help="Judge runs: capture, drift, impacts, regime, frequencies.",
    epilog=examples(
        "vibsim analyse II-B.h5",
        "vibsim analyse runs/*.h5 --what capture,regime",
        "vibsim analyse II-B -s c='0.03 N s/m'         # runs the case first",
        "vibsim analyse I-C.h5 --window 100:300 --discard 50s",
        "vibsim analyse II-C.h5 --json | jq .capture.verdict",
        before="Every verdict says what it rests on. Where that is too little or against itself, the verdict "
        "is undecided, and the reason is given.",
    ),
)
@click.argument("sources", metavar="FILE...", nargs=-1, required=True, type=CASE)
@click.option(
    "--what",
    type=Verdicts(),
    default=",".join(VERDICTS),
    metavar="NAME[,NAME..]",
    help=f"What to judge: {', '.join(VERDICTS)}. [default: all]",
)
@click.option("--window", type=WINDOW, metavar="A:B", help="Look only at this span, in seconds.")
@click.option(
    "--discard",
    metavar="TIME|SHARE",
    help="Transient that only capture takes in, such as 100s or 0.5. [default: 0.5; 0 with --window]",
)
@click.option(
    "--exponent/--no-exponent",
    default=True,
    help="Run the case again for its largest Lyapunov exponent. [default: exponent]",
)
@set_option
@click.pass_context
def command(
    ctx: click.Context,
    sources: tuple[str, ...],
    what: tuple[str, ...],
    window: tuple[float, float] | None,
    discard: str | None,
    exponent: bool,
    changes: tuple[tuple[str, str], ...],
) -> None:
    """Judge each FILE: an HDF5 file of `vibsim run`, or a case, which is run first.

    Capture: was the motor captured by the vibration, since when, until when, and at which speed. Drift: its
    rate. Impacts: impacts and sticks per cycle of the source. Regime: periodic, quasi-periodic, chaotic,
    or less settled. Frequencies: the strongest ones of the
    relative displacement.
    """
    from vibsim.command_line.jobs.analysis import judge_all

    judge_all(sources, what, window, discard, exponent, dict(changes), ctx.obj)
