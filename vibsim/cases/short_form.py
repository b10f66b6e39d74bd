"""The short form of a case, the paper's two blocks, written in the long form."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from vibsim.cases.problems import shown
from vibsim.cases.quantities import Quantity, is_inertia, parse_quantity
from vibsim.cases.schema import AmplitudeRule, CaseFile, HarmonicKeys, MotorKeys
from vibsim.cases.schema_kinds import Single, sides_of

# The two ends of a part, as written: `between: [ram, ground]`.


GROUND, BASE = "ground", "base"
NO_BODIES = (GROUND, BASE)  # ends that are no bodies


class Ends(NamedTuple):
    """Names of the ends P and Q of a part: a body, ground or base."""

    P: str
    Q: str

    def __str__(self) -> str:
        return f"[{self.P}, {self.Q}]"

    @staticmethod
    def read(value: object) -> "Ends | None":
        """The ends behind a list, a tree's {"1": P, "2": Q} or a text such as "[P, Q]"; None for others."""
        if isinstance(value, Ends):
            return value
        if isinstance(value, str):
            text = value.strip()
            listed = text.startswith("[") and text.endswith("]")
            value = (text[1:-1] if listed else text).split(",")
            if any(bracket in name for name in value for bracket in "[]"):
                return None
        if isinstance(value, dict):
            value = [value.get("1"), value.get("2")] if len(value) == 2 else None
        names = value
        if not isinstance(names, list | tuple) or len(names) != 2:
            return None
        if not all(isinstance(name, str) and name.strip() for name in names):
            return None
        return Ends(names[0].strip(), names[1].strip())

    @staticmethod
    def as_kind() -> Single:
        return Single(_TwoEnds())


class _TwoEnds:
    """The value of a key that holds two ends."""

    def read(self, value: object) -> Ends:
        ends = Ends.read(value)
        if ends is None:
            value_text = _shown_places(value) if isinstance(value, dict) else shown(value)
            raise ValueError(
                f"must be two ends such as [ram, ground]: bodies, ground or base; got {value_text}"
            )
        return ends

    def json_schema(self) -> dict[str, Any]:
        """A list of two names."""
        name = {"type": ["string", "integer"]}  # a body may be called 1
        return {"type": "array", "items": name, "minItems": 2, "maxItems": 2}


def _shown_places(value: dict[str, object]) -> str:
    """Text in place of the two ends, a list or a mapping, with what has been reported already left
    out.
    """
    items = {place: item if isinstance(item, str) else "..." for place, item in value.items()}
    if all(place.isdecimal() for place in items):
        return shown(f"[{', '.join(items.values())}]")
    return shown(f"{{{', '.join(f'{place}: {item}' for place, item in items.items())}}}")


NO_DAMPING = parse_quantity("0 N s/m", "damping")
STILL = parse_quantity("0 m/s", "velocity")


def long_values(case: CaseFile) -> dict[str, Any]:
    """Nested values of the same case in the long form.

    The bodies are called 1 and 2; the parts coupling, stop, friction, excitation and rest_distance, after the
    sections that they come from. Friction with mu = 0 is no part.
    """
    ends = Ends("1", "2" if _is_moving(case) else GROUND)
    values: dict[str, Any] = {"name": case.name, "title": case.title}
    values |= {"parameters": case.parameters} if case.parameters else {}
    values["bodies"] = {"1": case.blocks.m1}
    if _is_moving(case):
        values["bodies"]["2"] = case.blocks.m2
    values["links"] = {"coupling": {"between": ends, "k": case.coupling.k1, "c": case.coupling.c}}
    values |= _stop(case, ends) | _friction(case) | _source(case) | {"initial": long_start(case)}
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
    if isinstance(source, HarmonicKeys):
        rule = isinstance(source.A, AmplitudeRule)
        amplitude = dict(source.A.__dict__) if rule else source.A
        term = {"A": amplitude, "omega": source.omega, "phase": NO_PHASE}
        return {"forces": {"excitation": {"on": "1", **term, "F0": source.F0}}}
    if isinstance(source, MotorKeys):
        constants = {name: value for name, value in source.__dict__.items() if name != "kind"}
        return {"motor": {"on": "1", **constants}}
    return {}


def long_start(case: CaseFile) -> dict[str, Any]:
    """Initial values of the same case in the long form, by part."""
    start = case.initial
    states: dict[str, Any] = {"1": {"x": start.x1, "v": start.v1}}
    if _is_moving(case):
        states["2"] = {"x": start.x2, "v": start.v2}
    if isinstance(case.excitation, MotorKeys):
        states["motor"] = {"phi": start.phi, "phidot": start.phidot}
    return states


def _run(case: CaseFile) -> dict[str, Any]:
    on_violation = case.rest_distance.on_violation if case.rest_distance else "warn"
    return dict(case.run.__dict__) | {"on_violation": on_violation}


# The long form of a case as YAML text, every default filled in; reads back to the same scene.


HEAD = ("name", "title")
FLAT = ("base", "motor", "run")  # sections of keys; the others hold parts by name
_PLAIN = re.compile(r"[A-Za-z0-9+-][A-Za-z0-9 ._+/^()'-]*", re.ASCII)


def long_text(values: dict[str, Any]) -> str:
    """YAML text of the nested values of a case in the long form."""
    return "\n".join(_lines(values)) + "\n"


def sections_text(values: dict[str, Any]) -> str:
    """YAML text of the nested values of a case in the short form: its sections, a line per key."""
    lines = [f"{name}: {scalar(values[name])}" for name in HEAD if values.get(name)]
    for section, content in values.items():
        if section in HEAD:
            continue
        lines += ["", f"{section}:"] if section == "blocks" else [f"{section}:"]
        lines += [f"  {name}: {flow(value)}" for name, value in content.items()]
    return "\n".join(lines) + "\n"


def _lines(values: dict[str, Any]) -> Iterator[str]:
    for name in HEAD:
        if values.get(name):
            yield f"{name}: {scalar(values[name])}"
    yield ""
    for section, content in values.items():
        if section in HEAD or not content:
            continue
        if section == "bodies" or section in FLAT:
            yield f"{section}: {flow(content)}"
        else:
            yield f"{section}:"
            yield from (f"  {scalar(name)}: {flow(part)}" for name, part in content.items())


def flow(value: Any, key: str = "") -> str:
    """A value, a part or a list of terms on one line."""
    if isinstance(value, dict) and key == "terms":
        return f"[{', '.join(flow(term) for term in value.values())}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{scalar(name)}: {flow(inner, name)}" for name, inner in value.items()) + "}"
    return str(value) if isinstance(value, Ends) else scalar(value)


def scalar(value: Any) -> str:
    """A value as plain text, in quotes where YAML would read it otherwise."""
    text = value.text if isinstance(value, Quantity) else str(value)
    is_plain = _PLAIN.fullmatch(text) and text == text.strip() and text not in ("null", "Null", "NULL")
    return text if is_plain else json.dumps(text, ensure_ascii=False)


# Defaults of the long form that depend on what else is given.


GRAVITY = parse_quantity("9.81 m/s^2", "acceleration")
NO_PHASE = parse_quantity("0 rad", "angle")
AT_REST = {"x": parse_quantity("0 m", "length"), "v": parse_quantity("0 m/s", "velocity")}
ROTOR_AT_REST = {"phi": NO_PHASE, "phidot": parse_quantity("0 rad/s", "angular rate")}


LOOSE_ROTOR_AT_REST = {"phi": NO_PHASE, "w": parse_quantity("0 rad/s", "angular rate")}
AT_REST_TURNING = {"x": NO_PHASE, "v": parse_quantity("0 rad/s", "angular rate")}


HARMONIC_KEYS = ("on", "A", "a", "omega", "phase")  # in the order in which they are written


def with_defaults(values: dict[str, Any], torsional: bool) -> dict[str, Any]:
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
    filled["initial"] = _default_states(values, torsional)
    return {name: filled[name] for name in _order(filled)}


def _order(values: dict[str, Any]) -> list[str]:
    """The sections in file order: the state at t = 0 comes before what is watched and the run."""
    last = [name for name in ("initial", "clearances", "run") if name in values]
    return [name for name in values if name not in last] + last


def _of_its_law(stop: dict[str, Any]) -> dict[str, Any]:
    """A stop without the defaults of the other law."""
    elastic = ("k", "c", "release")
    rigid = stop.get("law") == "rigid"
    return {name: value for name, value in stop.items() if not rigid or name not in elastic}


def _loaded(friction: dict[str, Any]) -> dict[str, Any]:
    belt = friction["belt"]
    loaded = {name: value for name, value in friction.items() if name != "belt"}
    if sides_of("friction", friction):
        del loaded["law"]
    torsional = isinstance(belt, Quantity) and belt.text.endswith("rad/s")
    return (
        loaded | ({} if "N" in friction or torsional else {"g": friction.get("g", GRAVITY)}) | {"belt": belt}
    )


def _in_phase(source: dict[str, Any], amplitude: str) -> dict[str, Any]:
    if amplitude not in source or "force" in source or "x" in source:
        return source
    return {
        name: source.get(name, NO_PHASE)
        for name in dict.fromkeys((*HARMONIC_KEYS, *source))
        if name in source or name == "phase"
    }


def _default_states(values: dict[str, Any], torsional: bool) -> dict[str, Any]:
    initial = values.get("initial", {})
    at_rest = {
        body: AT_REST_TURNING if torsional or is_inertia(str(mass)) else AT_REST
        for body, mass in values["bodies"].items()
    }
    states = {body: rest | initial.get(body, {}) for body, rest in at_rest.items()}
    states |= {rotor: LOOSE_ROTOR_AT_REST | initial.get(rotor, {}) for rotor in values.get("rotors", {})}
    return states | ({"motor": ROTOR_AT_REST | initial.get("motor", {})} if "motor" in values else {})


# A case of parts as far as it can be read: what the rules look at before all of it is known to be right.


JOINING = ("links", "stops", "friction", "clearances")  # sections of parts with two ends
PARTS = ("links", "stops", "friction", "forces", "states", "rotors", "clearances")
CALLED = {
    "bodies": "body",
    "links": "link",
    "stops": "stop",
    "friction": "friction",
    "forces": "force",
    "states": "state",
    "rotors": "rotor",
    "clearances": "clearance",
}


class FoundDefault(NamedTuple):
    """A fault that a rule found.

    Attributes
    ----------
    key : dotted key to be named
    message : what is wrong and what is allowed
    at : dotted key of the place, where that is another one
    of_the_name : True where the key itself is to blame and not its value
    span : from which character of the value to which, of a formula
    """

    key: str
    message: str
    at: str = ""
    of_the_name: bool = False
    span: tuple[int, int] | None = None


class Draft:
    """Bodies and parts of a case that may still be wrong."""

    def __init__(
        self, flat: Mapping[str, Any], values: Mapping[str, Any], torsional: bool = False, mixed: bool = False
    ):
        self.flat, self.values, self.torsional, self.mixed = flat, values, torsional, mixed

    def turns(self, body: str) -> bool:
        """Whether a body turns: its mass is an inertia."""
        return is_inertia(str(self.section("bodies").get(body)))

    def section(self, *path: str) -> dict[str, Any]:
        """The mapping at a path; empty where something else stands there."""
        inner: Any = self.values
        for name in path:
            inner = inner.get(name) if isinstance(inner, dict) else None
        return inner if isinstance(inner, dict) else {}

    @property
    def bodies(self) -> list[str]:
        return list(self.section("bodies"))

    def parts(self, *sections: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """(dotted key, keys) of each part that is a mapping."""
        for section in sections:
            for name, part in self.section(section).items():
                if isinstance(part, dict):
                    yield f"{section}.{name}", part

    def ends(self) -> Iterator[tuple[str, Ends]]:
        """(dotted key, ends) of each part with two of them that can be read."""
        for key, part in self.parts(*JOINING):
            ends = Ends.read(part.get("between"))
            if ends is not None:
                yield key, ends

    def quantity(self, key: str) -> Quantity | None:
        value = self.flat.get(key)
        return value if isinstance(value, Quantity) else None
