"""A bench as a table for people."""

import json
from collections.abc import Iterable, Iterator
from itertools import groupby
from math import isfinite
from pathlib import Path

from vibsim.cases.number import number
from vibsim.command_line.terminal.printing import say, style
from vibsim.command_line.text.quantities import seconds, size
from vibsim.command_line.text.summary import heading, print_lines
from vibsim.evidence.benchmark.bench_result import BenchResult
from vibsim.evidence.benchmark.description import refusals
from vibsim.evidence.benchmark.families import family_of
from vibsim.evidence.benchmark.row import FAILED, SLOWER, Row
from vibsim.evidence.benchmark.verdicts import (
    beside_reference,
    fastest,
    impacts_per_second,
    most_accurate,
    reference,
)
from vibsim.evidence.peers.attempt import CONTACTS

SETTING = 22
NOTHING = "-"
SETUP = 0.05  # s before the first run that are worth a word


def print_bench(
    bench: BenchResult,
    path: str | Path | None,
    took: float | None = None,
    more: Iterable[tuple[str, str]] = (),
) -> None:
    """Print what was measured, the table, what it says, and more lines."""
    say(heading(bench.attrs["case_name"], bench.attrs["title"]))
    print_lines(head_lines(bench))
    say()
    for line in table_lines(bench):
        say(line)
    say()
    file = [("file", _file_text(path, took))] if path else []
    print_lines([*verdict_lines(bench), *more, *file])


def head_lines(bench: BenchResult) -> list[tuple[str, str]]:
    """Case, truth and machine, as labelled lines."""
    attrs, time = bench.attrs, bench["time"]
    truth = f"{attrs['truth_digits']} digits carried, {attrs['truth_digits_right']} right at the end"
    versions = [
        f"{name} {attrs[f'{name.lower()}_version']}" for name in ("Python", "numpy", "scipy", "heyoka")
    ]
    lines = [
        ("span", f"{seconds(float(time[-1]))}, compared at {len(time)} instants"),
        ("truth", f"{truth}; {attrs['truth_library']}, {attrs['truth_wall_time_s']:.3g} s"),
        ("times", "milliseconds per second of motion, medians; impacts per second of computing"),
        ("faithful", f"errors within {number(1e3 * bench.faithful_error, 3)} mm"),
        ("machine", f"{attrs['processor']}, {attrs['cores']} cores; {attrs['platform']}"),
        ("versions", f"vibsim {attrs['vibsim_version']}, {', '.join(versions)}"),
    ]
    return lines if bench.complete else [*lines, ("incomplete", style("stopped early", fg="yellow"))]


def table_lines(bench: BenchResult) -> Iterator[str]:
    """The table, one group of rows per family."""
    yield from _header(bench)
    for method, rows in groupby(bench.rows, key=lambda row: row.method):
        group = list(rows)
        yield style(family_of(method).label, bold=True) + style(_note(group), dim=True)
        yield from (_row_text(bench, row) for row in group)
    for name in json.loads(bench.attrs["not_installed"]):
        family = family_of(name)
        yield style(family.label, bold=True) + f"  {family.remedy}"
    for name, sentence in refusals(bench).items():
        yield style(family_of(name).label, bold=True) + f"  {sentence}"


def _note(group: list[Row]) -> str:
    """What holds for all rows of a family and not for others."""
    setup = max((row.setup_time for row in group if row.runs), default=0.0)
    if setup > SETUP:
        return f"  (compiled beforehand in {setup:.2f} s at most)"
    contacts = any(set(row.events) == set(CONTACTS) for row in group)
    return "  (contacts only, read off its steps)" if contacts else ""


def _header(bench: BenchResult) -> list[str]:
    times = [f"{t:g} s" for t in bench.check_times]
    errors = "".join(f"{t:>9}" for t in times)
    return [
        f"{'':{SETTING + 2}}{'time':>9}{'CPU':>9}{'impacts':>10}{'':>9}{'right-':>12}"
        f"{'largest error [m] until':>{9 * len(times)}}{'faithful':>10}{'events until then':>21}",
        f"{'':{SETTING + 2}}{'ms/s':>9}{'ms/s':>9}{'per s':>10}{'steps':>9}{'hand sides':>12}"
        f"{errors}{'until':>10}{'found':>7}{'missed':>7}{'extra':>7}",
    ]


def _row_text(bench: BenchResult, row: Row) -> str:
    if row.status == FAILED:
        return f"  {row.setting:{SETTING}}" + style(f"  failed: {row.problem}", fg="red")
    count = row.counted()
    events = [NOTHING] * 3 if count is None else [str(n) for n in vars(count).values()]
    errors = [_error_text(row.error_until(bench["time"], t)) for t in bench.check_times]
    cells = [
        f"{_time_text(bench, row, row.wall_time):>9}{_time_text(bench, row, row.cpu_time):>9}",
        f"{_rate_text(impacts_per_second(bench, row)):>10}",
        f"{_count_text(row.steps):>9}{_count_text(row.evaluations):>12}",
        "".join(f"{text:>9}" for text in errors),
        f"{f'{row.faithful_time:.4g} s':>10}",
        "".join(f"{text:>7}" for text in events),
    ]
    return f"  {row.setting:{SETTING}}" + "".join(cells) + _remark(bench, row)


def _time_text(bench: BenchResult, row: Row, took: float) -> str:
    """Milliseconds per second of motion; of a row that was stopped, what the whole span takes at least."""
    if row.status == SLOWER:
        return "> " + _short(1e3 * took / float(bench["time"][-1]))
    return _short(1e3 * took / row.t_reached)


def _remark(bench: BenchResult, row: Row) -> str:
    best = [
        word
        for word, best in (("fastest", fastest(bench)), ("most accurate", most_accurate(bench)))
        if row is best
    ]
    text = style(f"  {', '.join(best)}", fg="green", bold=True) if best else ""
    if row.status == SLOWER:
        text += style(f"  stopped at {row.t_reached:.4g} s", fg="yellow")
    return text


def verdict_lines(bench: BenchResult) -> list[tuple[str, str]]:
    """vibsim's own row, and the most accurate row of every peer beside it."""
    ours = reference(bench)
    if ours is None:
        return []
    t = bench.telling_time
    error = _error_text(ours.error_until(bench["time"], t))
    numbers = f"{_short(1e3 * ours.time_per_second)} ms per second of motion, error {error} m until {t:g} s"
    lines = [
        ("vibsim", f"{family_of(ours.method).label.removeprefix('vibsim, ')}, {ours.setting}: {numbers}")
    ]
    for i, each in enumerate(beside_reference(bench)):
        text = f"{family_of(each.row.method).label}, {each.row.setting}"
        ratio = f"{_ratio(each.times)} x the time, {_ratio(each.errors)} x the error"
        lines.append(("" if i else "beside it", f"{text:<46}{ratio}"))
    return lines


def _ratio(x: float) -> str:
    return number(x, 2) if x < 100 or x >= 1e5 else f"{float(f'{x:.2g}'):.0f}"


def _short(x: float) -> str:
    """Three digits without an exponent: 0.0512, 12.3, 2036."""
    return number(x, 3) if x < 1000 else f"{x:.0f}"


def _error_text(x: float) -> str:
    return number(x, 2) if isfinite(x) else NOTHING


def _rate_text(rate: float | None) -> str:
    return NOTHING if rate is None else _short(float(f"{rate:.3g}"))


def _count_text(n: int) -> str:
    return NOTHING if n < 0 else str(n)


def _file_text(path: str | Path, took: float | None) -> str:
    return f"{path} ({size(path)})" + ("" if took is None else f", {took:.1f} s")
