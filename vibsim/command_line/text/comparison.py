"""A comparison of two runs in lines for people."""

from collections.abc import Sequence

from vibsim.analysis.block_averages import Average
from vibsim.analysis.comparison import WORDS, ComparedStatistic, Comparison
from vibsim.cases.number import number
from vibsim.command_line.terminal.printing import style
from vibsim.results import Result

COLORS = {"identical": "green", "agree": "green", "differ": "red"}


def comparison_lines(
    runs: Sequence[Result], paths: Sequence[str], comparison: Comparison
) -> list[tuple[str, str]]:
    """Label and text: both runs, what differs of them, until when they agree, statistics, verdict."""
    lines = [(label, _run_text(run, path)) for label, run, path in zip("AB", runs, paths, strict=True)]
    for row, difference in enumerate(comparison.differences):
        lines.append(("" if row else "differences", f"{difference.key}: {difference.a}  |  {difference.b}"))
    if comparison.verdict != "identical":
        lines.append(("agreement", _agreement_text(comparison)))
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


def _agreement_text(comparison: Comparison) -> str:
    within = f"within {number(comparison.tolerance, 2)} m"
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
