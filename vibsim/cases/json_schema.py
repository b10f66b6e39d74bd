"""The JSON Schema of a case file, for editors and other programs."""

from typing import Any

from vibsim.cases.file_tree import SWITCHABLE, SWITCHED_OFF
from vibsim.cases.schema import CaseFile

DIALECT = "https://json-schema.org/draft/2020-12/schema"
REFERENCE = "#/$defs/"
PART = "Part"  # ending of the sections of a file that extends another: nothing in them is required


def case_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a case file: keys, units, ranges, defaults, examples.

    A file that extends another may leave out any key; one that does not needs the required ones.
    """
    whole = _without_titles(CaseFile.model_json_schema())
    sections = whole.pop("$defs")
    extends = CaseFile.model_fields["extends"]
    whole["properties"]["extends"] = {"type": "string", "description": extends.description}
    for name in SWITCHABLE:
        whole["properties"][name] = _switchable(whole["properties"][name])
    return {
        "$schema": DIALECT,
        "title": "vibsim case",
        "description": whole.pop("description"),
        "if": {"required": ["extends"]},
        "then": _part(whole),
        "else": whole,
        "$defs": sections | {name + PART: _part(section) for name, section in sections.items()},
    }


def _switchable(section: dict[str, Any]) -> dict[str, Any]:
    """A section that may also be the word none; in a file that word stands where pydantic says null."""
    choices = section.pop("anyOf", None) or section.pop("oneOf", None) or [{"$ref": section.pop("$ref")}]
    section.pop("default", None)
    return {
        "anyOf": [choice for choice in choices if choice != {"type": "null"}] + [{"const": SWITCHED_OFF}]
    } | section


def _without_titles(schema: Any) -> Any:
    """Drop the titles that pydantic makes up from the names of keys and sections."""
    if isinstance(schema, dict):
        kept = (key for key, value in schema.items() if key != "title" or isinstance(value, dict))
        return {key: _without_titles(schema[key]) for key in kept}
    return [*map(_without_titles, schema)] if isinstance(schema, list) else schema


def _part(schema: Any) -> Any:
    """A copy in which nothing is required and every reference leads to such a copy."""
    if isinstance(schema, dict):
        return {key: _part(value) for key, value in schema.items() if key != "required"}
    if isinstance(schema, str) and schema.startswith(REFERENCE):
        return schema + PART
    return [*map(_part, schema)] if isinstance(schema, list) else schema
