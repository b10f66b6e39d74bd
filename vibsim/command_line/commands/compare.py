"""vibsim compare: are two runs the same, and if not, from when on and in what?"""

from dataclasses import asdict
from typing import Any

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import FILE, FiniteRange
from vibsim.command_line.terminal.printing import print_json


@click.command(
    "compare",
    short_help="Compare two runs.",
    epilog=examples(
        "vibsim compare II-B.h5 again.h5",
        "vibsim compare II-B.h5 order24.h5 --tolerance 1e-9",
        "vibsim compare II-B.h5 II-C.h5 --json | jq .verdict",
        before="Statistics: means over the later half of what lies beyond the agreement, from 8 to 20 "
        "blocks, with intervals that hold for all of them together in 99 of 100 comparisons.",
    ),
)
@click.argument("a", metavar="A", type=FILE)
@click.argument("b", metavar="B", type=FILE)
@click.option(
    "--tolerance",
    type=FiniteRange(min=0),
    metavar="M",
    help="Displacements agree within it [m]. [default: trust tolerance of the cases]",
)
@click.pass_context
def command(
    ctx: click.Context,
    a: str,
    b: str,
    tolerance: float | None,
) -> None:
    """Compare the runs in the result files A and B, and give one of five verdicts.

    identical: the same bit for bit; agree: within the tolerance to the end; agree for a time: up to an
    instant, and too little is left for statistics; agree in statistics: up to an instant, and beyond
    it on the average; differ. The exit code is 0 for every verdict.
    """
    from vibsim.analysis.comparison import compare
    from vibsim.command_line.text.comparison import comparison_lines
    from vibsim.command_line.text.summary import print_lines
    from vibsim.results import ResultFileError

    ours, theirs = _run(a), _run(b)
    if tolerance is None:
        tolerance = max(run.case.number("run.trust_tolerance") for run in (ours, theirs))
    try:
        comparison = compare(ours, theirs, tolerance)
    except ValueError as error:
        raise ResultFileError(f"{a}, {b}: {error}") from error
    if ctx.obj.json:
        differs = [statistic.name for statistic in comparison.statistics if statistic.differs]
        print_json({"a": a, "b": b, **asdict(comparison), "statistics_that_differ": differs})
    elif not ctx.obj.quiet:
        print_lines(comparison_lines((ours, theirs), (a, b), comparison))


def _run(path: str) -> Any:
    from vibsim.opening import open_result
    from vibsim.results import ResultFileError, kind_of

    if kind_of(path) != "trajectory":
        raise ResultFileError(f"{path}: holds no single run; compare takes the files of two runs")
    return open_result(path)
