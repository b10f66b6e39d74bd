"""What pydantic found wrong, in vibsim's words and at its place in the file."""

from typing import Any

from pydantic import ValidationError

from vibsim.cases.file_tree import BROKEN, SWITCHABLE, Tree
from vibsim.cases.keys import is_tag, section_at, sections_with
from vibsim.cases.problems import Problem, shown
from vibsim.cases.spelling import did_you_mean, nearest


def model_problems(error: ValidationError, tree: Tree) -> list[Problem]:
    """The problems behind a pydantic error, each at its place in the files of the tree."""
    problems = []
    for detail in error.errors(include_url=False):
        location = detail["loc"]
        key = ".".join(str(part) for part in location if not is_tag(part))
        known = detail["input"] is not BROKEN and (tree.complete or detail["type"] != "missing")
        if known:
            problems.append(_problem(detail, location, key, tree))
    return problems


def _problem(detail: Any, location: tuple[Any, ...], key: str, tree: Tree) -> Problem:
    """One pydantic error in vibsim's words."""
    kind = detail["type"]
    if kind == "extra_forbidden":
        return tree.key_place(key).problem(key, _unknown_key(location))
    if kind == "missing":
        return tree.place(key).problem(key, _missing_key(location))
    if kind == "union_tag_invalid":
        return _wrong_kind(detail["input"], key, tree)
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return tree.place(key).problem(key, _no_mapping(location, detail["input"]))
    message = detail["ctx"]["what"] if "what" in detail.get("ctx", {}) else _plain_message(detail)
    return tree.place(key).problem(key, message)


def _listed(names: Any) -> str:
    return ", ".join(names)


def _unknown_key(location: tuple[Any, ...]) -> str:
    *around, name = location
    section = section_at(tuple(around))
    allowed = list(section.model_fields) if section else []
    elsewhere = sections_with(name)
    hint = f" here; it belongs to {' or '.join(elsewhere)}" if elsewhere else did_you_mean(name, allowed)
    return f"unknown key{hint}; allowed: {_listed(allowed)}"


def _missing_key(location: tuple[Any, ...]) -> str:
    *around, name = location
    section = section_at(tuple(around))
    field = section.model_fields[name] if section else None
    inner = section_at(location)
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


def _no_mapping(location: tuple[Any, ...], value: object) -> str:
    section = section_at(location)
    keys = _listed(section.model_fields) if section else ""
    none = ", or none" if len(location) == 1 and location[0] in SWITCHABLE else ""
    return f"must be a mapping of {keys}{none}; got {shown(value)}"


def _plain_message(detail: Any) -> str:
    """The checks that pydantic does itself: words, texts, whole numbers."""
    kind, context, value = detail["type"], detail.get("ctx", {}), detail["input"]
    got = "a mapping" if isinstance(value, dict) else shown(value)
    if kind == "literal_error":
        section = context["expected"].replace("'", "").replace(" or ", ", ")
        near = nearest(str(value), section.split(", "))
        one_of = "one of " if ", " in section else ""
        return f"must be {one_of}{section}, got {got}{f' (did you mean {near}?)' if near else ''}"
    if kind == "greater_than_equal":
        return f"must be >= {context['ge']}, got {got}"
    if kind == "less_than_equal":
        return f"must be <= {context['le']}, got {got}"
    if kind == "string_too_long":
        return f"may have at most {context['max_length']} characters"
    if kind == "string_pattern_mismatch":
        return f"may hold letters, digits, spaces and . _ + -, and begins with a letter or digit; got {got}"
    if kind == "string_type":
        return f"must be a text, got {got}"
    return f"{detail['msg']}, got {got}"
