"""The reference of case keys: every section of the schema as a table of its keys."""

from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin

from from_code.markdown import code, plain, table
from vibsim.cases.quantities import FACTORS, FACTORS_IN_TURNS, unit_names
from vibsim.cases.schema import Section
from vibsim.cases.schema_keys import LONG, SHORT, Form, holds_names, measured_in, section_models
from vibsim.cases.schema_kinds import Measured

HEAD = """# Case keys

Every key of a case file, from the schema that checks them; `vibsim schema` prints the same as JSON Schema.
How the parts act is told in [Scenes](../scenes.md), how a case file is written in
[A case of your own](../tutorials/own-case.md).

A bare number is SI; an angular rate needs its unit, because Hz and rad/s are mixed up too easily. Fractions
such as `1/60 s` are exact.
"""
FORMS = {
    "short": "The short form: the paper's two blocks",
    "long": "The long form: named parts",
}
COLUMNS = ("key", "meaning", "quantity", "default", "example")


def page() -> str:
    """The page of both forms and of the units."""
    sections = [text for form in (SHORT, LONG) for text in _form(form)]
    return "\n".join([HEAD, *sections, _units()])


def _form(form: Form) -> Iterator[str]:
    yield f"## {FORMS[form.called]}\n"
    yield from _section(form, form.model, "")


def _section(form: Form, model: type[Section], path: str, tag: str = "") -> Iterator[str]:
    """A section's table, and those of the sections in it; path : dotted, NAME for the names of parts."""
    if path:
        yield f"### {code(path)}{f' (kind {tag[1:-1]})' if tag not in ('', '(rule)') else ''}\n"
        yield _description(model) + "\n"
    yield table(COLUMNS, [_row(name, field) for name, field in model.keys.items()])
    for name, field in model.keys.items():
        for inner_tag, section in section_models(field.annotation):
            inner = f"{path}.{name}".lstrip(".") + (".NAME" if holds_names(field.annotation) else "")
            yield from _section(form, section, inner, inner_tag)


def _description(model: type[Section]) -> str:
    return plain(model.__doc__ or "")


def _row(name: str, field: Any) -> tuple[str, ...]:
    measured = measured_in(field)
    examples = [code(str(example)) for example in field.examples or () if example != field.default]
    return (
        code(name),
        plain(field.description or _description_of_only(field)),
        _quantity(field, measured),
        _default(field),
        ", ".join(examples),
    )


def _description_of_only(field: Any) -> str:
    """What a section without a description of its key is for."""
    models = [model for _, model in section_models(field.annotation)]
    return models[0].__doc__ or "" if models else ""


def _quantity(field: Any, measured: Measured | None) -> str:
    """Dimension and bounds of a number, or the words that may stand there."""
    if measured is None:
        return " or ".join(map(code, _words(field.annotation)))
    bounds = [
        text
        for text in (
            measured.above and f"> {measured.above}",
            measured.least and f">= {measured.least}",
            measured.most and f"<= {measured.most}",
            "not 0" if measured.nonzero else "",
            f"or the word {measured.word}" if measured.word else "",
        )
        if text
    ]
    return plain(", ".join([measured.dimension, *bounds]))


def _words(annotation: Any) -> Iterator[str]:
    if get_origin(annotation) is Literal:
        yield from map(str, get_args(annotation))
        return
    for argument in get_args(annotation):
        yield from _words(argument)


def _default(field: Any) -> str:
    if field.is_required():
        return "required"
    return code(str(field.default)) if isinstance(field.default, str | int) and field.default != "" else ""


def _turns(dimension: str) -> str:
    """What is said of units that count turns."""
    return "turns are exact: 5.5 Hz is 11/2" if dimension in FACTORS_IN_TURNS else ""


def _units() -> str:
    """The units that each dimension takes."""
    names = [name for name in FACTORS if unit_names(name)]
    rows = [(plain(name), ", ".join(map(code, unit_names(name))), _turns(name)) for name in names]
    return "## Units\n\n" + table(("quantity", "units, SI first unless it is an angular rate", ""), rows)
