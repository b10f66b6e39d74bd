"""Verdicts on a run, each with the numbers and the span that it rests on.

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

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.analysis.analysis import Analysis as Analysis
    from vibsim.analysis.analysis import DominantFrequencies as DominantFrequencies
    from vibsim.analysis.analysis import analyse as analyse
    from vibsim.analysis.analysis import find_frequencies as find_frequencies
    from vibsim.analysis.capture import Capture as Capture
    from vibsim.analysis.capture import judge_capture as judge_capture
    from vibsim.analysis.comparison import Comparison as Comparison
    from vibsim.analysis.comparison import compare as compare
    from vibsim.analysis.cycles import CaptureVerdict as CaptureVerdict
    from vibsim.analysis.cycles import ComparisonVerdict as ComparisonVerdict
    from vibsim.analysis.cycles import DriftVerdict as DriftVerdict
    from vibsim.analysis.cycles import FrequenciesVerdict as FrequenciesVerdict
    from vibsim.analysis.cycles import ImpactsVerdict as ImpactsVerdict
    from vibsim.analysis.cycles import RegimeVerdict as RegimeVerdict
    from vibsim.analysis.cycles import Span as Span
    from vibsim.analysis.drift import Drift as Drift
    from vibsim.analysis.drift import ImpactsPerCycle as ImpactsPerCycle
    from vibsim.analysis.drift import count_impacts as count_impacts
    from vibsim.analysis.drift import measure_drift as measure_drift
    from vibsim.analysis.regime import Lyapunov as Lyapunov
    from vibsim.analysis.regime import Regime as Regime
    from vibsim.analysis.regime import judge_regime as judge_regime
    from vibsim.analysis.regime import largest_exponent as largest_exponent
    from vibsim.analysis.regime import lyapunov as lyapunov
    from vibsim.analysis.sections import Exponent as Exponent

__getattr__, __dir__, __all__ = lazy_names(__name__)
