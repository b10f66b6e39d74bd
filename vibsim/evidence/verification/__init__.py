"""Verification: known cases and hard ones, computed afresh and held against what they should be.

    for row in verify(["V3", "hard"]):
        print(row.name, row.expected, row.obtained, row.error, row.bound, row.passed)

Expected values are closed forms, published figures, conservation laws and stored runs of 40 digits; bounds
follow from rounding and from the conditioning of each motion. Needs nothing but the installed package.
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.evidence.verification.catalogue import UnknownCheckError as UnknownCheckError
    from vibsim.evidence.verification.catalogue import verify as verify
    from vibsim.evidence.verification.checks import CheckPoint as CheckPoint
    from vibsim.evidence.verification.checks import CheckRow as CheckRow

__getattr__, __dir__, __all__ = lazy_names(__name__)
