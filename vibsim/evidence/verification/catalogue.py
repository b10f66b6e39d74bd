"""All checks, in the order of validation: V1 to V21, the hard cases, V22 to V32."""

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from math import inf

from vibsim.cases.problems import did_you_mean
from vibsim.engine.choice import engine_name
from vibsim.engine.errors import EngineError
from vibsim.evidence.verification import (
    formulas,
    friction,
    hard_cases,
    impact_orbits,
    impact_oscillators,
    laws,
    paper_cases,
    vibrations,
)
from vibsim.evidence.verification.checks import Check, CheckRow

FAMILIES = (
    paper_cases.paper_case_checks,
    vibrations.free_vibration_checks,
    vibrations.linear_theory_checks,
    friction.coulomb_friction_checks,
    laws.mirror_symmetry_checks,
    laws.motor_run_up_checks,
    laws.monodromy_checks,
    laws.energy_ledger_checks,
    vibrations.bilinear_cycle_checks,
    impact_oscillators.impact_oscillator_checks,
    impact_orbits.impact_multiplier_checks,
    impact_orbits.impact_orbit_checks,
    impact_orbits.bouncing_ball_checks,
    friction.stick_slip_checks,
    friction.friction_oscillator_checks,
    impact_oscillators.several_impact_checks,
    laws.momentum_ledger_checks,
    hard_cases.hard_case_checks,
    hard_cases.million_seconds_checks,
    hard_cases.closed_form_checks,
    hard_cases.reported_failures_checks,
    paper_cases.spool_checks,
    formulas.formula_checks,
)


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every family."""
    return tuple(check for checks in FAMILIES for check in checks())


# Which checks a list of names and prefixes stands for.


class UnknownCheckError(ValueError):
    """A name that no check has or begins with; the message names the nearest."""


def selected(checks: Sequence[Check], names: Iterable[str]) -> list[Check]:
    """The checks that the names stand for, in the order of the catalogue; all where there are none.

    V1 stands for V1/..., not for V10; hard/stiff for every check that begins so. Letter case does not matter.
    """
    chosen = {check.name for name in names for check in _named(checks, name)}
    return [check for check in checks if check.name in chosen] if chosen else list(checks)


def _named(checks: Sequence[Check], name: str) -> list[Check]:
    plain = name.strip().rstrip("/").casefold()
    whole = [check for check in checks if f"{check.name}/".casefold().startswith(f"{plain}/")]
    begun = [check for check in checks if check.name.casefold().startswith(plain)]
    if not plain or not (whole or begun):
        raise UnknownCheckError(f"no check {name!r}{did_you_mean(name, spellings(checks))}; see --list")
    return whole or begun


def spellings(checks: Sequence[Check]) -> list[str]:
    """Everything that names one check or several: V3, V3/taylor, hard/stiff-stop, ..."""
    names: dict[str, None] = {}
    for check in checks:
        parts = check.name.split("/")
        names |= {"/".join(parts[:count]): None for count in range(1, len(parts) + 1)}
    return list(names)


# Run checks one by one and hand on their rows.


def verify(names: Iterable[str] | None = None, engine: str = "auto") -> Iterator[CheckRow]:
    """Compute the checks named (names or how they begin; None: all) and yield their rows.

    engine : "auto", "c" or "python". On the Python engine, checks that take it minutes are left out unless
    they are named.

    Raises UnknownCheckError before the first row.
    """
    computed_by = engine_name(engine)
    chosen, _ = chosen_checks(list(names or ()), computed_by)
    return rows_of(chosen, computed_by)


def chosen_checks(names: Sequence[str], engine: str) -> tuple[list[Check], list[Check]]:
    """The checks to compute, and those left out because the Python engine would take minutes."""
    chosen = selected(all_checks(), names)
    if engine == "c" or names:
        return chosen, []
    return [check for check in chosen if not check.long], [check for check in chosen if check.long]


def rows_of(checks: Sequence[Check], engine: str) -> Iterator[CheckRow]:
    """The rows of the checks; a run that fails is a row that falls short."""
    for check in checks:
        try:
            yield from check.rows(engine)
        except EngineError as error:
            yield CheckRow(
                check.name, "run", "its end", f"failed: {error}", inf, 0.0, "", "every run reaches its end"
            )
