"""Defaults of the long form that depend on what else is given."""

from typing import Any

from vibsim.cases.values.quantities import parse_quantity

GRAVITY = parse_quantity("9.81 m/s^2", "acceleration")
NO_PHASE = parse_quantity("0 rad", "angle")
AT_REST = {"x": parse_quantity("0 m", "length"), "v": parse_quantity("0 m/s", "velocity")}
ROTOR_AT_REST = {"phi": NO_PHASE, "phidot": parse_quantity("0 rad/s", "angular rate")}


HARMONIC_KEYS = ("on", "A", "a", "omega", "phase")  # in the order in which they are written


def with_defaults(values: dict[str, Any]) -> dict[str, Any]:
    """The nested values of a case of parts with every default filled in: what is simulated, in full."""
    filled = dict(values)
    if "stops" in values:
        filled["stops"] = {name: _of_its_law(part) for name, part in values["stops"].items()}
    if "friction" in values:
        filled["friction"] = {name: _loaded(part) for name, part in values["friction"].items()}
    if "forces" in values:
        filled["forces"] = {name: _in_phase(part, "A") for name, part in values["forces"].items()}
    if "base" in values:
        filled["base"] = _in_phase(values["base"], "a")
    filled["initial"] = _states(values)
    return {name: filled[name] for name in _order(filled)}


def _order(values: dict[str, Any]) -> list[str]:
    """The sections in file order: the state at t = 0 comes before what is watched and the run."""
    last = [name for name in ("initial", "clearances", "run") if name in values]
    return [name for name in values if name not in last] + last


def _of_its_law(stop: dict[str, Any]) -> dict[str, Any]:
    """A stop without the defaults of the other law."""
    elastic = ("k", "c", "release")
    return {name: value for name, value in stop.items() if stop["law"] != "rigid" or name not in elastic}


def _loaded(friction: dict[str, Any]) -> dict[str, Any]:
    belt = friction["belt"]
    loaded = {name: value for name, value in friction.items() if name != "belt"}
    return loaded | ({} if "N" in friction else {"g": friction.get("g", GRAVITY)}) | {"belt": belt}


def _in_phase(source: dict[str, Any], amplitude: str) -> dict[str, Any]:
    if amplitude not in source:
        return source
    return {
        name: source.get(name, NO_PHASE)
        for name in dict.fromkeys((*HARMONIC_KEYS, *source))
        if name in source or name == "phase"
    }


def _states(values: dict[str, Any]) -> dict[str, Any]:
    initial = values.get("initial", {})
    states = {body: AT_REST | initial.get(body, {}) for body in values["bodies"]}
    return states | ({"motor": ROTOR_AT_REST | initial.get("motor", {})} if "motor" in values else {})
