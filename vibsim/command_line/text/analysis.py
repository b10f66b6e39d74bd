"""Verdicts on a run in lines for people."""

from collections.abc import Callable, Iterator
from typing import TypeVar

from vibsim.analysis import Analysis, Capture, DominantFrequencies, Drift, ImpactsPerCycle, Regime
from vibsim.analysis.impacts_per_cycle import Spread
from vibsim.command_line.terminal.printing import style
from vibsim.command_line.text.multipliers import multiplier_text
from vibsim.command_line.text.quantities import metres
from vibsim.command_line.text.summary import short, trust_text
from vibsim.results import Result

COLORS = {"undecided": "yellow", "captured": "green", "chaotic": "magenta"}
CAPTURE_WORDS = {"escaped": "captured, then escaped", "not met": "met no resonance"}
SHOWN = 4  # frequencies

MOST_NAMED = 12  # bodies or parts with verdicts of their own

Line = tuple[str, str]
T = TypeVar("T")


def analysis_lines(source: str, result: Result, found: Analysis, verbose: bool = False) -> list[Line]:
    """Label and text of every verdict that there is; with `verbose`, of all that it rests on."""
    lines = [("run", f"{source}, {_span(found.span.window)}{_trust(result)}")]
    if any((found.drift, found.impacts, found.regime, found.frequencies)):
        lines.append(("judged", _span(found.steady.window) + _trusted(found.steady.trusted)))
    if found.capture:
        lines += capture_lines(found.capture, verbose)
    lines += _of_each(found.drift, lambda one: [("drift", drift_text(one))], "drift")
    lines += _of_each(found.impacts, lambda one: impact_lines(one, verbose), "impacts")
    if found.regime:
        lines += regime_lines(found.regime)
    lines += _of_each(found.frequencies, lambda one: list(frequency_lines(one)), "frequencies")
    return lines


def _of_each(found: T | dict[str, T] | None, lines: Callable[[T], list[Line]], label: str) -> list[Line]:
    """The lines of a verdict; of several verdicts those of the first MOST_NAMED, each behind its name."""
    if found is None:
        return []
    if not isinstance(found, dict):
        return lines(found)
    blocks = []
    for name, one in list(found.items())[:MOST_NAMED]:
        (_, first), *others = lines(one)
        blocks += [("", f"{name}: {first}")]
        blocks += [("", f"  {word} {text}" if word else f"  {text}") for word, text in others]
    more = len(found) - MOST_NAMED
    blocks += [("", f"and {more} more, all of them with --json")] if more > 0 else []
    return [(label, blocks[0][1]), *blocks[1:]]


def capture_lines(found: Capture, verbose: bool) -> list[Line]:
    """Verdict, the hold that decides it, and when resonances were passed."""
    first, *others = found.reason.split("; ")
    lines = [("capture", f"{_verdict(found.verdict, CAPTURE_WORDS)}: {first}")]
    if found.since is not None:
        to = "" if found.until is None else f" to {found.until:.4g}"
        near = f", near {found.resonance.name} {found.resonance.hz:.4g} Hz" if found.resonance else ""
        lines.append(("", f"at {found.speed_hz:.4g} Hz from {found.since:.4g}{to} s{near}"))
    lines += [("", other) for other in others]
    if verbose:
        for hold in found.holds:
            held = f"held {_span((hold.begin, hold.end))} at {hold.speed_hz:.4g} Hz"
            lines.append(("", f"{held}, {hold.delay:.3g} times a free run-up, {hold.absorbed:.1%} absorbed"))
    if found.passages:
        parts = [
            f"{one.resonance.name} {one.resonance.hz:.4g} Hz at {one.time:.4g} s" for one in found.passages
        ]
        lines.append(("", f"passed {', '.join(parts)}"))
    return lines


def drift_text(found: Drift) -> str:
    """Verdict, rate and interval."""
    if found.rate is None or found.half_width is None:
        return f"{_verdict(found.verdict)}: {found.reason}"
    return (
        f"{_verdict(found.verdict)}: {_number(found.rate)} +- {short(found.half_width)} m/s ({found.reason})"
    )


def impact_lines(found: ImpactsPerCycle, verbose: bool) -> list[Line]:
    """Verdict, means per cycle, speeds at impact."""
    text = f"{_verdict(found.verdict)}: {found.reason}"
    if found.impacts is not None:
        text = f"{_verdict(found.verdict)}: {found.impacts:.4g} per cycle, {found.reason}"
        text += f"; {found.sticks:.4g} sticks per cycle" if found.sticks else ""
    elif found.sticks is not None:
        text = f"{_verdict(found.verdict)}: {found.sticks:.4g} per cycle, {found.reason}"
    lines = [("impacts", text)]
    if found.velocity:
        lines.append(("", f"at {_spread(found.velocity)}"))
    if verbose and found.words:
        words = ", ".join(f"{word or '-'} {count}" for word, count in found.words.items())
        lines.append(("words", f"{words}; {found.distinct_words} in all"))
    return lines


def regime_lines(found: Regime) -> list[Line]:
    """Verdict, period, evidence."""
    text = _verdict(found.verdict)
    if found.verdict == "periodic":
        text += f", period {found.period}" + ("" if found.since is None else f", since {found.since:.4g} s")
    elif found.verdict == "transient" and found.period is not None:
        text += f" towards period {found.period}"
    lines = [("regime", f"{text}: {found.reason}")]
    if found.multipliers is not None and found.exponents is not None:
        shown = ", ".join(multiplier_text(complex(*pair)) for pair in found.multipliers if pair[1] >= 0)
        lines.append(("", f"multipliers {shown}"))
        rates = ("-inf" if value is None else f"{value:.4g}" for value in found.exponents)
        lines.append(("", f"exponents {', '.join(rates)} 1/s"))
    if found.exponent and found.verdict != "periodic":
        value, half_width = found.exponent.value, found.exponent.half_width
        lines.append(("", f"largest Lyapunov exponent {value:.3g} +- {short(half_width)} 1/s"))
    return lines


def frequency_lines(found: DominantFrequencies) -> Iterator[Line]:
    """The strongest lines: frequency, order of the source, amplitude."""
    if not found.lines:
        yield "frequencies", f"{_verdict(found.verdict, {'still': 'nothing vibrates'})}: {found.reason}"
        return
    parts = [
        f"{line.hz:.4g} Hz{f' ({line.order})' if line.order else ''} {metres(line.amplitude)}"
        for line in found.lines[:SHOWN]
    ]
    yield "frequencies", ", ".join(parts)
    orders = " (orders in brackets)" if any(line.order for line in found.lines[:SHOWN]) else ""
    source = f"source {found.source_hz:.4g} Hz{orders}, " if found.source_hz else ""
    yield "", f"{source}resolution {short(found.resolution_hz or 0.0)} Hz"


def _number(x: float) -> str:
    return f"{x:.4g}".replace("e-0", "e-")


def _verdict(word: str, words: dict[str, str] | None = None) -> str:
    return style((words or {}).get(word, word), fg=COLORS.get(word), bold=True)


def _span(window: tuple[float, float]) -> str:
    return f"{window[0]:.4g} to {window[1]:.4g} s"


def _trust(result: Result) -> str:
    return "" if result.trust_horizon is None else f", {trust_text(result)}"


def _trusted(trusted: bool | None) -> str:
    """Beyond the trust horizon, verdicts hold for a motion of the same statistics, not for this very one."""
    return ", which ends beyond the trust horizon" if trusted is False else ""


def _spread(found: Spread) -> str:
    return f"{found.least:.4g} to {found.greatest:.4g} {found.unit}, mean {found.mean:.4g} {found.unit}"
