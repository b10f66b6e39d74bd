"""vibsim plot: pictures of what result files hold."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from vibsim.command_line.options import FiniteRange, NameList, OneOf, Settings, examples
from vibsim.command_line.terminal import in_shell, print_json, print_written, say
from vibsim.plots.registry import ALIASES, KINDS, NEEDS, also_called, fitting
from vibsim.plots.subject import WIDTHS_CM, PlotError, Span, View, open_subjects, parse_size, parse_span

KIND_NAMES = NameList("kinds", [*(kind.name for kind in KINDS), *ALIASES, "all"])


class SpanOfTime(click.ParamType):
    """FIRST:LAST in seconds."""

    name = "first:last"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Span:
        try:
            return parse_span(value)
        except PlotError as error:
            self.fail(str(error), param, ctx)


class Size(click.ParamType):
    """WIDTHxHEIGHT in centimetres."""

    name = "size"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float]:
        try:
            return parse_size(value)
        except PlotError as error:
            self.fail(str(error), param, ctx)


EXAMPLES = examples(
    "vibsim plot II-B.h5",
    "vibsim plot II-B.h5 --kind relative -o II-B.pdf",
    "vibsim plot II-B.h5 II-C.h5 --kind motor-speed",
    "vibsim plot II-B.h5 --kind displacement --window 20:60 --detail 30:31",
    "vibsim plot II-B.h5 --kind all -o II-B.pdf",
    "vibsim plot II-A II-B II-C --kind motor",
    "vibsim plot hysteresis.h5 --kind sommerfeld,power --window 4:6",
    "vibsim plot map.h5 --kind capture,regime --width page",
    "vibsim plot II-B.h5 --x x1 --y v1 --window 100:120 --size 12x9 --font-size 10",
    "vibsim plot II-B.h5 --kind spectrogram",
    "vibsim plot II-B.h5 --kind relative --poincare",
    "vibsim plot sweep.h5 branch.h5 --kind bifurcation",
    "vibsim plot II-B.h5 -o II-B.html              # a page to zoom and point in, needs no network",
)


@click.command(epilog=EXAMPLES)
@click.argument("files", metavar="FILE...", nargs=-1)
@click.option(
    "--kind", "kinds", type=KIND_NAMES, metavar="KIND[,KIND..]|all", help="What to draw (see --list)."
)
@click.option(
    "--window",
    type=SpanOfTime(),
    metavar="A:B",
    help="Show only this span, in seconds; of a sweep, in the unit of its axis.",
)
@click.option(
    "--detail", type=SpanOfTime(), metavar="A:B", help="Span to enlarge in time histories, in seconds."
)
@click.option(
    "-o", "--output", "out", metavar="FILE", help="A picture, .png, .pdf or .svg; or a page, .html."
)
@click.option("--x", metavar="COLUMN", help="With --y: any two columns against each other, such as x1.")
@click.option("--y", metavar="COLUMN", help="The other; of events: events/v1.")
@click.option(
    "--poincare",
    is_flag=True,
    help="Phase portraits carry the points of the Poincare section.",
)
@click.option("--width", type=OneOf(list(WIDTHS_CM)), help="Width in a journal: 8.6 cm or 17.8 cm.")
@click.option("--size", type=Size(), metavar="WxH", help="Width and height in cm, such as 12x8.")
@click.option("--font-size", type=FiniteRange(4, 40), metavar="PT", help="Size of the text. [default: 8]")
@click.option(
    "--style", "sheet", metavar="FILE", help="A matplotlib style sheet, laid over vibsim's; none: no style."
)
@click.option("--force", is_flag=True, help="Replace pictures that exist.")
@click.option(
    "--list", "list_kinds", is_flag=True, help="List the kinds, or those that fit the files, and stop."
)
@click.pass_context
def command(
    ctx: click.Context,
    files: tuple[str, ...],
    kinds: tuple[str, ...] | None,
    window: Span | None,
    detail: Span | None,
    out: str | None,
    x: str | None,
    y: str | None,
    poincare: bool,
    width: str | None,
    size: tuple[float, float] | None,
    font_size: float | None,
    sheet: str | None,
    force: bool,
    list_kinds: bool,
) -> None:
    """Draw pictures of result files, several of them laid over each other.

    Without --kind: an overview. A page (-o FILE.html) shows one result, all of it.
    --kind stiffness and --kind motor also take case files and shipped cases.
    """
    if list_kinds:
        _list(ctx.obj, files)
        return
    if not files:
        raise click.UsageError("give at least one FILE, or --list")
    from vibsim.plots.picture import draw_files

    if size and width:
        raise click.UsageError("--size and --width say the same; choose one")
    view = View(window, detail, width, size, x, y, poincare=poincare)
    style = True if sheet is None else False if sheet == "none" else sheet
    print_written(ctx.obj, draw_files(files, kinds, view, out, force, style, font_size))


def _list(settings: Settings, files: tuple[str, ...]) -> None:
    kinds = list(KINDS)
    if files:
        kinds = fitting(open_subjects(files))
    if settings.json:
        print_json([asdict(kind) for kind in kinds])
        return
    longest = max((len(kind.name) for kind in kinds), default=0)
    for kind in kinds:
        needs = f" (needs {', '.join(NEEDS[need][0] for need in kind.needs)})" if kind.needs else ""
        others = also_called(kind)
        also = f" (also: {', '.join(others)})" if others else ""
        say(in_shell(f"{kind.name:{longest}}  {kind.summary}{needs}{also}"))
