"""Verification: known cases and hard ones, computed afresh and held against what they should be.

    for row in verify(["V3", "hard"]):
        print(row.name, row.expected, row.obtained, row.error, row.bound, row.passed)

Expected values are closed forms, published figures, conservation laws and stored runs of 40 digits; bounds
follow from rounding and from the conditioning of each motion. Needs nothing but the installed package.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.evidence.verification.row import Point, Row
    from vibsim.evidence.verification.selection import UnknownCheckError
    from vibsim.evidence.verification.verifying import verify

_HOMES = {
    "Point": "vibsim.evidence.verification.row",
    "Row": "vibsim.evidence.verification.row",
    "UnknownCheckError": "vibsim.evidence.verification.selection",
    "verify": "vibsim.evidence.verification.verifying",
}

__all__ = ["Point", "Row", "UnknownCheckError", "verify"]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
