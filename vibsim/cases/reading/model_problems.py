"""What is wrong with the keys and values of a case, in words and at its place in the file."""

from typing import Any

from vibsim.cases.problems import Problem, shown
from vibsim.cases.reading.file_tree import BROKEN, Tree
from vibsim.cases.schema.forms import Form
from vibsim.cases.schema.keys import is_tag, section_at, sections_with
from vibsim.cases.schema.kinds import Fault, Location
from vibsim.cases.spelling import did_you_mean, unsupported


def model_problems(faults: list[Fault], tree: Tree, form: Form) -> list[Problem]:
    """The problems behind faults, each at its place in the files of the tree."""
    named_motors = any(map(_is_named_motor, faults))
    problems = []
    for fault in faults:
        known = fault.value is not BROKEN and (tree.complete or fault.what != "missing")
        of_motors = named_motors and fault.location[:-1] == ("motor",) and fault.what == "missing"
        if known and not of_motors:
            problems.append(_problem(fault, tree, form))
    return problems


def _problem(fault: Fault, tree: Tree, form: Form) -> Problem:
    """One fault in words."""
    location, value = fault.location, fault.value
    key = ".".join(part for part in location if not is_tag(part))
    if fault.what == "unknown":
        return tree.key_place(key).problem(key, _unknown_key(location, value, form))
    if fault.what == "no variant":
        return _wrong_kind(value, key, tree)
    message = fault.message
    if fault.what == "missing":
        message = _missing_key(location, form)
    elif fault.what == "no mapping":
        message = _no_mapping(location, value, form)
    return tree.place(key).problem(key, message)


def _is_named_motor(fault: Fault) -> bool:
    """True for a motor under a name of its own, as if there could be several."""
    return fault.what == "unknown" and fault.location[0] == "motor" and isinstance(fault.value, dict)


def _listed(names: Any) -> str:
    return ", ".join(names)


def _unknown_key(location: Location, value: object, form: Form) -> str:
    *around, name = location
    section = section_at(tuple(around), form)
    allowed = _states_of(around, form) or (list(section.keys) if section else [])
    if around == ["motor"] and isinstance(value, dict):
        return f"a scene has at most one motor, without a name; allowed: {_listed(allowed)}"
    elsewhere = sections_with(name, form)
    if not elsewhere and (limit := unsupported(name)):
        return limit
    hint = f" here; it belongs to {' or '.join(elsewhere)}" if elsewhere else did_you_mean(name, allowed)
    return f"unknown key{hint}; allowed: {_listed(allowed)}"


def _states_of(around: list[str], form: Form) -> list[str]:
    """What the start of a body has, or of the rotor: the schema has one section for both."""
    if "initial" not in form.named or len(around) != 2 or around[0] != "initial":
        return []
    return ["phi", "phidot"] if around[1] == "motor" else ["x", "v"]


def _missing_key(location: Location, form: Form) -> str:
    *around, name = location
    section = section_at(tuple(around), form)
    field = section.keys[name] if section else None
    inner = section_at(location, form)
    needs = [key for key, item in inner.keys.items() if item.is_required()] if inner else []
    if needs:
        return f"is missing; it needs {_listed(needs)}"
    example = f", for example {name}: {field.examples[0]}" if field and field.examples else ""
    return f"is missing{example}"


def _wrong_kind(value: object, key: str, tree: Tree) -> Problem:
    """An excitation of no known kind, of no kind at all, or that is no mapping."""
    allowed = ["motor", "harmonic", "none"]
    if not isinstance(value, dict):
        message = f"must be a mapping such as {{kind: motor, ...}}, or none; got {shown(value)}"
        return tree.place(key).problem(key, message)
    key = f"{key}.kind"
    if "kind" not in value:
        return tree.place(key).problem(key, f"is missing; allowed: {_listed(allowed)}")
    if value["kind"] is BROKEN:
        return tree.place(key).problem(key, "cannot be read")
    if isinstance(value["kind"], dict):
        return tree.place(key).problem(key, f"must be one of {_listed(allowed)}, got a mapping")
    kind = str(value["kind"])
    choice = f"must be one of {_listed(allowed)}, got {shown(kind)}{did_you_mean(kind, allowed)}"
    return tree.place(key).problem(key, unsupported(kind) or choice)


def _no_mapping(location: Location, value: object, form: Form) -> str:
    section = section_at(location, form)
    named = form.named if len(location) == 1 else ()
    keys = _listed(section.keys) if section else "names"
    if location[-1] == "terms":
        return f"must be a list of harmonics, such as [{{A: 10 N, omega: 25 Hz}}]; got {shown(value)}"
    if len(location) == 2 and location[0] == "initial" and "initial" in form.named:
        starts = "{x: ..., v: ...} of a body, or {phi: ..., phidot: ...} of motor"
        return f"must be the start of one part, such as initial.NAME: {starts}; got {shown(value)}"
    if location[-1] in named:
        keys = NAMED_SECTIONS.get(location[-1], "parts by name, each a mapping of its keys")
    part = len(location) == 2 and location[0] in form.named
    none = ", or none" if part or (len(location) == 1 and location[0] in form.switchable) else ""
    return f"must be a mapping of {keys}{none}; got {shown(value)}"


NAMED_SECTIONS = {
    "bodies": "names and masses, such as {ram: 2 kg}",
    "initial": "bodies and their states, such as {ram: {x: 0 m, v: 0 m/s}}",
}
