"""What pydantic found wrong, in vibsim's words and at its place in the file."""

from typing import Any

from pydantic import ValidationError

from vibsim.cases.file_tree import BROKEN, Tree
from vibsim.cases.forms import Form
from vibsim.cases.keys import is_tag, section_at, sections_with
from vibsim.cases.problems import Problem, shown
from vibsim.cases.spelling import did_you_mean, nearest


def model_problems(error: ValidationError, tree: Tree, form: Form) -> list[Problem]:
    """The problems behind a pydantic error, each at its place in the files of the tree."""
    details = error.errors(include_url=False)
    later = {detail["loc"][:-1] for detail in details if detail["type"] == "later"}
    named_motors = any(map(_is_named_motor, details))
    problems = []
    for detail in details:
        location = detail["loc"]
        key = ".".join(str(part) for part in location if not is_tag(part))
        known = detail["input"] is not BROKEN and (tree.complete or detail["type"] != "missing")
        of_later_law = location[:-1] in later and detail["type"] in ("missing", "extra_forbidden")
        of_motors = named_motors and location[:-1] == ("motor",) and detail["type"] == "missing"
        if known and not of_later_law and not of_motors:
            problems.append(_problem(detail, location, key, tree, form))
    return problems


def _problem(detail: Any, location: tuple[Any, ...], key: str, tree: Tree, form: Form) -> Problem:
    """One pydantic error in vibsim's words."""
    kind = detail["type"]
    if kind == "extra_forbidden":
        return tree.key_place(key).problem(key, _unknown_key(location, detail["input"], form))
    if kind == "missing":
        return tree.place(key).problem(key, _missing_key(location, form))
    if kind == "union_tag_invalid":
        return _wrong_kind(detail["input"], key, tree)
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return tree.place(key).problem(key, _no_mapping(location, detail["input"], form))
    message = detail["ctx"]["what"] if "what" in detail.get("ctx", {}) else _plain_message(detail)
    return tree.place(key).problem(key, message)


def _is_named_motor(detail: Any) -> bool:
    """True for a motor under a name of its own, as if there could be several."""
    return (
        detail["type"] == "extra_forbidden"
        and detail["loc"][0] == "motor"
        and isinstance(detail["input"], dict)
    )


def _listed(names: Any) -> str:
    return ", ".join(names)


def _unknown_key(location: tuple[Any, ...], value: object, form: Form) -> str:
    *around, name = location
    section = section_at(tuple(around), form)
    allowed = list(section.model_fields) if section else []
    if section and name in section.later:
        return f"{section.later[name]}; allowed: {_listed(allowed)}"
    if around == ["motor"] and isinstance(value, dict):
        return f"a scene has at most one motor, without a name; allowed: {_listed(allowed)}"
    elsewhere = sections_with(name, form)
    hint = f" here; it belongs to {' or '.join(elsewhere)}" if elsewhere else did_you_mean(name, allowed)
    return f"unknown key{hint}; allowed: {_listed(allowed)}"


def _missing_key(location: tuple[Any, ...], form: Form) -> str:
    *around, name = location
    section = section_at(tuple(around), form)
    field = section.model_fields[name] if section else None
    inner = section_at(location, form)
    needs = [key for key, item in inner.model_fields.items() if item.is_required()] if inner else []
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
    return tree.place(key).problem(
        key, f"must be one of {_listed(allowed)}, got {shown(kind)}{did_you_mean(kind, allowed)}"
    )


def _no_mapping(location: tuple[Any, ...], value: object, form: Form) -> str:
    section = section_at(location, form)
    named = form.named if len(location) == 1 else ()
    keys = _listed(section.model_fields) if section else "names"
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


def _plain_message(detail: Any) -> str:
    """The checks that pydantic does itself: words, texts, whole numbers."""
    kind, context, value = detail["type"], detail.get("ctx", {}), detail["input"]
    actual = "a mapping" if isinstance(value, dict) else shown(value)
    if kind == "literal_error":
        section = context["expected"].replace("'", "").replace(" or ", ", ")
        near = nearest(str(value), section.split(", "))
        one_of = "one of " if ", " in section else ""
        return f"must be {one_of}{section}, got {actual}{f' (did you mean {near}?)' if near else ''}"
    if kind == "greater_than_equal":
        return f"must be >= {context['ge']}, got {actual}"
    if kind == "less_than_equal":
        return f"must be <= {context['le']}, got {actual}"
    if kind == "string_too_long":
        return f"may have at most {context['max_length']} characters"
    if kind == "string_pattern_mismatch":
        return (
            f"may hold letters, digits, spaces and . _ + -, and begins with a letter or digit; got {actual}"
        )
    if kind == "string_type":
        return f"must be a text, got {actual}"
    return f"{detail['msg']}, got {actual}"
