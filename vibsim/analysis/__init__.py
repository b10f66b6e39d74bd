"""What a run tells: verdicts on it, each with the numbers and the span that it rests on.

    judge_capture(result)       was the motor captured, since when, until when, at which speed
    measure_drift(result)       how fast the blocks drift, with an interval
    count_impacts(result)       impacts, sticks and event words per cycle of the source
    judge_regime(result)        periodic, quasi-periodic, chaotic, or less settled
    largest_exponent(result)    largest Lyapunov exponent, for judge_regime(result, exponent=...)
    lyapunov(case)              Lyapunov exponents, with intervals and warnings
    find_frequencies(result)    dominant frequencies of a displacement
    analyse(result)             all of these
    compare(a, b, tolerance)    are two runs the same

Names are imported when they are used: scipy takes longer to import than most runs take to run.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.analysis.analysis import Analysis, analyse
    from vibsim.analysis.capture import Capture, judge_capture
    from vibsim.analysis.comparison import Comparison, compare
    from vibsim.analysis.dominant_frequencies import DominantFrequencies, find_frequencies
    from vibsim.analysis.drift import Drift, measure_drift
    from vibsim.analysis.exponents import Lyapunov, lyapunov
    from vibsim.analysis.impacts_per_cycle import ImpactsPerCycle, count_impacts
    from vibsim.analysis.regime.largest_exponent import largest_exponent
    from vibsim.analysis.regime.points import Exponent
    from vibsim.analysis.regime.verdict import Regime, judge_regime
    from vibsim.analysis.span import Span

_HOMES = {
    "Analysis": "analysis",
    "analyse": "analysis",
    "Capture": "capture",
    "judge_capture": "capture",
    "Comparison": "comparison",
    "compare": "comparison",
    "DominantFrequencies": "dominant_frequencies",
    "find_frequencies": "dominant_frequencies",
    "Drift": "drift",
    "measure_drift": "drift",
    "Exponent": "regime.points",
    "largest_exponent": "regime.largest_exponent",
    "ImpactsPerCycle": "impacts_per_cycle",
    "count_impacts": "impacts_per_cycle",
    "Lyapunov": "exponents",
    "lyapunov": "exponents",
    "Regime": "regime.verdict",
    "judge_regime": "regime.verdict",
    "Span": "span",
}

__all__ = [
    "Analysis",
    "Capture",
    "Comparison",
    "DominantFrequencies",
    "Drift",
    "Exponent",
    "ImpactsPerCycle",
    "Lyapunov",
    "Regime",
    "Span",
    "analyse",
    "compare",
    "count_impacts",
    "find_frequencies",
    "judge_capture",
    "judge_regime",
    "largest_exponent",
    "lyapunov",
    "measure_drift",
]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"vibsim.analysis.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})
