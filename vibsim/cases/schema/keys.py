"""The keys that the schema knows: those of a section, all of them, and what a short key stands for."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Annotated, Any, get_args, get_origin

from vibsim.cases.schema.forms import LONG, NAME, SHORT, Form
from vibsim.cases.schema.kinds import Tag
from vibsim.cases.schema.measured import Measured
from vibsim.cases.schema.sections import Key, Section
from vibsim.cases.spelling import did_you_mean, nearest, unsupported


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


def measured_at(key: str) -> Measured | None:
    """What is measured at the dotted key of a number, in either form of case."""
    if key in all_keys():
        return all_keys()[key]
    return all_keys(LONG).get(LONG.pattern(key))


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
        return *all_keys(), *form.sections
    keys = [key for pattern in all_keys(form) for key in _with_names(pattern.split("."), values)]
    parts = [f"{section}.{name}" for section in form.named for name in _names(values.get(section))]
    return tuple(dict.fromkeys((*keys, *parts, *form.sections)))


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
    """The key whose end is nearest to what was typed, or the one whose last name is."""
    for typed in (key, key.rpartition(".")[2]):
        depth = typed.count(".") + 1
        ends = {".".join(name.split(".")[-depth:]): name for name in reversed(allowed)}
        match = nearest(typed, ends)
        if match:
            return f" (did you mean {ends[match]}?)"
    return did_you_mean(key, allowed)
