"""Case files to one plain tree of texts: `extends` followed, child over parent, every place kept."""

from dataclasses import dataclass, field
from typing import Any

from vibsim.cases.problems import CaseError, Problem, shown
from vibsim.cases.reading.alternatives import superseded
from vibsim.cases.reading.sources import SourceText, find_source
from vibsim.cases.schema.forms import LONG, SHORT
from vibsim.cases.yaml_nodes import Broken, Mapping, Node, Place, Text, read_yaml

LONGEST_CHAIN = 8  # files that extend one another
FEW_KEYS = 3  # that may all be misspelt
OWN_KEYS = ("name", "title", "extends")  # not inherited: they speak of one file
BROKEN = object()  # a value that has been reported already


@dataclass
class Tree:
    """A case before validation.

    Attributes
    ----------
    values : nested dict of texts
    places : dotted key -> place of its value
    key_places : dotted key -> place of the key itself
    root : where the case begins, the place of what is missing
    problems : what reading found
    complete : False where a file could not be read, so that keys may be missing for that reason
    """

    values: dict[str, Any]
    root: Place
    places: dict[str, Place] = field(default_factory=dict)
    key_places: dict[str, Place] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    complete: bool = True

    def place(self, key: str) -> Place:
        """Place of a key's value, or of the section around it where it is missing."""
        return self.places[key] if key in self.places else self.key_place(key.rpartition(".")[0])

    def key_place(self, key: str) -> Place:
        """Place of a key itself, or of the section around it where it is missing."""
        while key:
            if key in self.key_places:
                return self.key_places[key]
            key = key.rpartition(".")[0]
        return self.root


def read_tree(source: SourceText) -> Tree:
    """Read a case file and the files that it extends. What is wrong is left in `problems`."""
    tree = Tree({}, Place(source.shown, 1, 1))
    merged = _read_chain(source, [], tree)
    if merged is not None:
        _plain(merged, "", tree.values, tree)
    if not isinstance(tree.values.get("extends"), dict):
        tree.values.pop("extends", None)  # followed, or reported
    return tree


def _read_chain(source: SourceText, chain: list[str], tree: Tree) -> Mapping | None:
    """The mapping of one file over that of its parent; None where nothing could be read."""
    own, problems = read_yaml(source.text, source.shown)
    if own is not None and _is_no_case(own):
        first, place = next(iter(own.key_places.items()))
        count = f"none of its {len(own.values)} keys is one of a case"
        own, problems = None, [place.problem("", f"is no case file: {count}, as {shown(first, 20)} is not")]
    tree.problems += problems
    extends = own.values.get("extends") if own else None
    parent = None
    if isinstance(extends, Text):
        parent = _parent(extends, source, [*chain, source.identity], tree)
    if own is None or (extends and parent is None):
        tree.complete = False
    if own is None or parent is None:
        return own
    inherited = [key for key in parent.values if key not in OWN_KEYS]
    parent = Mapping(
        own.place,
        {key: parent.values[key] for key in inherited},
        {key: parent.key_places[key] for key in inherited},
    )
    return _over(parent, own)


def _is_no_case(mapping: Mapping) -> bool:
    """Whether a file holds many keys, and none of a case: its lines are nobody's to be told one by one."""
    known = {*OWN_KEYS, "vibsim_case", *SHORT.sections, *LONG.sections}
    return len(mapping.values) > FEW_KEYS and known.isdisjoint(mapping.values)


def _parent(extends: Text, source: SourceText, chain: list[str], tree: Tree) -> Mapping | None:
    """What a file extends; None, with a problem at that line, where it cannot be read."""
    try:
        if extends.text == "-":
            raise CaseError([Problem("-", None, None, "", "standard input cannot be extended")])
        parent = find_source(extends.text, source.folder)
    except CaseError as error:
        tree.problems += [_blamed(problem, extends.place) for problem in error.problems]
        return None
    if parent.identity in chain:
        tree.problems.append(
            extends.place.problem(
                "extends", f"goes round in a circle, back to {shown(parent.shown, limit=200)}"
            )
        )
        return None
    if len(chain) >= LONGEST_CHAIN:
        tree.problems.append(
            extends.place.problem("extends", f"more than {LONGEST_CHAIN} files extend one another")
        )
        return None
    return _read_chain(parent, chain, tree)


def _blamed(problem: Problem, place: Place) -> Problem:
    """A problem of a parent that cannot be read at all, told at the line that asks for it."""
    if problem.line is not None:
        return problem
    return place.problem("extends", f"{shown(problem.file, limit=200)}: {problem.message}")


def _over(parent: Mapping, child: Mapping, key: str = "") -> Mapping:
    """Child over parent, key by key; lists, and an excitation of another kind, replace what was there."""
    replaced = superseded(key, child.values.keys())
    values = {name: value for name, value in parent.values.items() if name not in replaced}
    places = {name: parent.key_places[name] for name in values}
    for name, value in child.values.items():
        below = values.get(name)
        if isinstance(below, Mapping) and isinstance(value, Mapping) and not _replaces(below, value):
            value = _over(below, value, f"{key}.{name}" if key else name)
        values[name] = value
        places[name] = child.key_places[name]
    return Mapping(child.place, values, places)


def _replaces(parent: Mapping, child: Mapping) -> bool:
    old, new = parent.values.get("kind"), child.values.get("kind")
    other_kind = new is not None and (
        not isinstance(old, Text) or not isinstance(new, Text) or old.text != new.text
    )
    return child.is_list or other_kind


def _plain(mapping: Mapping, prefix: str, values: dict[str, Any], tree: Tree) -> None:
    """Fill `values` with plain texts and dicts, and the places of the tree with where they stand."""
    for name, node in mapping.values.items():
        key = f"{prefix}{name}"
        tree.key_places[key] = mapping.key_places[name]
        tree.places[key] = node.place
        values[name] = _plain_value(node, key, tree)


def _plain_value(node: Node, key: str, tree: Tree) -> Any:
    if isinstance(node, Text):
        return node.text
    if isinstance(node, Broken):
        return BROKEN
    inner: dict[str, Any] = {}
    _plain(node, f"{key}.", inner, tree)
    return inner
