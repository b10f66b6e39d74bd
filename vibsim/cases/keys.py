"""The keys that the schema knows: those of a section, all of them, and what a short key stands for."""

from collections.abc import Iterable, Iterator
from functools import cache
from typing import Annotated, Any, get_args, get_origin

from pydantic import Tag

from vibsim.cases.measured import Measured
from vibsim.cases.schema import CaseFile, Section
from vibsim.cases.spelling import did_you_mean, nearest


class UnknownKeyError(KeyError):
    """A key that no case has, or a short key that stands for several; the message names the nearest."""

    def __str__(self) -> str:
        return str(self.args[0])


def is_tag(part: object) -> bool:
    """True for the part of a pydantic location that names a variant, such as "(motor)"."""
    return str(part).startswith("(")


def section_models(annotation: Any, tag: str = "") -> Iterator[tuple[str, type[Section]]]:
    """The sections inside a field's annotation, each with its variant's tag (empty for an only one)."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        yield tag, annotation
        return
    if get_origin(annotation) is Annotated:
        tag = next((item.tag for item in annotation.__metadata__ if isinstance(item, Tag)), tag)
    for argument in get_args(annotation):
        yield from section_models(argument, tag)


def section_at(location: tuple[Any, ...]) -> type[Section] | None:
    """The section at a pydantic location such as ("excitation", "(motor)"); None for a single value."""
    models: dict[str, type[Section]] = {"": CaseFile}
    for part in location:
        if is_tag(part):
            models = {"": models[part]} if part in models else {}
        else:
            fields = models[""].model_fields if "" in models else {}
            models = dict(section_models(fields[part].annotation)) if part in fields else {}
    return models.get("")


def _leaves(model: type[Section], prefix: str) -> Iterator[tuple[str, Measured | None]]:
    for name, field in model.model_fields.items():
        key = f"{prefix}{name}"
        inner = list(section_models(field.annotation))
        for _, section in inner:
            yield from _leaves(section, f"{key}.")
        measured = _measured(field)
        if measured or not inner:
            yield key, measured


def _measured(field: Any) -> Measured | None:
    """The Measured annotation of a field, or of one of the variants of its value."""
    for item in field.metadata:
        if isinstance(item, Measured):
            return item
    return _measured_inside(field.annotation)


def _measured_inside(annotation: Any) -> Measured | None:
    for item in getattr(annotation, "__metadata__", ()):
        if isinstance(item, Measured):
            return item
    return next(filter(None, map(_measured_inside, get_args(annotation))), None)


@cache
def all_keys() -> dict[str, Measured | None]:
    """Every dotted key of a value, with what is measured there (None for words and whole numbers)."""
    table: dict[str, Measured | None] = {}
    for key, measured in _leaves(CaseFile, ""):
        table[key] = table.get(key) or measured
    return table


@cache
def section_names() -> tuple[str, ...]:
    """Names of the sections of a case file, in file order."""
    return tuple(
        name for name, field in CaseFile.model_fields.items() if any(section_models(field.annotation))
    )


@cache
def sections_with(name: str) -> tuple[str, ...]:
    """The sections that have a key of this name: ("excitation (kind motor)",) for Omega0."""
    return tuple(_sections_with(name, CaseFile, "", ""))


def _sections_with(name: str, model: type[Section], path: str, kind: str) -> Iterator[str]:
    if path and name in model.model_fields:
        yield path[1:] + kind
    for key, field in model.model_fields.items():
        for tag, section in section_models(field.annotation):
            variant = kind if tag in ("", "(rule)") else f" (kind {tag[1:-1]})"
            yield from _sections_with(name, section, f"{path}.{key}", variant)


def full_key(key: str, present: Iterable[str] = ()) -> str:
    """The dotted key that `key` stands for: itself, or the only one that ends in it (Omega0).

    Keys that are `present` in a case win over those that it has not got. Raises UnknownKeyError.
    """
    if key in all_keys() or key in section_names():
        return key
    for candidates in (present, all_keys()):
        found = [name for name in candidates if name.endswith(f".{key}")]
        if len(found) == 1:
            return found[0]
        if found:
            raise UnknownKeyError(f"is short for several keys: {', '.join(found)}")
    raise UnknownKeyError(f"unknown key{_hint(key)}; a key is written like excitation.Omega0 or run.t_end")


def _hint(key: str) -> str:
    """The nearest dotted key, or the dotted key whose last name is nearest."""
    short = {name.rpartition(".")[2]: name for name in reversed(all_keys())}
    match = nearest(key, [*all_keys(), *section_names()]) or short.get(nearest(key, short) or "")
    if not match and "." in key:
        last = nearest(key.rpartition(".")[2], short)
        match = short.get(last) if last else None
    return f" (did you mean {match}?)" if match else did_you_mean(key, section_names())
