"""Fits: which values of a case make it do what is said of it, judged from many starts.

    found = fit("II-B", {"J": "0.5:20 g m^2"}, ["captured until the end"], ensemble=8)
    found.best.changes, found.best.shares

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy_names import lazy_names

if TYPE_CHECKING:
    from vibsim.fitting.description import describe as describe
    from vibsim.fitting.errors import FitError as FitError
    from vibsim.fitting.fit_result import FitResult as FitResult
    from vibsim.fitting.fit_result import open_fit as open_fit
    from vibsim.fitting.fitting import fit as fit

__getattr__, __dir__, __all__ = lazy_names(
    __name__,
    {
        "vibsim.fitting.description": ["describe"],
        "vibsim.fitting.errors": ["FitError"],
        "vibsim.fitting.fit_result": ["FitResult", "open_fit"],
        "vibsim.fitting.fitting": ["fit"],
    },
)
