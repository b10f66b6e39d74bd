"""The JSON Schema of a case file, for editors and other programs."""

from typing import Any

from vibsim.cases.file_tree import SWITCHABLE, SWITCHED_OFF
from vibsim.cases.schema import CaseFile

DIALECT = "https://json-schema.org/draft/2020-12/schema"
OFF = {"const": SWITCHED_OFF}


def case_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a case file: keys, units, ranges, defaults, examples."""
    schema = _without_titles(CaseFile.model_json_schema())
    for name in SWITCHABLE:
        schema["properties"][name] = _switchable(schema["properties"][name])
    extends = CaseFile.model_fields["extends"]
    schema["properties"]["extends"] = {"type": "string", "description": extends.description}
    return {"$schema": DIALECT, "title": "vibsim case"} | schema


def _without_titles(schema: Any) -> Any:
    """Drop the titles that pydantic makes up from the names of keys and sections."""
    if isinstance(schema, dict):
        return {
            key: _without_titles(value)
            for key, value in schema.items()
            if not (key == "title" and isinstance(value, str))
        }
    return [*map(_without_titles, schema)] if isinstance(schema, list) else schema


def _switchable(section: dict[str, Any]) -> dict[str, Any]:
    """A section that may also be the word none; in a file that word stands where pydantic says null."""
    choices = section.pop("anyOf", None) or section.pop("oneOf", None) or [{"$ref": section.pop("$ref")}]
    section.pop("default", None)
    return {"anyOf": [choice for choice in choices if choice != {"type": "null"}] + [OFF]} | section
