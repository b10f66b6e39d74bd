"""The JSON Schema of a case file, for editors and other programs."""

from typing import Any

from vibsim.cases.schema.forms import LONG, SHORT, SWITCHED_OFF, Form
from vibsim.cases.schema.kinds import Json
from vibsim.cases.schema.sections import REFERENCE

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
