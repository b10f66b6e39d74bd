"""V11: work in = stored + dissipated; and each entry of the ledger where a closed form gives it."""

from collections.abc import Iterator
from functools import partial
from math import cos, expm1, pi

from vibsim.cases import shipped_case_names
from vibsim.evidence.verification.bounds.rounding import REASON, relative_rounding
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.laws.motor_run_up import HEAVY, OMEGA0, TAU
from vibsim.evidence.verification.row import Row, compared, number_row
from vibsim.evidence.verification.runs import flows_of, made_case, named_case, run

CLOSURE = 1e-12  # relative to the largest entry: what the ledger promises
SLIDING = """
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 0 N/m}
friction: {mu: 0.001}
initial: {v2: 0.05 m/s}
run: {t_end: 10 s, every: 0.1 s}
"""
DAMPED = """
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 200 N/m, c: 30 N s/m}
initial: {x1: 10 mm}
run: {t_end: 3 s, every: 10 ms}
"""
DRIVEN = """
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 0 N/m}
excitation: {kind: harmonic, A: 0.3 N, omega: 2 Hz}
run: {t_end: 0.7 s, every: 10 ms}
"""


def checks() -> list[Check]:
    """The nine cases by their flows, and the entries."""
    listed = [Check("V11/entries", "Entries of the ledger with a closed form", entries)]
    for name in shipped_case_names():
        case = named_case(name)
        listed += [
            Check(
                f"V11/{name}/{flow}", f"Ledger of {name} over 300 s", partial(closure, name, flow), long=True
            )
            for flow in flows_of(case)
        ]
    return listed


def closure(name: str, flow: str, engine: str) -> Iterator[Row]:
    """What is missing in the balance at the end, relative to the largest entry."""
    residual = float(run(named_case(name), engine, flow).attrs["energy_residual_relative"])
    point = compared("what is missing, relative", 0.0, residual, CLOSURE)
    yield number_row(f"V11/{name}/{flow}", point, "promised: 1e-12 of the largest entry")


def entries(engine: str) -> Iterator[Row]:
    """Friction, damper, ideal source and motor, each alone."""
    spin = OMEGA0 * -expm1(-20.0 / TAU)
    speed = 0.3 * (1 - cos(4 * pi * 0.7)) / (0.297 * 4 * pi)
    for what, text, column, expected, conditioning in (
        ("friction loss = m2 v^2 / 2", SLIDING, "loss_friction", 2.94 * 0.05**2 / 2, 4),
        ("viscous loss = k1 x^2 / 2", DAMPED, "loss_viscous", 200 * 0.01**2 / 2, 4),
        ("work of a force = m1 v^2 / 2", DRIVEN, "work_source", 0.297 * speed**2 / 2, 4 * pi),
        (
            "work of a motor = (J + m3 e^2) w^2 / 2",
            HEAVY,
            "work_source",
            TAU * 0.005 / OMEGA0 * spin**2 / 2,
            6,
        ),
    ):
        changes = {"initial__phi": "0 rad", "run__t_end": "20 s"} if text is HEAVY else {}
        result = run(made_case(text, what, **changes), engine)
        bound = 2 * expected * relative_rounding(result, conditioning)
        point = compared(what, expected, float(result.attrs[column]), bound, "J")
        yield number_row("V11/entries", point, f"{REASON}; energy is quadratic")
