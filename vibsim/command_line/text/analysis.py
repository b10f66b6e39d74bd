"""Verdicts on a run in lines for people."""

from collections.abc import Callable, Iterator
from typing import TypeVar

from vibsim.analysis import Analysis, Capture, DominantFrequencies, Drift, ImpactsPerCycle, Regime
from vibsim.analysis.impacts_per_cycle import Spread
from vibsim.cases.number import number
from vibsim.command_line.terminal.printing import style
from vibsim.command_line.text.multipliers import multiplier_text
from vibsim.command_line.text.quantities import metres
from vibsim.command_line.text.summary import trust_text
from vibsim.results import Result

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
    lines += _of_each(verdicts.drift, lambda one: [("drift", drift_text(one))], "drift")
    lines += _of_each(verdicts.impacts, lambda one: impact_lines(one, verbose), "impacts")
    if verdicts.regime:
        lines += regime_lines(verdicts.regime)
    lines += _of_each(verdicts.frequencies, lambda one: list(frequency_lines(one)), "frequencies")
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


def drift_text(drift: Drift) -> str:
    """Verdict, rate of the orbit where it is known, rate in the span with its interval."""
    exact = (
        "" if drift.orbit_rate is None else f"{number(drift.orbit_rate, 4)} m/s on the periodic orbit, exact"
    )
    if drift.rate is None or drift.half_width is None:
        return f"{_verdict(drift.verdict)}: {exact or drift.reason}"
    rate = f"{number(drift.rate, 4)} +- {number(drift.half_width, 2)} m/s ({drift.reason})"
    return f"{_verdict(drift.verdict)}: {f'{exact}; in the span {rate}' if exact else rate}"


def impact_lines(impacts: ImpactsPerCycle, verbose: bool) -> list[Line]:
    """Verdict, means per cycle, speeds at impact."""
    text = f"{_verdict(impacts.verdict)}: {impacts.reason}"
    if impacts.impacts is not None:
        text = f"{_verdict(impacts.verdict)}: {impacts.impacts:.4g} per cycle, {impacts.reason}"
        text += f"; {impacts.sticks:.4g} sticks per cycle" if impacts.sticks else ""
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


def frequency_lines(frequencies: DominantFrequencies) -> Iterator[Line]:
    """The strongest lines: frequency, order of the source, amplitude."""
    if not frequencies.lines:
        verdict = _verdict(frequencies.verdict, {"still": "nothing vibrates"})
        yield "frequencies", f"{verdict}: {frequencies.reason}"
        return
    parts = [
        f"{line.hz:.4g} Hz{f' ({line.order})' if line.order else ''} {metres(line.amplitude)}"
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


def _spread(spread: Spread) -> str:
    least, greatest, mean = (number(x, 4) for x in (spread.least, spread.greatest, spread.mean))
    return f"{least} to {greatest} {spread.unit}, mean {mean} {spread.unit}"
