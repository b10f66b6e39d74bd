"""Overrides such as excitation.Omega0=6.5 Hz, set into a tree as if the file said so."""

from collections.abc import Iterable, Mapping
from typing import Any

from vibsim.cases.plain_text import unstorable
from vibsim.cases.reading.alternatives import superseded
from vibsim.cases.reading.file_tree import BROKEN, Tree
from vibsim.cases.schema.forms import form_of
from vibsim.cases.schema.keys import UnknownKeyError, full_key, keys_of
from vibsim.cases.yaml_nodes import Place

FILE = "overrides"
PLACED = ("between", "on")  # an override that gives one of these makes a new part


def apply_overrides(tree: Tree, overrides: Mapping[str, object]) -> None:
    """Set each override in the tree; unknown keys are added to its problems. Raises TypeError for what is no
    mapping from keys.
    """
    if not isinstance(overrides, Mapping) or not all(isinstance(key, str) for key in overrides):
        raise TypeError(f"overrides must be a mapping such as {{'Omega0': '6 Hz'}}, got {overrides!r:.60}")
    if not overrides:
        return
    settings = [(key.strip(), value) for key, value in overrides.items()]
    present = _leaf_keys(tree.values)
    allowed = keys_of(form_of(tree.values), _with_new_parts(tree.values, [key for key, _ in settings]))
    named: dict[str, object] = {}
    for key, value in settings:
        try:
            full = full_key(key, present, allowed)
            if character := unstorable(str(value)):
                tree.problems.append(Place(FILE).problem(full, f"holds {character}, which no file can"))
                value = BROKEN
            if full in named:
                tree.problems.append(Place(FILE).problem(full, "is given twice"))
            named[full] = value
        except UnknownKeyError as error:
            tree.problems.append(Place(FILE).problem(key, str(error)))
    for full in named:
        whole = next((key for key in named if full.startswith(f"{key}.")), None)
        if whole is not None:
            message = f"is part of {whole}, which is given too; choose one"
            tree.problems.append(Place(FILE).problem(full, message))
    _replace_kind(tree.values, named)
    _supersede(tree, named)
    for key, value in named.items():
        tree.values = _with(tree.values, key.split("."), value)
        tree.places[key] = tree.key_places[key] = Place(FILE)


def _with_new_parts(values: dict[str, Any], keys: Iterable[str]) -> dict[str, Any]:
    """The values with the parts that overrides may add: those whose ends or body they give, and states."""
    form = form_of(values)
    for key in keys:
        section, *names = key.split(".")
        if section in form.named and len(names) > 1 and (names[1] in PLACED or section == "initial"):
            parts = values.get(section)
            if names[0] not in (parts if isinstance(parts, dict) else {}):
                values = _with(values, [section, names[0], names[1]], "")
    return values


def _supersede(tree: Tree, named: Mapping[str, object]) -> None:
    """Take out what the overrides put something else in place of."""
    split = [key.split(".") for key in named]
    parts = [".".join(path[:depth]) for path in split for depth in range(1, len(path))]
    for part in dict.fromkeys(parts):
        names = [key[len(part) + 1 :].partition(".")[0] for key in named if key.startswith(f"{part}.")]
        replaced = superseded(part, names)
        section: Any = tree.values
        for name in part.split("."):
            section = section.get(name) if isinstance(section, dict) else None
        if replaced and isinstance(section, dict):
            remaining = {name: value for name, value in section.items() if name not in replaced}
            tree.values = _with(tree.values, part.split("."), remaining)


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
    return values | {name: value if isinstance(value, str | dict) else _text(value)}


def _text(value: object) -> str:
    """A number given from Python as text; repr of a float, also one of numpy, is its shortest decimal."""
    return repr(float(value)) if isinstance(value, float) else str(value)
