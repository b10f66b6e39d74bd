"""Fits: which values of a case make it do what is said of it, judged from many starts.

    found = fit("II-B", {"J": "0.5:20 g m^2"}, ["captured until the end"], ensemble=8)
    found.best.changes, found.best.shares

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.fitting.fit_result import FitResult as FitResult
    from vibsim.fitting.fit_result import describe as describe
    from vibsim.fitting.fit_result import fit as fit
    from vibsim.fitting.fit_result import open_fit as open_fit
    from vibsim.fitting.measures import FitError as FitError

__getattr__, __dir__, __all__ = lazy_names(__name__)
