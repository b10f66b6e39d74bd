"""The two forms of a case: the short one of the paper's two blocks, and the long one of named parts."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Annotated, Any, NamedTuple, get_args, get_origin

from vibsim.cases.problems import Problem, did_you_mean, nearest, shown, superseded, unsupported
from vibsim.cases.quantities import Quantity, is_inertia
from vibsim.cases.schema import REFERENCE, CaseFile, CaseHead, Key, Section
from vibsim.cases.schema_kinds import FORMULA_KEYS, ONE_PART, Json, Measured, Tag, of_part, sides_of
from vibsim.cases.yaml_nodes import Place

SWITCHED_OFF = "none"
NAME = "*"  # stands for the name of a body or part in the keys of the long form


class Form(NamedTuple):
    """One way to write a case.

    Attributes
    ----------
    called : what messages call it
    sections : its sections, in file order
    own : the sections that the other form has not
    switchable : sections that may be the word none
    named : sections that hold parts by name; `--set stops.wall=none` takes one out
    torsional : whether all bodies turn: displacements are angles, forces torques
    mixed : whether some of them do
    """

    called: str
    sections: tuple[str, ...]
    own: tuple[str, ...]
    switchable: tuple[str, ...]
    named: tuple[str, ...] = ()
    torsional: bool = False
    mixed: bool = False

    @property
    def model(self) -> type[CaseHead]:
        """The outermost section; that of the long form is imported when the first case of parts is read."""
        if self is SHORT:
            return CaseFile
        from vibsim.cases.part_schema import PartsFile, turning_file

        return turning_file(self.mixed) if self.torsional or self.mixed else PartsFile

    def without_switched_off(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values of a tree without sections, and parts, that are the word none."""
        present = {
            name: value
            for name, value in values.items()
            if not (name in self.switchable and value == SWITCHED_OFF)
        }
        for section in self.named:
            if isinstance(present.get(section), dict):
                parts = present[section].items()
                present[section] = {name: part for name, part in parts if part != SWITCHED_OFF}
        return present

    def pattern(self, key: str) -> str:
        """A dotted key with NAME in place of the names of parts and the numbers of terms."""
        parts = key.split(".")
        if parts[0] in self.named and len(parts) > 1:
            parts[1] = NAME
        for i, part in enumerate(parts[:-1]):
            if part == "terms":
                parts[i + 1] = NAME
        return ".".join(parts)


SHORT = Form(
    "short",
    ("parameters", "blocks", "coupling", "stop", "friction", "excitation", "initial", "rest_distance", "run"),
    ("blocks", "coupling", "stop", "excitation", "rest_distance"),
    ("parameters", "stop", "friction", "excitation", "initial", "rest_distance", "run"),
    ("parameters",),
)
LONG = Form(
    "long",
    (
        *("parameters", "bodies", "links", "stops", "friction", "forces", "states", "rotors"),
        *("base", "motor", "initial", "clearances", "run"),
    ),
    ("bodies", "links", "stops", "forces", "states", "rotors", "base", "motor", "clearances"),
    (
        *("parameters", "links", "stops", "friction", "forces", "states", "rotors"),
        *("base", "motor", "initial", "clearances", "run"),
    ),
    (
        *("parameters", "bodies", "links", "stops", "friction", "forces", "states", "rotors"),
        *("initial", "clearances"),
    ),
)
TORSIONAL = LONG._replace(torsional=True)
MIXED = LONG._replace(mixed=True)


_OWN = (*SHORT.own, *LONG.own)
_COMMON = {"extends", "name", "title", *(name for name in SHORT.sections if name in LONG.sections)}


def form_of(values: Mapping[str, Any]) -> Form:
    """The form of a case's sections: long with bodies, or where only the long form has what is there.

    Of sections that neither has, misspelt ones, the form is that of the nearest name.
    """
    if "bodies" in values:
        turn = [is_inertia(str(mass)) for mass in _masses(values["bodies"])]
        return LONG if not any(turn) else TORSIONAL if all(turn) else MIXED
    names = {name if name in _OWN else nearest(name, _OWN) for name in values if name not in _COMMON}
    is_long = any(name in LONG.own for name in names) and not any(name in SHORT.own for name in names)
    return LONG if is_long else SHORT


def _masses(bodies: Any) -> Iterable[Any]:
    return bodies.values() if isinstance(bodies, Mapping) else ()


def _other(form: Form) -> Form:
    return LONG if form is SHORT else SHORT


def mixed_keys(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Sections that the other form has and that of the case has not."""
    other = _other(form_of(values))
    return tuple(name for name in values if name in other.own)


def of_one_form(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values that can be judged: in a mixed case neither those of the other form nor those of both."""
    foreign = mixed_keys(values)
    ambiguous = (*foreign, "friction", "initial") if foreign else ()
    return {name: value for name, value in values.items() if name not in ambiguous}


def mixed_problems(values: Mapping[str, Any], place: Any) -> Iterator[Problem]:
    """Problems of a case that mixes the forms; place : key -> Place of the key."""
    form = form_of(values)
    for name in mixed_keys(values):
        at: Place = place(name)
        message = (
            f"belongs to the {_other(form).called} form of a case, and this one has the "
            f"{form.called} form{did_you_mean(name, form.sections)}; allowed: {', '.join(form.model.keys)}"
        )
        yield at.problem(name, message)


# The JSON Schema of a case file, for editors and other programs.


DIALECT = "https://json-schema.org/draft/2020-12/schema"
PART = "Part"  # ending of the sections of a file that extends another: nothing in them is required


def case_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a case file: keys, units, ranges, defaults, examples.

    A case with bodies has the long form, any other the short one. A file that extends another may leave out
    any key; one that does not needs the required ones.
    """
    sections: dict[str, Json] = {}
    short, long = (_form_schema(form, sections) for form in (SHORT, LONG))
    sections = {name: _lists_of_terms(sections[name]) for name in sorted(sections)}
    return {
        "$schema": DIALECT,
        "title": "vibsim case",
        "description": "A vibro-impact system and one run of it.",
        "if": {"required": ["extends"]},
        "then": {"anyOf": [_part(short), _part(long)]},
        "else": {"if": {"required": ["bodies"]}, "then": long, "else": short},
        "$defs": sections | {name + PART: _part(section) for name, section in sections.items()},
    }


def _form_schema(form: Form, sections: dict[str, Json]) -> Json:
    """JSON Schema of one form of case; those of the sections in it are put into `sections`."""
    whole = form.model.json_schema(sections)
    properties = whole["properties"]
    for name in form.named:
        properties[name]["additionalProperties"] = _switchable(properties[name]["additionalProperties"])
    for name in form.switchable:
        properties[name] = _switchable(properties[name])
    return whole


def _lists_of_terms(schema: Any) -> Any:
    """The harmonics of a source are a list in the file; inside they go by their numbers."""
    if isinstance(schema, list):
        return [*map(_lists_of_terms, schema)]
    if not isinstance(schema, dict):
        return schema
    schema = {key: _lists_of_terms(value) for key, value in schema.items()}
    terms = schema.get("terms")
    if isinstance(terms, dict) and "additionalProperties" in terms:
        items, description = terms["additionalProperties"], terms["description"]
        schema["terms"] = {"type": "array", "items": items, "minItems": 1, "description": description}
    return schema


def _switchable(section: dict[str, Any]) -> dict[str, Any]:
    """A section that may also be the word none; which takes out what it inherits."""
    section = dict(section)
    choices = section.pop("anyOf", None) or section.pop("oneOf", None)
    if choices is None:
        names = ("$ref", "type", "additionalProperties")
        choices = [{name: section.pop(name) for name in names if name in section}]
    return {"anyOf": [*choices, {"const": SWITCHED_OFF}]} | section


def _part(schema: Any) -> Any:
    """A copy in which nothing is required and every reference leads to such a copy."""
    if isinstance(schema, dict):
        return {key: _part(value) for key, value in schema.items() if key != "required"}
    if isinstance(schema, str) and schema.startswith(REFERENCE):
        return schema + PART
    return [*map(_part, schema)] if isinstance(schema, list) else schema


# The keys that the schema knows: those of a section, all of them, and what a short key stands for.


class UnknownKeyError(KeyError):
    """A key that no case has, or a short key that stands for several; the message names the nearest."""

    def __str__(self) -> str:
        return str(self.args[0])


def is_tag(part: object) -> bool:
    """True for the part of a location that names a variant, such as "(motor)"."""
    return str(part).startswith("(")


def section_models(annotation: Any, tag: str = "") -> Iterator[tuple[str, type[Section]]]:
    """The sections inside a field's annotation, each with its variant's tag (empty for an only one)."""
    # of Python 3.10 dict[str, Link] is a type too, but no class
    if get_origin(annotation) is None and isinstance(annotation, type) and issubclass(annotation, Section):
        yield tag, annotation
        return
    if get_origin(annotation) is Annotated:
        tag = next((item.tag for item in annotation.__metadata__ if isinstance(item, Tag)), tag)
    for argument in get_args(annotation):
        yield from section_models(argument, tag)


def holds_names(annotation: Any) -> bool:
    """True for a field of parts by name, or of terms by number."""
    return get_origin(annotation) is dict or any(map(holds_names, get_args(annotation)))


def section_at(location: tuple[Any, ...], form: Form = SHORT) -> type[Section] | None:
    """The section at a location such as ("excitation", "(motor)"); None for a single value."""
    models: dict[str, type[Section]] = {"": form.model}
    parts = iter(location)
    for part in parts:
        if is_tag(part):
            models = {"": models[part]} if part in models else {}
            continue
        fields = models[""].keys if "" in models else {}
        models = dict(section_models(fields[part].annotation)) if part in fields else {}
        if part in fields and holds_names(fields[part].annotation) and next(parts, None) is None:
            return None
    return models.get("")


def _leaves(model: type[Section], prefix: str) -> Iterator[tuple[str, Measured | None]]:
    for name, field in model.keys.items():
        key = f"{prefix}{name}.{NAME}" if holds_names(field.annotation) else f"{prefix}{name}"
        inner = list(section_models(field.annotation))
        for _, section in inner:
            yield from _leaves(section, f"{key}.")
        measured = measured_in(field)
        if measured or not inner:
            yield key, measured


def measured_in(key: Key) -> Measured | None:
    """The Measured annotation of a key, or of one of the variants of its value."""
    return _measured_inside(key.annotation)


def _measured_inside(annotation: Any) -> Measured | None:
    for item in getattr(annotation, "__metadata__", ()):
        if isinstance(item, Measured):
            return item
    return next(filter(None, map(_measured_inside, get_args(annotation))), None)


@cache
def all_keys(form: Form = SHORT) -> dict[str, Measured | None]:
    """Every dotted key of a value, with what is measured there (None for words and whole numbers).

    In the long form with "*" for the names of bodies and parts: stops.*.k.
    """
    table: dict[str, Measured | None] = {}
    for key, measured in _leaves(form.model, ""):
        table[key] = table.get(key) or measured
    return table


@cache
def sections_with(name: str, form: Form = SHORT) -> tuple[str, ...]:
    """The sections that have a key of this name: ("excitation (kind motor)",) for Omega0."""
    return tuple(dict.fromkeys(_sections_with(name, form.model, "", "")))


def _sections_with(name: str, model: type[Section], path: str, kind: str) -> Iterator[str]:
    if path and name in model.keys:
        yield path[1:] + kind
    for key, field in model.keys.items():
        inner = f"{path}.{key}.NAME" if holds_names(field.annotation) else f"{path}.{key}"
        for tag, section in section_models(field.annotation):
            variant = kind if tag in ("", "(rule)") else f" (kind {tag[1:-1]})"
            yield from _sections_with(name, section, inner, variant)


def keys_of(form: Form, values: Mapping[str, Any]) -> tuple[str, ...]:
    """Every dotted key that may be set in a case of these (nested) values, sections and parts included."""
    if form is SHORT:
        keys = [key for key in all_keys() if NAME not in key]
        given = [f"parameters.{name}" for name in _names(values.get("parameters"))]
        return *keys, *given, *_beside_formulas(values), *form.sections
    keys = [key for pattern in all_keys(form) for key in _with_names(pattern.split("."), values)]
    parts = [f"{section}.{name}" for section in form.named for name in _names(values.get(section))]
    return tuple(dict.fromkeys((*keys, *_beside_formulas(values), *parts, *form.sections)))


def _beside_formulas(values: Mapping[str, Any]) -> Iterator[str]:
    """Dotted keys of what stands beside formulas."""
    for section in FORMULA_KEYS:
        content = values.get(section)
        if not isinstance(content, Mapping):
            continue
        parts = (
            {section: content} if section in ONE_PART else {f"{section}.{n}": p for n, p in content.items()}
        )
        for path, part in parts.items():
            sides = sides_of(section, part)
            if of_part(section, part):
                yield from (f"{path}.{key}" for key, value in part.items() if not isinstance(value, Mapping))
            for side in sides:
                yield from (f"{path}.{side}.{key}" for key in part[side])


def given_way(part: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> set[str]:
    """Keys of a part that give way when others are set over it: those that these stand in place of, and where
    a formula comes or goes, numbers that no formula names any more.

    part : dotted key; old, new : values of its keys, texts
    """
    section, *names = part.split(".")
    is_part = section in FORMULA_KEYS and len(names) == (0 if section in ONE_PART else 1)
    merged = {**old, **new}
    before, after = (of_part(section, values) if is_part else [] for values in (old, merged))
    if not before and not after:
        return superseded(part, new.keys())
    changed = [one for one in FORMULA_KEYS[section] if one.key in new and (one in before or one in after)]
    if not changed:
        return set()
    from vibsim.cases.formula_text import names_in

    named = {word for one in after for word in names_in(str(merged[one.key]))}
    replaced = {name for one in changed for name in (*one.numbers, *one.excluded)}
    if any(one.key == "mu" for one in changed):
        replaced |= {"plus", "minus"}
    form = LONG if section != "excitation" else SHORT
    known = all_keys(form)
    free = {name for name in old if form.pattern(f"{part}.{name}") not in known and name not in SIDE_SECTIONS}
    return {name for name in old if name in replaced | free and name not in named and name not in new}


SIDE_SECTIONS = ("plus", "minus", "terms", "A")  # keys of parts that hold keys of their own


def measured_in_case(values: Mapping[str, Any], key: str, quantity: Quantity) -> Measured | None:
    """Quantity measured by the number at a dotted key of a case; beside a formula from its unit."""
    form = form_of(values)
    known = all_keys(form).get(form.pattern(key))
    if known is not None and not is_free(values, key):
        return known
    from vibsim.cases.any_unit import free_dimension

    return Measured(free_dimension(quantity), any_unit=True)


def is_free(values: Mapping[str, Any], key: str) -> bool:
    """Whether the number at a dotted key is one of a formula beside it, in place of a built-in law."""
    section, *names = key.split(".")
    part: Any = values.get(section)
    if section not in ONE_PART:
        part = part.get(names[0]) if isinstance(part, Mapping) else None
    active = of_part(section, part)
    if len(names) > 1 and names[-2] in sides_of(section, part):
        active = sides_of(section, part)[names[-2]]
    return any(names[-1] in one.numbers for one in active)


def _with_names(pattern: list[str], values: Any, done: str = "") -> Iterator[str]:
    """The keys that a pattern stands for: one for each name that the values have in its place."""
    if not pattern:
        yield done[1:]
        return
    first, *rest = pattern
    names = _names(values) if first == NAME else (first,)
    for name in names:
        inner = values.get(name) if isinstance(values, Mapping) else None
        yield from _with_names(rest, inner, f"{done}.{name}")


def _names(section: Any) -> tuple[str, ...]:
    return tuple(section) if isinstance(section, Mapping) else ()


def full_key(key: str, present: Iterable[str] = (), allowed: Iterable[str] | None = None) -> str:
    """The dotted key that `key` stands for: itself, or the only one that ends in it (Omega0).

    Keys that are `present` in a case win over all others. allowed : all keys that may be
    set; by default those of the short form. Raises UnknownKeyError.
    """
    allowed = keys_of(SHORT, {}) if allowed is None else tuple(allowed)
    if key in allowed:
        return key
    for candidates in (present, allowed):
        matching = [name for name in candidates if name.endswith(f".{key}")]
        if len(matching) == 1:
            return matching[0]
        if matching:
            raise UnknownKeyError(f"is short for several keys: {', '.join(matching)}")
    if limit := unsupported(key.rpartition(".")[2]):
        raise UnknownKeyError(limit)
    example = "excitation.Omega0" if "excitation.Omega0" in allowed else "stops.wall.k"
    raise UnknownKeyError(f"unknown key{_hint(key, allowed)}; a key is written like {example} or run.t_end")


def _hint(key: str, allowed: tuple[str, ...]) -> str:
    """The key whose end is nearest to what was typed, or the one whose last name is; of a part that is there
    its own keys alone.
    """
    part, _, name = key.rpartition(".")
    known = [(path, last) for path, _, last in (one.rpartition(".") for one in allowed)]
    around = next((path for path, _ in known if part and f".{path}".endswith(f".{part}")), None)
    if around is not None:
        names = [last for path, last in known if path == around]
        begun = [one for one in names if one.startswith(name) or name[:-1] == one]  # gap by g, k by kk
        match = nearest(name, names) or (begun[0] if len(begun) == 1 else None)
        takes = "" if around.startswith("initial.") else f"; {around} takes {shown(', '.join(names), 200)}"
        return f" (did you mean {around}.{match}?)" if match else takes
    for typed in (key, key.rpartition(".")[2]):
        depth = typed.count(".") + 1
        ends = {".".join(name.split(".")[-depth:]): name for name in reversed(allowed)}
        match = nearest(typed, ends)
        if match:
            return f" (did you mean {ends[match]}?)"
    return did_you_mean(key, allowed)
