"""Where cases come from: a path, a shipped name, or standard input; size and encoding checked."""

import re
import sys
from collections.abc import Collection, Iterable, Mapping
from importlib.util import find_spec
from os.path import exists, isdir, isfile, normpath
from pathlib import Path
from typing import Any, NamedTuple

from vibsim.cases.problems import CaseError, Problem, did_you_mean, shown, unstorable
from vibsim.cases.quantities import NUMBER
from vibsim.cases.schema_keys import (
    LONG,
    SHORT,
    UnknownKeyError,
    all_keys,
    form_of,
    full_key,
    given_way,
    is_free,
    keys_of,
)
from vibsim.cases.schema_kinds import ALWAYS, FORMULA_KEYS, Formula, has_formulas, is_formula
from vibsim.cases.yaml_nodes import (
    HDF5_SIGNATURE,
    LARGEST_FILE,
    Broken,
    Node,
    Place,
    Text,
    Tree,
    decoded,
    read_yaml,
)
from vibsim.cases.yaml_nodes import Mapping as yaml_nodes_Mapping

SUFFIXES = (".yaml", ".yml")
RESULTS = (".h5", ".hdf5", ".partial")
HARD, GALLERY = "hard/", "gallery/"  # folders of shipped cases, and how their names begin


class PathText(str):
    """The path or name of a case on a command line, which is one whatever is in it, and no text of a case."""


class SourceText(NamedTuple):
    """The text of one case file.

    Attributes
    ----------
    shown : path as the user gave it, for messages
    stem : name of the case where the file gives none
    text : the YAML text
    folder : where an `extends` of this file looks for relative paths
    identity : tells whether two sources are the same file
    """

    shown: str
    stem: str
    text: str
    folder: Path
    identity: str


def shipped_folder() -> Path:
    """The folder of the shipped cases, installed or in a checkout."""
    package = find_spec("vibsim.shipped_cases")  # importlib.resources loads shutil, tempfile and random
    installed = list(package.submodule_search_locations or ()) if package else []
    checkout = Path(__file__).resolve().parents[2] / "cases"
    return next((Path(folder) for folder in installed if Path(folder, "II-B.yaml").is_file()), checkout)


def shipped_case_names() -> list[str]:
    """Names of the shipped cases, sorted: I-A, I-A-eq211, ... II-C."""
    return sorted(path.stem for path in shipped_folder().glob("*.yaml"))


def hard_case_names() -> list[str]:
    """Names of the cases that are hard to compute, sorted: hard/a-million-seconds, ... hard/..."""
    return _names_in(HARD)


def gallery_case_names() -> list[str]:
    """Names of the published models and examples, sorted: gallery/bilinear-oscillator, ... gallery/..."""
    return _names_in(GALLERY)


def _names_in(folder: str) -> list[str]:
    return sorted(f"{folder}{path.stem}" for path in (shipped_folder() / folder).glob("*.yaml"))


def is_path(source: str) -> bool:
    """True for what names a file: it ends in .yaml or .yml or has a folder in it."""
    return source.lower().endswith(SUFFIXES) or "/" in source or "\\" in source


def find_source(source: str, folder: Path | None = None) -> SourceText:
    """Read the case file that `source` names: a path, a shipped name, or "-" for standard input.

    Relative paths count from `folder`: that of the file which names the source (default: the current one, for
    what the user names). Raises CaseError where there is no such file, or where it is too large or no UTF-8
    text; a file may only name regular files, because opening another kind can wait for ever.
    """
    if source == "-":
        text = decoded(sys.stdin.buffer.read(LARGEST_FILE + 1), "stdin")
        return SourceText("stdin", "stdin", text, Path(), "-")
    path = Path(source)
    if source.startswith((HARD, GALLERY)) and source in _names_in(source.partition("/")[0] + "/"):
        path = shipped_folder() / f"{source}.yaml"
        return _file(path, str(path))
    if is_path(source):
        if folder is None:
            return _file(path, str(path))
        path = path if path.is_absolute() else Path(normpath(folder / path))
        if exists(path) and not isfile(path) and not isdir(path):
            raise CaseError([Problem(str(path), None, None, "", "is no regular file")])
        return _file(path, str(path))
    if source in shipped_case_names():
        path = shipped_folder() / f"{source}.yaml"
        return _file(path, str(path))
    raise CaseError([Problem(source or '""', None, None, "", _no_such_case(source))])


def called_as_result(source: str) -> bool:
    """Whether a source has the name of a result file, which holds no text."""
    return source.lower().endswith(RESULTS)


def _no_case_but(source: str) -> str:
    """Message for a source that has the name of a result file."""
    if isdir(source):
        return _no_case_but_a_folder(Path(source))
    if not isfile(source):
        return "no such file"
    try:
        with open(source, "rb") as file:
            is_result = file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    except OSError:
        is_result = True
    if not is_result:
        return "is not an HDF5 file, as its name says; a case file ends in .yaml"
    return "is a result and no case file; vibsim info --case prints its case"


def _no_case_but_a_folder(path: Path) -> str:
    inside = [f"{path}/*{suffix}" for suffix in SUFFIXES if any(path.glob(f"*{suffix}"))]
    others = f"; for those in it write {' '.join(inside)}" if inside else _shipped_in(path)
    return f"is a folder, not a case file{others}"


def _shipped_in(path: Path) -> str:
    """The shipped cases whose names begin as a folder is called; empty for other folders."""
    names = _names_in(f"{path}/") if f"{path}/" in (GALLERY, HARD) else []
    return f"; shipped are {', '.join(names)}" if names else ""


def _no_such_case(source: str) -> str:
    if called_as_result(source):
        return _no_case_but(source)
    if isdir(source):
        return _no_case_but_a_folder(Path(source))
    if f"{source}/" in (GALLERY, HARD):
        return f"is no shipped case{_shipped_in(Path(source))}"
    names = shipped_case_names()
    inner = [f"{folder}{source}" for folder in (GALLERY, HARD) if f"{folder}{source}" in _names_in(folder)]
    hint = f" (did you mean {inner[0]}?)" if inner else did_you_mean(source, names)
    if isfile(source):  # False too for what no file can be called
        hint = f"; for the file write ./{source}"
    elif isfile(f"{source}.yaml"):
        hint = f"; did you mean the file {source}.yaml?"
    return f"is no shipped case{hint}; shipped are {', '.join(names)}; a file name ends in .yaml"


def _file(path: Path, name: str) -> SourceText:
    try:
        with open(path, "rb") as file:
            raw = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        raise CaseError([Problem(name, None, None, "", _unreadable(path, error))]) from None
    return SourceText(name, path.stem, decoded(raw, name), path.parent, str(path.resolve()))


def _unreadable(path: Path, error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        names = shipped_case_names()
        near = f"; the shipped case is called {path.stem}" if path.stem in names else _shipped_in(path)
        if str(path).startswith((HARD, GALLERY)):
            near = did_you_mean(str(path), [*hard_case_names(), *gallery_case_names()])
        return f"no such file{near}"
    if isinstance(error, IsADirectoryError):
        return _no_case_but_a_folder(path)
    return f"cannot be read: {getattr(error, 'strerror', None) or error}"


def case_name_from(stem: str) -> str:
    """A case's name from its file's name: what a name may not hold becomes "_"."""
    name = re.sub(r"[^A-Za-z0-9._+ -]", "_", stem).strip()[:80]
    return name if name[:1].isalnum() and name.isascii() else f"case{name}"[:80]


# Case files to one plain tree of texts: `extends` followed, child over parent, every place kept.


LONGEST_CHAIN = 8  # files that extend one another
FEW_KEYS = 3  # that may all be misspelt
OWN_KEYS = ("name", "title", "extends")  # not inherited: they speak of one file
BROKEN = object()  # a value that has been reported already


def read_tree(source: SourceText) -> Tree:
    """Read a case file and the files that it extends. What is wrong is left in `problems`."""
    tree = Tree({}, Place(source.shown, 1, 1))
    merged = _read_chain(source, [], tree)
    if merged is not None:
        _plain(merged, "", tree.values, tree)
    if not isinstance(tree.values.get("extends"), dict):
        tree.values.pop("extends", None)  # followed, or reported
    return tree


def _read_chain(source: SourceText, chain: list[str], tree: Tree) -> yaml_nodes_Mapping | None:
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
    parent = yaml_nodes_Mapping(
        own.place,
        {key: parent.values[key] for key in inherited},
        {key: parent.key_places[key] for key in inherited},
    )
    return _over(parent, own)


def _is_no_case(mapping: yaml_nodes_Mapping) -> bool:
    """Whether a file holds many keys, and none of a case: errors are not reported line by line then."""
    known = {*OWN_KEYS, "vibsim_case", *SHORT.sections, *LONG.sections}
    return len(mapping.values) > FEW_KEYS and known.isdisjoint(mapping.values)


def _parent(extends: Text, source: SourceText, chain: list[str], tree: Tree) -> yaml_nodes_Mapping | None:
    """The file that a file extends; None, with a problem at that line, where it cannot be read."""
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
    """A problem of a parent that cannot be read at all, reported at the line that names it."""
    if problem.line is not None:
        return problem
    return place.problem("extends", f"{shown(problem.file, limit=200)}: {problem.message}")


def _over(parent: yaml_nodes_Mapping, child: yaml_nodes_Mapping, key: str = "") -> yaml_nodes_Mapping:
    """Child over parent, key by key; lists, and an excitation of another kind, replace what was there."""
    replaced = given_way(key, _texts(parent), _texts(child))
    values = {name: value for name, value in parent.values.items() if name not in replaced}
    places = {name: parent.key_places[name] for name in values}
    for name, value in child.values.items():
        below = values.get(name)
        if (
            isinstance(below, yaml_nodes_Mapping)
            and isinstance(value, yaml_nodes_Mapping)
            and not _replaces(below, value)
        ):
            value = _over(below, value, f"{key}.{name}" if key else name)
        values[name] = value
        places[name] = child.key_places[name]
    return yaml_nodes_Mapping(child.place, values, places)


def _texts(mapping: yaml_nodes_Mapping) -> dict[str, Any]:
    """The values of a mapping that are texts, and its other keys."""
    return {name: node.text if isinstance(node, Text) else node for name, node in mapping.values.items()}


def _replaces(parent: yaml_nodes_Mapping, child: yaml_nodes_Mapping) -> bool:
    old, new = parent.values.get("kind"), child.values.get("kind")
    other_kind = new is not None and (
        not isinstance(old, Text) or not isinstance(new, Text) or old.text != new.text
    )
    return child.is_list or other_kind


def _plain(mapping: yaml_nodes_Mapping, prefix: str, values: dict[str, Any], tree: Tree) -> None:
    """Fill `values` with plain texts and dicts, and the places of the tree with where they stand."""
    for name, node in mapping.values.items():
        key = f"{prefix}{name}"
        tree.key_places[key] = mapping.key_places[name]
        tree.places[key] = node.place
        if isinstance(node, Text) and node.spelt:
            tree.spelt[key] = node.spelt
        values[name] = _plain_value(node, key, tree)


def _plain_value(node: Node, key: str, tree: Tree) -> Any:
    if isinstance(node, Text):
        return node.text
    if isinstance(node, Broken):
        return BROKEN
    inner: dict[str, Any] = {}
    _plain(node, f"{key}.", inner, tree)
    return inner


def put_tables_in(tree: Tree) -> None:
    """Put the CSV files that formulas name into them, as lists of pairs: a case holds all that it needs."""
    if not has_formulas(tree.values):
        return
    from vibsim.cases.formula_places import places_of

    for place in list(places_of(tree.values)):
        if "table" in place.text and any(quote in place.text for quote in "'\""):
            _put_table_in(tree, place.path, place.text)


def _put_table_in(tree: Tree, key: str, text: str) -> None:
    from vibsim.cases.formula_text import FormulaError, table_file, with_pairs

    folder = Path(tree.place(key).file).parent
    try:
        changed, places = with_pairs(text, lambda name: table_file(name, folder))
    except FormulaError as error:
        tree.problems.append(tree.place_inside(key, error.start).problem(key, str(error)))
        tree.values = with_leaf(tree.values, key.split("."), BROKEN)
        return
    if places:
        tree.texts[key], tree.tables[key] = text, places
        tree.values = with_leaf(tree.values, key.split("."), changed)


# Overrides such as excitation.Omega0=6.5 Hz, set into a tree as if the file said so.


FILE = "overrides"
STARTS = ("x", "v", "phi", "phidot")  # of bodies and rotors
PLACED = ("between", "on", "rate")  # an override that gives one of these makes a new part


def apply_overrides(tree: Tree, overrides: Mapping[str, object], known: Collection[str] = ()) -> None:
    """Set each override in the tree; unknown keys are added to its problems. Raises TypeError for what is no
    mapping from keys.

    known : keys of values that it has and may have; where all overrides are of these, no others are listed
    """
    if not isinstance(overrides, Mapping) or not all(isinstance(key, str) for key in overrides):
        raise TypeError(f"overrides must be a mapping such as {{'Omega0': '6 Hz'}}, got {overrides!r:.60}")
    if not overrides:
        return
    settings = [(key.strip(), value) for key, value in overrides.items()]
    present, allowed = _leaf_keys(tree.values), tuple(known)
    if not all(key in known for key, _ in settings):
        allowed = keys_of(form_of(tree.values), _with_new_parts(tree.values, [key for key, _ in settings]))
        allowed = *allowed, *_new_numbers(tree.values, settings, present, allowed)
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
        value = _with_unit(tree.values, key, value)
        tree.values = with_leaf(tree.values, key.split("."), value)
        tree.places[key] = tree.key_places[key] = Place(FILE)
        tree.spelt.pop(key, None)


def _with_unit(values: dict[str, Any], key: str, value: object) -> object:
    """A bare number in place of one beside a formula, or of a parameter, is in the SI unit of that."""
    if not isinstance(value, str | int | float) or BARE.fullmatch(value_text(value)) is None:
        return value
    old: Any = values
    for name in key.split("."):
        old = old.get(name) if isinstance(old, dict) else None
    form = form_of(values)
    known = all_keys(form).get(form.pattern(key)) is not None and not is_free(values, key)
    if old is None or known or isinstance(old, dict):
        return value
    from vibsim.cases.any_unit import bare_as

    return bare_as(str(old), value_text(value))


BARE = re.compile(rf"\s*{NUMBER}(\s*/\s*\d+)?\s*", re.ASCII)


def _with_new_parts(values: dict[str, Any], keys: Iterable[str]) -> dict[str, Any]:
    """The values with the parts that overrides may add: those whose ends or body they give, and states."""
    form = form_of(values)
    for key in keys:
        section, *names = _start_of_part(values, key).split(".")
        places = names[1:2] and (names[1] in PLACED or section == "initial")
        if section in form.named and len(names) > 1 and places:
            parts = values.get(section)
            if names[0] not in (parts if isinstance(parts, dict) else {}):
                values = with_leaf(values, [section, names[0], names[1]], "")
    return values


def _start_of_part(values: Mapping[str, Any], key: str) -> str:
    """The dotted key of an initial value that is written by the name of its part alone (ram.x), whether
    or not the file gives it; any other key as it is.
    """
    name, _, state = key.partition(".")
    parts = [section for section in (values.get("bodies"), values.get("rotors")) if isinstance(section, dict)]
    is_part = any(name in section for section in parts) or (name == "motor" and "motor" in values)
    return f"initial.{key}" if is_part and state in STARTS else key


def _new_numbers(
    values: dict[str, Any], settings: list[tuple[str, object]], present: list[str], allowed: tuple[str, ...]
) -> list[str]:
    """Dotted keys of numbers that overrides may add: parameters, and what formulas name beside them."""
    keys = [key for key, _ in settings if key.startswith("parameters.")]
    for key, value in settings:
        if not isinstance(value, str | Formula):
            continue
        try:
            full = full_key(key, present, allowed)
        except UnknownKeyError:
            continue
        section = full.partition(".")[0]
        last = full.rpartition(".")[2]
        if any(one.key == last for one in FORMULA_KEYS.get(section, ())) and (
            last in ALWAYS or isinstance(value, Formula) or is_formula(value)
        ):
            keys += _named_beside(full, str(value))
    if has_formulas(values):
        from vibsim.cases.formula_places import places_of

        for place in places_of(values):
            keys += _named_beside(place.path, place.text)
    return [key for key in dict.fromkeys(keys) if key not in allowed]


def _named_beside(path: str, text: str) -> list[str]:
    from vibsim.cases.formula_text import names_in

    return [f"{path.rpartition('.')[0]}.{name}" for name in names_in(text)]


def _supersede(tree: Tree, named: Mapping[str, object]) -> None:
    """Take out what the overrides put something else in place of."""
    split = [key.split(".") for key in named]
    parts = [".".join(path[:depth]) for path in split for depth in range(1, len(path))]
    for part in dict.fromkeys(parts):
        given = {key[len(part) + 1 :]: value for key, value in named.items() if key.startswith(f"{part}.")}
        section: Any = tree.values
        for name in part.split("."):
            section = section.get(name) if isinstance(section, dict) else None
        old = section if isinstance(section, dict) else {}
        replaced = given_way(part, old, {name.partition(".")[0]: value for name, value in given.items()})
        if replaced and isinstance(section, dict):
            remaining = {name: value for name, value in section.items() if name not in replaced}
            tree.values = with_leaf(tree.values, part.split("."), remaining)


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


def with_leaf(values: dict[str, Any], path: list[str], value: object) -> dict[str, Any]:
    """A copy with values["a"]["b"] = value for ["a", "b"]; a section that is none starts empty."""
    name, *rest = path
    if rest:
        inner = values.get(name)
        return values | {name: with_leaf(inner if isinstance(inner, dict) else {}, rest, value)}
    return values | {
        name: value if isinstance(value, str | dict | Formula) or value is BROKEN else value_text(value)
    }


def value_text(value: object) -> str:
    """A number given from Python as text; repr of a float, also one of numpy, is its shortest decimal."""
    return repr(float(value)) if isinstance(value, float) else str(value)
