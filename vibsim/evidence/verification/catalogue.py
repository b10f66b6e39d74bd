"""All checks, in the order of validation: V1 to V11, then the hard cases."""

from functools import cache

from vibsim.evidence.verification import (
    coulomb_friction,
    energy_ledger,
    free_vibration,
    hard_cases,
    hard_closed_forms,
    linear_theory,
    million_seconds,
    mirror_symmetry,
    monodromy,
    motor_run_up,
    paper_cases,
)
from vibsim.evidence.verification.check import Check

MODULES = (
    paper_cases,
    free_vibration,
    linear_theory,
    coulomb_friction,
    mirror_symmetry,
    motor_run_up,
    monodromy,
    energy_ledger,
    hard_cases,
    million_seconds,
    hard_closed_forms,
)


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every module."""
    return tuple(check for module in MODULES for check in module.checks())
