"""vibsim: vibro-impact systems with dry friction under ideal and limited-power excitation.

    import vibsim

    case = vibsim.load_case("II-B", {"excitation.Omega0": "6.5 Hz"})
    result = vibsim.simulate(case)
    result["x2"], result.events["t"], result.at(12.3456)
    result.save("II-B.h5")
    vibsim.open_result("II-B.h5")
    vibsim.analyse(result).capture.verdict
    vibsim.lyapunov(case).exponents

    sweep = vibsim.sweep("II-B", {"excitation.Omega0": "3:7:0.05 Hz"}, out="sommerfeld.h5")
    sweep["omega0"], sweep["mean_speed"]

Names are imported when they are used, so `import vibsim` costs next to nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.analysis import Analysis, Lyapunov, analyse, lyapunov
    from vibsim.cases import Case, CaseError, load_case
    from vibsim.fitting import FitResult, fit
    from vibsim.opening import open_result
    from vibsim.results import Result, ResultFileError, simulate
    from vibsim.sweeps import SweepResult, join, sweep

__version__ = "0.1.0"

_HOMES = {
    "Analysis": "vibsim.analysis",
    "Lyapunov": "vibsim.analysis",
    "analyse": "vibsim.analysis",
    "lyapunov": "vibsim.analysis",
    "Case": "vibsim.cases",
    "CaseError": "vibsim.cases",
    "load_case": "vibsim.cases",
    "FitResult": "vibsim.fitting",
    "fit": "vibsim.fitting",
    "Result": "vibsim.results",
    "ResultFileError": "vibsim.results",
    "open_result": "vibsim.opening",
    "simulate": "vibsim.results",
    "SweepResult": "vibsim.sweeps",
    "join": "vibsim.sweeps",
    "sweep": "vibsim.sweeps",
}

__all__ = [
    "Analysis",
    "Case",
    "CaseError",
    "FitResult",
    "Lyapunov",
    "Result",
    "ResultFileError",
    "SweepResult",
    "__version__",
    "analyse",
    "fit",
    "join",
    "load_case",
    "lyapunov",
    "open_result",
    "simulate",
    "sweep",
]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(__all__)
