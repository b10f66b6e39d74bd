"""A tree of texts to a validated case file, or all that is wrong with it, each at its place."""

from collections.abc import Iterator
from typing import Any

from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.reading.contradictions import contradictions
from vibsim.cases.reading.file_tree import Tree
from vibsim.cases.resolved import every_value
from vibsim.cases.schema.forms import LONG, Form, form_of, mixed_problems, of_one_form
from vibsim.cases.schema.keys import all_keys
from vibsim.cases.schema.kinds import Fault
from vibsim.cases.schema.schema import CaseHead
from vibsim.cases.values.quantities import QuantityError
from vibsim.cases.yaml_nodes import Place


def validated(tree: Tree) -> CaseHead:
    """The case file of a tree. Raises CaseError with all problems found, in file order."""
    form = form_of(tree.values)
    problems = [*tree.problems, *mixed_problems(tree.values, tree.key_place)]
    values = form.without_switched_off(of_one_form(tree.values))
    if tree.values or not problems:
        model, further = _checked(values, tree, form)
        if model is not None and not (further or problems):
            return model
        reported = {problem.key for problem in problems if problem.key}
        problems += [problem for problem in further if not _around(problem.key) & reported]
    raise CaseError(sorted(dict.fromkeys(problems), key=_file_order(tree)))


def _checked(values: dict[str, Any], tree: Tree, form: Form) -> tuple[CaseHead | None, list[Problem]]:
    """The model where every value is right by itself, and all problems, also those between keys."""
    problems: list[Problem] = []
    faults: list[Fault] = []
    model = form.model.read(values, (), faults)
    if model is None or faults:
        from vibsim.cases.reading.model_problems import model_problems

        model, problems = None, model_problems(faults, tree, form)
        flat = dict(_readable(values, "", form))
    else:
        flat = every_value(model)
    for keys, message in contradictions(flat):
        key = min(keys, key=lambda key: _layer(tree, tree.key_place(key)))
        place = tree.key_place(key) if key in form.switchable else tree.place(key)
        problems.append(place.problem(key, message))
    if form is LONG:
        problems += _problems_of_parts(values, tree)
    return model, problems


def _problems_of_parts(values: dict[str, Any], tree: Tree) -> list[Problem]:
    """What the rules of the long form find; not what is the fault of a file that could not be read."""
    from vibsim.cases.parts.rules import findings

    if not tree.complete:
        return []
    problems = []
    for finding in findings(dict(_readable(values, "", LONG)), values):
        place = tree.key_place if finding.of_the_name else tree.place
        problems.append(place(finding.key).problem(finding.key, finding.message))
    return problems


def _layer(tree: Tree, place: Place) -> int:
    """0 for an override, 1 for the case's own file, 2 for what that extends; the lowest is to blame."""
    if place.line is None and place != tree.root:
        return 0
    return 1 if place.file == tree.root.file else 2


def _readable(values: dict[str, Any], prefix: str, form: Form) -> Iterator[tuple[str, Any]]:
    """Those values of an invalid case that can be read by themselves."""
    for name, value in values.items():
        key = f"{prefix}{name}"
        if isinstance(value, dict):
            yield from _readable(value, f"{key}.", form)
            continue
        measured = all_keys(form).get(form.pattern(key))
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
