"""The short form of a case, the paper's two blocks, written in the long form."""

from typing import Any

from vibsim.cases.parts.defaults import NO_PHASE
from vibsim.cases.parts.ends import GROUND, Ends
from vibsim.cases.schema.schema import AmplitudeRule, CaseFile, Harmonic, Motor
from vibsim.cases.values.quantities import Quantity, parse_quantity

NO_DAMPING = parse_quantity("0 N s/m", "damping")
STILL = parse_quantity("0 m/s", "velocity")


def long_values(case: CaseFile) -> dict[str, Any]:
    """Nested values of the same case in the long form.

    The bodies are called 1 and 2; the parts coupling, stop, friction, excitation and rest_distance, after the
    sections that they come from. Friction with mu = 0 is no part.
    """
    ends = Ends("1", "2" if _is_moving(case) else GROUND)
    values: dict[str, Any] = {"name": case.name, "title": case.title, "bodies": {"1": case.blocks.m1}}
    if _is_moving(case):
        values["bodies"]["2"] = case.blocks.m2
    values["links"] = {"coupling": {"between": ends, "k": case.coupling.k1, "c": case.coupling.c}}
    values |= _stop(case, ends) | _friction(case) | _source(case) | _states(case)
    if case.rest_distance:
        clearance = {"between": ends, "distance": case.rest_distance.value}
        values["clearances"] = {"rest_distance": clearance}
    return values | {"run": _run(case)}


def _is_moving(case: CaseFile) -> bool:
    return isinstance(case.blocks.m2, Quantity)


def _stop(case: CaseFile, ends: Ends) -> dict[str, Any]:
    """The impact spring: in contact while x2 - x1 >= G (extension) or x1 - x2 >= G."""
    stop = case.stop
    if stop is None:
        return {}
    part = {"between": ends, "gap": stop.G, "acts": stop.acts, "law": "elastic", "k": stop.k2}
    return {"stops": {"stop": part | {"c": NO_DAMPING, "release": "gap"}}}


def _friction(case: CaseFile) -> dict[str, Any]:
    friction = case.friction
    if friction is None or not _is_moving(case) or friction.mu.value == 0:
        return {}
    part = {"between": Ends("2", GROUND), "law": "coulomb", "mu": friction.mu, "g": friction.g}
    return {"friction": {"friction": part | {"belt": STILL}}}


def _source(case: CaseFile) -> dict[str, Any]:
    source = case.excitation
    if isinstance(source, Harmonic):
        rule = isinstance(source.A, AmplitudeRule)
        amplitude = dict(source.A.__dict__) if rule else source.A
        term = {"A": amplitude, "omega": source.omega, "phase": NO_PHASE}
        return {"forces": {"excitation": {"on": "1", **term, "F0": source.F0}}}
    if isinstance(source, Motor):
        constants = {name: getattr(source, name) for name in ("m3", "e", "J", "M0", "Omega0")}
        return {"motor": {"on": "1", **constants}}
    return {}


def _states(case: CaseFile) -> dict[str, Any]:
    start = case.initial
    states: dict[str, Any] = {"1": {"x": start.x1, "v": start.v1}}
    if _is_moving(case):
        states["2"] = {"x": start.x2, "v": start.v2}
    if isinstance(case.excitation, Motor):
        states["motor"] = {"phi": start.phi, "phidot": start.phidot}
    return {"initial": states}


def _run(case: CaseFile) -> dict[str, Any]:
    on_violation = case.rest_distance.on_violation if case.rest_distance else "warn"
    return dict(case.run.__dict__) | {"on_violation": on_violation}
