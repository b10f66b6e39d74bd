"""A tree of texts to a validated CaseFile, or all that is wrong with it, each at its place."""

from collections.abc import Iterator
from typing import Any

from pydantic import ValidationError

from vibsim.cases.contradictions import contradictions
from vibsim.cases.file_tree import SWITCHABLE, SWITCHED_OFF, Tree
from vibsim.cases.keys import all_keys
from vibsim.cases.model_problems import model_problems
from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.quantities import QuantityError
from vibsim.cases.resolved import every_value
from vibsim.cases.schema import CaseFile
from vibsim.cases.yaml_nodes import Place


def validated(tree: Tree) -> CaseFile:
    """The case file of a tree. Raises CaseError with all problems found, in file order."""
    values = {name: value for name, value in tree.values.items() if not _switched_off(name, value)}
    problems = list(tree.problems)
    if values or not problems:
        model, found = _checked(values, tree)
        if model is not None and not (found or problems):
            return model
        reported = {problem.key for problem in problems if problem.key}
        problems += [problem for problem in found if not _around(problem.key) & reported]
    raise CaseError(sorted(dict.fromkeys(problems), key=_file_order(tree)))


def _switched_off(name: str, value: object) -> bool:
    return value == SWITCHED_OFF and name in SWITCHABLE


def _checked(values: dict[str, Any], tree: Tree) -> tuple[CaseFile | None, list[Problem]]:
    """The model where every value is right by itself, and all problems, also those between keys."""
    model, problems = None, []
    try:
        model = CaseFile.model_validate(values)
        flat = every_value(model)
    except ValidationError as error:
        problems = model_problems(error, tree)
        flat = dict(_readable(values, ""))
    for keys, message in contradictions(flat):
        key = min(keys, key=lambda key: _layer(tree, tree.key_place(key)))
        place = tree.key_place(key) if key in SWITCHABLE else tree.place(key)
        problems.append(place.problem(key, message))
    return model, problems


def _layer(tree: Tree, place: Place) -> int:
    """0 for an override, 1 for the case's own file, 2 for what that extends; the lowest is to blame."""
    if place.line is None and place != tree.root:
        return 0
    return 1 if place.file == tree.root.file else 2


def _readable(values: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Those values of an invalid case that can be read by themselves."""
    for name, value in values.items():
        key = f"{prefix}{name}"
        if isinstance(value, dict):
            yield from _readable(value, f"{key}.")
            continue
        measured = all_keys().get(key)
        try:
            yield key, measured.read(value) if measured else value
        except QuantityError:
            continue


def _around(key: str) -> set[str]:
    """A key and the sections around it: "a.b" gives {"a.b", "a"}."""
    parts = key.split(".")
    return {".".join(parts[: count + 1]) for count in range(len(parts))}


def _file_order(tree: Tree) -> Any:
    """Sort by file (the case's own first, overrides last), then by place."""

    def order(problem: Problem) -> tuple[bool, bool, str, int, int]:
        own = problem.file == tree.root.file
        return problem.line is None, not own, problem.file, problem.line or 0, problem.column or 0

    return order
