"""Overrides such as excitation.Omega0=6.5 Hz, set into a tree as if the file said so."""

from collections.abc import Mapping
from typing import Any

from vibsim.cases.file_tree import Tree
from vibsim.cases.keys import UnknownKeyError, full_key
from vibsim.cases.yaml_nodes import Place

FILE = "--set"


def apply_overrides(tree: Tree, overrides: Mapping[str, object]) -> None:
    """Set each override in the tree; unknown keys are added to its problems."""
    present = None
    named: dict[str, object] = {}
    for key, value in overrides.items():
        try:
            if "." not in key and present is None:
                present = _leaf_keys(tree.values)
            full = full_key(key.strip(), present or ())
            if full in named:
                tree.problems.append(Place(FILE).problem(full, "is given twice"))
            named[full] = value
        except UnknownKeyError as error:
            tree.problems.append(Place(FILE).problem(key.strip(), str(error)))
    _replace_kind(tree.values, named)
    for key, value in named.items():
        tree.values = _with(tree.values, key.split("."), value)
        tree.places[key] = tree.key_places[key] = Place(FILE)


def _leaf_keys(values: dict[str, Any], prefix: str = "") -> list[str]:
    keys = []
    for name, value in values.items():
        keys += _leaf_keys(value, f"{prefix}{name}.") if isinstance(value, dict) else [f"{prefix}{name}"]
    return keys


def _replace_kind(values: dict[str, Any], named: dict[str, object]) -> None:
    """An excitation of another kind starts from an empty section."""
    kind = named.get("excitation.kind")
    section = values.get("excitation")
    if kind is not None and isinstance(section, dict) and section.get("kind") != kind:
        values["excitation"] = {}


def _with(values: dict[str, Any], path: list[str], value: object) -> dict[str, Any]:
    """A copy with values["a"]["b"] = value for ["a", "b"]; a section that is none starts empty."""
    name, *rest = path
    if rest:
        inner = values.get(name)
        return values | {name: _with(inner if isinstance(inner, dict) else {}, rest, value)}
    return values | {name: value if isinstance(value, str) else _text(value)}


def _text(value: object) -> str:
    """A number given from Python as text; repr of a float is its shortest decimal."""
    return repr(value) if isinstance(value, float) else str(value)
