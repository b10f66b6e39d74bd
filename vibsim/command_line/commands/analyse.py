"""vibsim analyse: verdicts on runs."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from typing import Any, TypeVar

import click

from vibsim.analysis import Analysis, Capture, DominantFrequencies, Drift, ImpactsPerCycle, Regime, analyse
from vibsim.analysis.analysis import unit_of_motion
from vibsim.analysis.cycles import Discard
from vibsim.analysis.drift import RateSpread
from vibsim.cases.problems import counted, nearest
from vibsim.cases.quantities import number
from vibsim.command_line.commands.run import read_case
from vibsim.command_line.options import CASE, DISCARD, WINDOW, NameList, Settings, examples, set_option
from vibsim.command_line.terminal import print_json, say, style
from vibsim.command_line.text import heading, metres, multiplier_text, print_lines, trust_text
from vibsim.results import Result, ResultFileError, kind_of, names_a_result, simulate
from vibsim.results.result import Window
from vibsim.results.simulation import open_result

VERDICTS = ("capture", "drift", "impacts", "regime", "frequencies")
LACKING = {  # why there is no verdict that was asked for by its name
    "capture": "none: the case has no motor",
    "drift": "none: no body is free to drift",
    "impacts": "none: the case has no stop",
}


def _check_verdicts(names: Sequence[str], text: str) -> None:
    """Raises ValueError for the first that is no verdict."""
    for name in names or (text,):
        if name not in VERDICTS:
            near = nearest(name, VERDICTS)
            hint = f": did you mean {near}?" if near else f"; allowed: {', '.join(VERDICTS)}"
            raise ValueError(f"{name!r}{hint}")


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
    type=NameList("verdicts", VERDICTS, _check_verdicts),
    default=",".join(VERDICTS),
    metavar="NAME[,NAME..]",
    help=f"What to judge: {', '.join(VERDICTS)}. [default: all]",
)
@click.option("--window", type=WINDOW, metavar="A:B", help="Look only at this span, in seconds.")
@click.option(
    "--discard",
    type=DISCARD,
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
    discard: Discard | None,
    exponent: bool,
    changes: tuple[tuple[str, str], ...],
) -> None:
    """Judge each FILE: an HDF5 file of `vibsim run`, or a case, which is run first.

    Capture: was the motor captured by the vibration, since when, until when, and at which speed. Drift: its
    rate. Impacts: impacts and sticks per cycle of the source. Regime: periodic, quasi-periodic, chaotic,
    or less settled. Frequencies: the strongest ones of the
    relative displacement.
    """

    judge_all(sources, what, window, discard, exponent, dict(changes), ctx.obj)


# Judge the files and cases of `vibsim analyse` one by one.


def judge_all(
    sources: tuple[str, ...],
    what: tuple[str, ...],
    window: Window | None,
    discard: Discard | None,
    exponent: bool,
    changes: dict[str, str],
    settings: Settings,
) -> None:
    """Print the verdicts on each source; with `changes`, files are run again with them.

    Raises CaseError and ResultFileError before anything is judged, UsageError for a window or transient that
    a run cannot have.
    """
    opened = [_opened(source, changes) for source in sources]
    for source, ready in zip(sources, opened, strict=True):
        result = ready if isinstance(ready, Result) else simulate(ready)
        try:
            left_out = None if discard is None else discard.time(_length(result, window))
            verdicts = analyse(result, window=window, discard=left_out, what=what, exponent=exponent)
        except ValueError as error:
            raise click.UsageError(f"{source}: {error}") from error
        _print(source, changes, result, verdicts, what, settings)


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
    source: str,
    changes: dict[str, str],
    result: Result,
    verdicts: Analysis,
    what: tuple[str, ...],
    settings: Settings,
) -> None:
    if settings.json:
        print_json({"file": source, **({"changes": changes} if changes else {}), **asdict(verdicts)})
    elif not settings.quiet:
        say(heading(result.case.name, result.case.title))
        lines = analysis_lines(_judged(source, changes), result, verdicts, settings.verbose)
        asked = () if set(what) == set(VERDICTS) else what
        print_lines([*lines, *((name, LACKING[name]) for name in asked if getattr(verdicts, name) is None)])


def _judged(source: str, changes: dict[str, str]) -> str:
    """Subject of the verdicts, in words: a file, a case, or either with changes."""
    if not changes:
        return source
    changed = ", ".join(f"{key}={value}" for key, value in changes.items())
    return f"{source} run with {changed}, not saved"


# Verdicts on a run in lines for people.


COLORS = {"undecided": "yellow", "captured": "green", "chaotic": "magenta"}
CAPTURE_WORDS = {"escaped": "captured, then escaped", "not met": "met no resonance"}
SHOWN = 4  # frequencies

MOST_NAMED = 12  # bodies or parts with verdicts of their own

Line = tuple[str, str]
T = TypeVar("T")


def analysis_lines(source: str, result: Result, verdicts: Analysis, verbose: bool = False) -> list[Line]:
    """Label and text of every verdict that there is; with `verbose`, of all that it rests on."""
    lines = [("run", f"{source}, {_span(verdicts.span.window)}{_trust(result)}")]
    if any((verdicts.drift, verdicts.impacts, verdicts.regime, verdicts.frequencies)):
        lines.append(("judged", _span(verdicts.steady.window) + _trusted(verdicts.steady.trusted)))
    if verdicts.capture:
        lines += capture_lines(verdicts.capture, verbose)
    scene = result.case.scene()
    units = {body.columns[0]: scene.unit_of(body) for body in scene.line}
    lines += _of_each(
        verdicts.drift,
        lambda one: [("drift", drift_text(one, units.get(one.of, scene.length_unit)))],
        "drift",
    )
    lines += _of_each(verdicts.impacts, lambda one: impact_lines(one, verbose), "impacts")
    if verdicts.regime:
        lines += regime_lines(verdicts.regime)
    lines += _of_each(
        verdicts.frequencies,
        lambda one: list(frequency_lines(one, unit_of_motion(scene, one.of))),
        "frequencies",
    )
    return lines


def _of_each(verdicts: T | dict[str, T] | None, lines: Callable[[T], list[Line]], label: str) -> list[Line]:
    """The lines of a verdict; of several verdicts those of the first MOST_NAMED, each behind its name."""
    if verdicts is None:
        return []
    if not isinstance(verdicts, dict):
        return lines(verdicts)
    blocks = []
    for name, one in list(verdicts.items())[:MOST_NAMED]:
        (_, first), *others = lines(one)
        blocks += [("", f"{name}: {first}")]
        blocks += [("", f"  {word} {text}" if word else f"  {text}") for word, text in others]
    more = len(verdicts) - MOST_NAMED
    blocks += [("", f"and {more} more, all of them with --json")] if more > 0 else []
    return [(label, blocks[0][1]), *blocks[1:]]


def capture_lines(capture: Capture, verbose: bool) -> list[Line]:
    """Verdict, the hold that decides it, and when resonances were passed."""
    first, *others = capture.reason.split("; ")
    lines = [("capture", f"{_verdict(capture.verdict, CAPTURE_WORDS)}: {first}")]
    if capture.since is not None:
        to = "" if capture.until is None else f" to {capture.until:.4g}"
        near = f", near {capture.resonance.name} {capture.resonance.hz:.4g} Hz" if capture.resonance else ""
        lines.append(("", f"at {capture.speed_hz:.4g} Hz from {capture.since:.4g}{to} s{near}"))
    lines += [("", other) for other in others]
    if verbose:
        for hold in capture.holds:
            held = f"held {_span((hold.begin, hold.end))} at {hold.speed_hz:.4g} Hz"
            lines.append(("", f"{held}, {hold.delay:.3g} times a free run-up, {hold.absorbed:.1%} absorbed"))
    if capture.passages:
        parts = [
            f"{one.resonance.name} {one.resonance.hz:.4g} Hz at {one.time:.4g} s" for one in capture.passages
        ]
        lines.append(("", f"passed {', '.join(parts)}"))
    return lines


def drift_text(drift: Drift, unit: str) -> str:
    """Verdict, rate of the orbit where it is known, rate in the span; unit: of displacements."""
    exact = ""
    if drift.orbit_rate is not None:
        exact = f"{number(drift.orbit_rate, 4)} {unit}/s on the periodic orbit, exact"
    if drift.rate is None or drift.half_width is None:
        return f"{_verdict(drift.verdict)}: {exact or drift.reason}"
    rate = f"{number(drift.rate, 4)} +- {number(drift.half_width, 2)} {unit}/s ({drift.reason})"
    return f"{_verdict(drift.verdict)}: {f'{exact}; in the span {rate}' if exact else rate}"


def impact_lines(impacts: ImpactsPerCycle, verbose: bool) -> list[Line]:
    """Verdict, means per cycle, speeds at impact."""
    text = f"{_verdict(impacts.verdict)}: {impacts.reason}"
    if impacts.impacts is not None:
        text = f"{_verdict(impacts.verdict)}: {impacts.impacts:.4g} per cycle, {impacts.reason}"
        text += f"; {counted(f'{impacts.sticks:.4g}', 'stick phase')} per cycle" if impacts.sticks else ""
    elif impacts.sticks is not None:
        text = f"{_verdict(impacts.verdict)}: {impacts.sticks:.4g} per cycle, {impacts.reason}"
    lines = [("impacts", text)]
    if impacts.velocity:
        lines.append(("", f"at {_spread(impacts.velocity)}"))
    if verbose and impacts.words:
        words = ", ".join(f"{word or '-'} {count}" for word, count in impacts.words.items())
        lines.append(("words", f"{words}; {impacts.distinct_words} in all"))
    return lines


def regime_lines(regime: Regime) -> list[Line]:
    """Verdict, period, evidence."""
    text = _verdict(regime.verdict)
    if regime.verdict == "periodic":
        since = "" if regime.since is None else f", since {regime.since:.4g} s"
        text += f", period {regime.period}{since}"
    elif regime.verdict == "transient" and regime.period is not None:
        text += f" towards period {regime.period}"
    lines = [("regime", f"{text}: {regime.reason}")]
    if regime.multipliers is not None and regime.exponents is not None:
        shown = ", ".join(multiplier_text(complex(*pair)) for pair in regime.multipliers if pair[1] >= 0)
        lines.append(("", f"multipliers {shown}"))
        rates = ("-inf" if value is None else number(value, 4) for value in regime.exponents)
        lines.append(("", f"exponents {', '.join(rates)} 1/s"))
    if regime.exponent and regime.verdict != "periodic":
        value, half_width = regime.exponent.value, regime.exponent.half_width
        lines.append(("", f"largest Lyapunov exponent {number(value, 3)} +- {number(half_width, 2)} 1/s"))
    return lines


def frequency_lines(frequencies: DominantFrequencies, unit: str) -> Iterator[Line]:
    """The strongest lines: frequency, order of the source, amplitude; unit: of displacements."""
    if not frequencies.lines:
        verdict = _verdict(frequencies.verdict, {"still": "nothing vibrates"})
        yield "frequencies", f"{verdict}: {frequencies.reason}"
        return
    parts = [
        f"{line.hz:.4g} Hz{f' ({line.order})' if line.order else ''} {metres(line.amplitude, unit)}"
        for line in frequencies.lines[:SHOWN]
    ]
    yield "frequencies", ", ".join(parts)
    orders = " (orders in brackets)" if any(line.order for line in frequencies.lines[:SHOWN]) else ""
    source = f"source {frequencies.source_hz:.4g} Hz{orders}, " if frequencies.source_hz else ""
    yield "", f"{source}resolution {number(frequencies.resolution_hz or 0.0, 2)} Hz"


def _verdict(word: str, words: dict[str, str] | None = None) -> str:
    return style((words or {}).get(word, word), fg=COLORS.get(word), bold=True)


def _span(window: tuple[float, float]) -> str:
    return f"{window[0]:.4g} to {window[1]:.4g} s"


def _trust(result: Result) -> str:
    return "" if result.trust_horizon is None else f", {trust_text(result)}"


def _trusted(trusted: bool | None) -> str:
    """Beyond the trust horizon, verdicts hold for a motion of the same statistics, not for this very one."""
    return ", which ends beyond the trust horizon" if trusted is False else ""


def _spread(spread: RateSpread) -> str:
    least, greatest, mean = (number(x, 4) for x in (spread.least, spread.greatest, spread.mean))
    return f"{least} to {greatest} {spread.unit}, mean {mean} {spread.unit}"
