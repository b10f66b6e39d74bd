"""Everything that is measured for the report, gathered into one table of numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import pi
from typing import TYPE_CHECKING, Any

from vibsim.analysis import judge_regime, largest_exponent
from vibsim.analysis.capture import CAPTURE
from vibsim.analysis.cycles import BAND, run_up_time
from vibsim.cases import load_case
from vibsim.cases.validation import derived_facts
from vibsim.evidence.reports.measurements import (
    EQUAL_FORCE,
    MOTORS,
    PRINTED,
    PRINTED_MOTOR,
    SHIPPED_READINGS,
    Advance,
    Numbers,
    NumbersFile,
    measure_ensemble,
    measure_run,
    plain,
    run_all,
    starts,
)
from vibsim.evidence.reports.paper_figures import followed_cases, measure_ends
from vibsim.evidence.reports.readings import (
    DAMPINGS,
    FOLLOWED,
    FREQUENCIES,
    GAPS_MM,
    LAWS,
    LONGER,
    REGIMES_NEARBY_STARTS,
    SOLVERS,
    made_of,
    measure_gaps,
    measure_nearby,
    measure_solvers,
    measure_without_stop,
    search_plane,
    search_readings,
)
from vibsim.physics import elementary
from vibsim.results import Result, simulate

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.orbits.branches.branch import Branch


Tell = Callable[[str, int, int], bool]  # given what is done, how much of it, and of how much; False to stop

LONG = {"run.t_end": "3000 s", "run.every": "10 ms"}  # ten times the paper's span: where motions settle
SEARCHED = ("II-B", "II-C")
INERTIAS = (0.001, 0.0085)  # [kg m^2] as printed, and of the readings
HELD_HZ = 3.69


def measure_paper(
    results: Mapping[str, Result], follow: Callable[[], Mapping[str, Branch]], file: NumbersFile, tell: Tell
) -> Numbers:
    """All sections, measured or taken from the file; raises Interrupted when `tell` returns False.

    follow : gives the branches of `load_curves.obtain_branches`
    """
    cases = {name: result.case for name, result in results.items()}
    prints = {name: case.sha256 for name, case in cases.items()}
    motors = [cases[name] for name in SEARCHED]
    keys = [prints[name] for name in SEARCHED]

    def told(step: str) -> Advance:
        return lambda done, total: tell(step, done, total)

    file.section("facts", [prints, INERTIAS], lambda: measure_facts(cases))
    files = {name: [prints[name], result.attrs["date_created"]] for name, result in results.items()}
    file.section("runs", files, lambda: measure_runs(results, told("measuring")))
    followed = {name: case.sha256 for name, case in followed_cases().items()}
    file.section("ends", followed, lambda: measure_ends(follow()))
    file.section("long_runs", [prints, LONG], lambda: measure_long_runs(cases, told("following for longer")))
    for name in cases:
        measure = partial(measure_ensemble, cases[name], told(f"perturbing {name}"))
        file.section(f"ensemble {name}", [prints[name], starts()], measure)
    shown = [case for name, case in cases.items() if name not in SHIPPED_READINGS]
    file.section("without_stop", prints, lambda: measure_without_stop(shown, told("taking the stop away")))
    m3e = unbalance(cases)
    by_law = {
        law: [cases[name] for name in names] for law, names in zip(LAWS, (PRINTED, EQUAL_FORCE), strict=True)
    }
    beside = [prints, m3e, FREQUENCIES, DAMPINGS, LAWS, REGIMES_NEARBY_STARTS, FOLLOWED, LONGER]
    file.section("nearby", beside, lambda: measure_nearby(by_law, m3e, told("looking beside")))
    gapped = cases[PRINTED_MOTOR]
    file.section("gaps", [gapped.sha256, GAPS_MM], lambda: measure_gaps(gapped, told("widening the gap")))
    for case in motors:
        changed = case.with_values(at_voltage(case, cases[MOTORS[0]]))
        measure = partial(measure_ensemble, changed, told(f"raising the voltage to {case.name}"))
        file.section(f"voltage {case.name}", [changed.sha256, starts()], measure)
    sought = [keys, made_of()]
    file.section("readings", sought, lambda: search_readings(motors, told("judging readings")))
    file.section("plane", sought, lambda: search_plane(motors, told("searching over J and c")))
    file.section("solvers", [keys, SOLVERS], lambda: measure_solvers(motors, told("trying other solvers")))
    return table_of(file.sections)


def table_of(sections: Mapping[str, Any]) -> Numbers:
    """The sections as the claims read them."""
    ensembles, voltages = (_of_cases(sections, kind) for kind in ("ensemble", "voltage"))
    search = {name: sections[name] for name in ("readings", "plane")}
    names = ("facts", "ends", "runs", "long_runs", "without_stop", "nearby", "gaps", "solvers")
    whole = {name: sections[name] for name in names}
    return {**whole, "ensembles": ensembles, "voltages": voltages, "search": search}


def _of_cases(sections: Mapping[str, Any], kind: str) -> Numbers:
    """The sections "KIND CASE" by case."""
    parted = {name: name.partition(" ") for name in sections}
    return {case: sections[name] for name, (head, _, case) in parted.items() if head == kind}


def measure_facts(cases: Mapping[str, Case]) -> Numbers:
    """Consequences of the numbers of the cases alone: natural frequencies [Hz] and amplitudes [N]."""
    facts = {kind: {fact.name: fact.value for fact in derived_facts(cases[name].scene())}
             for kind, name in (("I", "I-A"), ("II", "II-A"))}  # fmt: skip
    return {
        "held_hz": facts["I"]["block 1 on its spring"],
        **{f"free_hz_{kind}": facts[kind]["free"] for kind in facts},
        **{f"bilinear_hz_{kind}": facts[kind]["bilinear"] for kind in facts},
        "least_hold_s": {f"{J:g}": least_hold(cases[MOTORS[2]], J) for J in INERTIAS},
        "characteristics": [_characteristic(cases[name]) for name in MOTORS],
        "amplitudes": [
            _amplitudes(*names, cases) for names in zip(PRINTED, EQUAL_FORCE, MOTORS, strict=True)
        ],
    }


def _characteristic(case: Case) -> Numbers:
    """No-load speed [Hz], torque at standstill [N m] and slope [N m s] of a motor's line."""
    scene = case.two_blocks()
    return {"no_load_hz": scene.Omega0 / (2 * pi), "M0": scene.M0, "slope": scene.M0 / scene.Omega0}


def at_voltage(case: Case, motor: Case) -> dict[str, str]:
    """Changes that make of a case the motor of another, at the voltage of the no-load speed of the case.

    On a DC motor with a constant field M0 = kt V / R and Omega0 = V / ke are both proportional to V.
    """
    one, other = (_characteristic(each) for each in (case, motor))
    return {"excitation.M0": f"{other['slope'] * one['M0'] / one['slope']!r} N m"}


def least_hold(case: Case, inertia: float) -> float:
    """Shortest hold near half the bilinear frequency that counts as capture [s], at an inertia [kg m^2]."""
    scene = case.with_values({"excitation.J": inertia}).scene()
    motor = scene.motor
    assert motor is not None
    no_load = motor.Omega0 / (2 * pi)
    slow, fast = (HELD_HZ * (1 + sign * BAND) for sign in (-1, 1))
    return CAPTURE * run_up_time(motor) * elementary.log((no_load - slow) / (no_load - fast))


def unbalance(cases: Mapping[str, Case]) -> float:
    """m3 e of the motor as printed [kg m]."""
    scene = cases[MOTORS[0]].two_blocks()
    return float(scene.m3 * scene.e)


def _amplitudes(printed: str, equal: str, motor: str, cases: Mapping[str, Case]) -> Numbers:
    ideal, by_rule, scene = (cases[name].two_blocks() for name in (printed, equal, motor))
    return {
        "omega_hz": ideal.omega / (2 * pi),
        "printed": ideal.A,
        "eq211": by_rule.A,
        "m3_e_omega": scene.m3 * scene.e * ideal.omega,
    }


def measure_runs(results: Mapping[str, Result], advance: Advance) -> Numbers:
    """Numbers of every run, its regime among them; of a reading also what it changes."""
    measured = run_all([partial(_measured, result) for result in results.values()], advance)
    return dict(zip(results, measured, strict=True))


def _measured(result: Result) -> Numbers:
    case = result.case
    changes = changes_of(case) if case.name in SHIPPED_READINGS else {}
    return {**measure_run(result), "regime": regime_of(result), "changes": changes}


def changes_of(case: Case) -> dict[str, list[str]]:
    """Changes of a reading against the case that it is a reading of: key -> [now, as printed]."""
    printed = load_case(case.name[:4])
    changed = [key for key in case.numeric_keys() if case.quantity(key) != printed.quantity(key)]
    return {key.split(".")[-1]: [str(each.quantity(key)) for each in (case, printed)] for key in changed}


def measure_long_runs(cases: Mapping[str, Case], advance: Advance) -> Numbers:
    """The regime that each motion settles in."""
    runs = run_all([partial(_long_run, case) for case in cases.values()], advance)
    return dict(zip(cases, runs, strict=True))


def _long_run(case: Case) -> Numbers:
    result = simulate(case.with_values(LONG), trust=False)
    return {"regime": regime_of(result)}


def regime_of(result: Result) -> Numbers:
    """The verdict on the regime, the largest Lyapunov exponent among its evidence."""
    regime: Numbers = plain(judge_regime(result, exponent=largest_exponent(result)))
    return regime
