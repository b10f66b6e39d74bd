"""All checks, in the order of validation: V1 to V11, then the hard cases."""

from functools import cache
from importlib import import_module

from vibsim.evidence.verification.check import Check

MODULES = (
    "paper_cases",
    "free_vibration",
    "linear_theory",
    "coulomb_friction",
    "mirror_symmetry",
    "motor_run_up",
    "monodromy",
    "energy_ledger",
    "hard_cases",
    "million_seconds",
    "hard_closed_forms",
)


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every module."""
    found = [import_module(f"vibsim.evidence.verification.{name}").checks() for name in MODULES]
    return tuple(check for checks in found for check in checks)
