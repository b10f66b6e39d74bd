"""A case as YAML text in which every key says what it is: a file to start one's own from.

The comments are the descriptions of the schema. Keys that may be left out and are stand in comments, with an
example.
"""

import textwrap
from collections.abc import Iterator
from typing import Any

from vibsim.cases.case import Case
from vibsim.cases.parts.text import HEAD, flow, scalar
from vibsim.cases.resolved import nested_values
from vibsim.cases.schema.keys import holds_names, section_models
from vibsim.cases.schema.sections import Section

COLUMN = 34  # where comments begin
LONGEST = 96  # characters of a line of a comment


def commented_text(case: Case, name: str) -> str:
    """The text, to be a file called `name`; reads back to the same motion."""
    return "\n".join([*_head(case, name), *_sections(case)]) + "\n"


def _head(case: Case, name: str) -> Iterator[str]:
    yield f"# A case of vibsim, begun from {case.name}."
    yield "#"
    yield f"#   vibsim check {name}            is everything right?"
    yield f"#   vibsim cases {name} --draw     what the machine looks like"
    yield f"#   vibsim run {name}"
    yield "#"
    yield "# Numbers without a unit are SI; angular rates need one (Hz, rpm, rad/s)."
    yield ""
    yield _line("", f"title: {scalar(case.title or case.name)}", "one line on what the case shows")


def _sections(case: Case) -> Iterator[str]:
    values, model = nested_values(case.model), case.model
    for section, field in type(model).keys.items():
        if section in (*HEAD, "extends"):
            continue
        yield ""
        if not values.get(section):
            yield "\n#   ".join(textwrap.wrap(f"# {section}: {field.description}", COLUMN + LONGEST))
        elif holds_names(field.annotation):
            yield _line("", f"{section}:", field.description)
            yield from _parts(field.annotation, values[section])
        else:
            content = type(getattr(model, section))
            yield _line("", f"{section}:", _summary(content))
            yield from _keys(content, "  ", values[section], suggest=False)


def _parts(annotation: Any, parts: dict[str, Any]) -> Iterator[str]:
    """Parts by name; what the keys mean, and which more there are, is said at the first."""
    models = [model for _, model in section_models(annotation)]
    for number, (name, part) in enumerate(parts.items()):
        if not models:
            yield f"  {scalar(name)}: {flow(part)}"
            continue
        yield f"  {scalar(name)}:"
        yield from _keys(models[0], "    ", part, say=number == 0, suggest=number == 0)


def _keys(
    model: type[Section], indent: str, values: dict[str, Any], say: bool = True, suggest: bool = True
) -> Iterator[str]:
    """The keys of a section, those that it may have too.

    say : whether to tell what the keys mean; suggest : whether to name those that it has not, with an example
    """
    for key, field in model.keys.items():
        if key in values:
            yield _line(indent, f"{key}: {flow(values[key], key)}", field.description if say else "")
        elif suggest and field.examples:
            yield _line(indent, f"# {key}: {field.examples[0]}", field.description)


def _line(indent: str, text: str, comment: str | None) -> str:
    """A key and what it means; a meaning that is longer than a line goes on below, in the same column."""
    line = f"{indent}{text}"
    if not comment:
        return line
    first, *more = textwrap.wrap(comment, LONGEST)
    return "\n".join([f"{line:{COLUMN}}  # {first}", *(f"{'':{COLUMN}}  #   {rest}" for rest in more)])


def _summary(model: type[Section]) -> str:
    return (model.__doc__ or "").strip().splitlines()[0]
