"""All checks, in the order of validation: V1 to V21, then the hard cases."""

from functools import cache

from vibsim.evidence.verification import (
    bilinear_cycle,
    bouncing_ball,
    coulomb_friction,
    energy_ledger,
    free_vibration,
    friction_oscillator,
    hard_cases,
    hard_closed_forms,
    impact_multipliers,
    impact_orbits,
    impact_oscillators,
    linear_theory,
    million_seconds,
    mirror_symmetry,
    momentum_ledger,
    monodromy,
    motor_run_up,
    paper_cases,
    reported_failures,
    several_impacts,
    spool,
    stick_slip,
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
    bilinear_cycle,
    impact_oscillators,
    impact_multipliers,
    impact_orbits,
    bouncing_ball,
    stick_slip,
    friction_oscillator,
    several_impacts,
    momentum_ledger,
    hard_cases,
    million_seconds,
    hard_closed_forms,
    reported_failures,
    spool,
)


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every module."""
    return tuple(check for module in MODULES for check in module.checks())
