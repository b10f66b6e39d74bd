"""vibsim compare: are two runs the same, and if not, from when on and in what?"""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import click

from vibsim.analysis.comparison import WORDS, Average, ComparedStatistic, Comparison, compare
from vibsim.cases.quantities import number
from vibsim.command_line.options import FILE, FiniteRange, examples
from vibsim.command_line.terminal import print_json, style
from vibsim.results import Result


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
    from vibsim.command_line.text import print_lines
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
    from vibsim.results import ResultFileError, kind_of
    from vibsim.results.simulation import open_result

    if kind_of(path) != "trajectory":
        raise ResultFileError(f"{path}: holds no single run; compare takes the files of two runs")
    return open_result(path)


# A comparison of two runs in lines for people.


COLORS = {"identical": "green", "agree": "green", "differ": "red"}


def comparison_lines(
    runs: Sequence[Result], paths: Sequence[str], comparison: Comparison
) -> list[tuple[str, str]]:
    """Label and text: both runs, what differs of them, until when they agree, statistics, verdict."""
    unit = runs[0].error_unit
    lines = [(label, _run_text(run, path)) for label, run, path in zip("AB", runs, paths, strict=True)]
    for row, difference in enumerate(comparison.differences):
        lines.append(("" if row else "differences", f"{difference.key}: {difference.a}  |  {difference.b}"))
    if comparison.verdict != "identical":
        lines.append(("agreement", _agreement_text(comparison, unit)))
    if comparison.statistics:
        lines.append(("statistics", f"from {comparison.statistics_from:.4g} to {comparison.span:g} s"))
    lines += [(statistic.name, _statistic_text(statistic)) for statistic in comparison.statistics]
    if comparison.verdict in ("agree_until", "differ") and not comparison.statistics:
        lines.append(("statistics", "none: what lies beyond is too short"))
    verdict = style(WORDS[comparison.verdict], fg=COLORS.get(comparison.verdict, "yellow"), bold=True)
    return [*lines, ("verdict", verdict + _reason(comparison))]


def _run_text(run: Result, path: str) -> str:
    horizon = "" if run.trust_horizon is None else f", trust horizon {run.trust_horizon:.4g} s"
    return f"{path}: {run.attrs['case_name']}, {run.t_reached:g} s{horizon}"


def _agreement_text(comparison: Comparison, unit: str) -> str:
    within = f"within {number(comparison.tolerance, 2)} {unit}"
    if comparison.verdict == "agree":
        return f"{within} to the end, {comparison.span:g} s"
    if comparison.agree_until is None:
        return f"not {within} at the start"
    return f"{within} until {comparison.agree_until:.4g} of {comparison.span:g} s"


def _statistic_text(statistic: ComparedStatistic) -> str:
    text = f"{_interval(statistic.a)}  |  {_interval(statistic.b)} {statistic.unit}"
    return text + style("  differs", fg="red") if statistic.differs else text


def _interval(value: Average) -> str:
    return f"{number(value.mean, 5)} +- {number(value.half_width, 1)}"


def _reason(comparison: Comparison) -> str:
    names = [statistic.name for statistic in comparison.statistics if statistic.differs]
    return f": {', '.join(names)}" if names else ""
