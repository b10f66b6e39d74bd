"""Verification: known cases and hard ones, computed afresh and held against what they should be.

    for row in verify(["V3", "hard"]):
        print(row.name, row.expected, row.obtained, row.error, row.bound, row.passed)

Expected values are closed forms, published figures, conservation laws and stored runs of 40 digits; bounds
follow from rounding and from the conditioning of each motion. Needs nothing but the installed package.
"""

from typing import TYPE_CHECKING

from vibsim.lazy_names import lazy_names

if TYPE_CHECKING:
    from vibsim.evidence.verification.row import Point as Point
    from vibsim.evidence.verification.row import Row as Row
    from vibsim.evidence.verification.selection import UnknownCheckError as UnknownCheckError
    from vibsim.evidence.verification.verifying import verify as verify

__getattr__, __dir__, __all__ = lazy_names(
    __name__,
    {
        "vibsim.evidence.verification.row": ["Point", "Row"],
        "vibsim.evidence.verification.selection": ["UnknownCheckError"],
        "vibsim.evidence.verification.verifying": ["verify"],
    },
)
