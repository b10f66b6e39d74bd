"""All checks, in the order of validation: V1 to V21, then the hard cases."""

from functools import cache

from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.friction import coulomb_friction, friction_oscillator, stick_slip
from vibsim.evidence.verification.hard import (
    hard_cases,
    hard_closed_forms,
    million_seconds,
    paper_cases,
    reported_failures,
    spool,
)
from vibsim.evidence.verification.impacts import (
    bouncing_ball,
    impact_multipliers,
    impact_orbits,
    impact_oscillators,
    several_impacts,
)
from vibsim.evidence.verification.laws import (
    energy_ledger,
    mirror_symmetry,
    momentum_ledger,
    monodromy,
    motor_run_up,
)
from vibsim.evidence.verification.vibrations import bilinear_cycle, free_vibration, linear_theory

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
