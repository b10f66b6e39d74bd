"""Judge the files and cases of `vibsim analyse` one by one."""

from dataclasses import asdict
from typing import Any

import click

from vibsim.analysis import Analysis, analyse
from vibsim.command_line.jobs.run_plan import read_case
from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.text.analysis import analysis_lines
from vibsim.command_line.text.summary import heading, print_lines
from vibsim.opening import open_result
from vibsim.results import Result, ResultFileError, kind_of, names_a_result, simulate
from vibsim.results.windows import Window


def judge_all(
    sources: tuple[str, ...],
    what: tuple[str, ...],
    window: Window | None,
    discard: str | None,
    exponent: bool,
    changes: dict[str, str],
    settings: Settings,
) -> None:
    """Print the verdicts on each source; with `changes`, files are run again with them.

    Raises CaseError and ResultFileError before anything is judged, UsageError for a window or transient that
    a run cannot have.
    """
    transient = _transient(discard)
    opened = [_opened(source, changes) for source in sources]
    for source, ready in zip(sources, opened, strict=True):
        result = ready if isinstance(ready, Result) else simulate(ready)
        try:
            left_out = None if transient is None else transient.time(_length(result, window))
            verdicts = analyse(result, window, left_out, what, exponent)
        except ValueError as error:
            raise click.UsageError(f"{source}: {error}") from error
        _print(source, changes, result, verdicts, settings)


def _transient(text: str | None) -> Any:
    from vibsim.analysis.discard import parse_discard

    try:
        return None if text is None else parse_discard(text)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="'--discard'") from error


def _length(result: Result, window: Window | None) -> float:
    begin, end = window or (0.0, result.t_reached)
    return max(0.0, min(end, result.t_reached) - begin)


def _opened(source: str, changes: dict[str, str]) -> Any:
    """The run in a file, or the case that is to be run."""
    if changes or not names_a_result(source):
        return read_case(source, changes)
    if kind_of(source) != "trajectory":
        raise ResultFileError(f"{source}: holds no single run; analyse takes runs and cases")
    return open_result(source)


def _print(
    source: str, changes: dict[str, str], result: Result, verdicts: Analysis, settings: Settings
) -> None:
    if settings.json:
        print_json({"file": source, **({"changes": changes} if changes else {}), **asdict(verdicts)})
    elif not settings.quiet:
        say(heading(result.case.name, result.case.title))
        print_lines(analysis_lines(_judged(source, changes), result, verdicts, settings.verbose))


def _judged(source: str, changes: dict[str, str]) -> str:
    """What was judged, in words: a file, a case, or what came of either with changes."""
    if not changes:
        return source
    changed = ", ".join(f"{key}={value}" for key, value in changes.items())
    return f"{source} run with {changed}, not saved"
