"""Fits: which values of a case make it do what is said of it, judged from many starts.

    found = fit("II-B", {"J": "0.5:20 g m^2"}, ["captured until the end"], ensemble=8)
    found.best.changes, found.best.shares

Names are imported when they are used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.fitting.description import describe
    from vibsim.fitting.errors import FitError
    from vibsim.fitting.fit_result import FitResult, open_fit
    from vibsim.fitting.fitting import fit

_HOMES = {
    "FitError": "vibsim.fitting.errors",
    "FitResult": "vibsim.fitting.fit_result",
    "describe": "vibsim.fitting.description",
    "fit": "vibsim.fitting.fitting",
    "open_fit": "vibsim.fitting.fit_result",
}

__all__ = ["FitError", "FitResult", "describe", "fit", "open_fit"]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
