"""The long form of a case as YAML text, every default filled in; reads back to the same scene."""

import json
import re
from collections.abc import Iterator
from typing import Any

from vibsim.cases.parts.ends import Ends
from vibsim.cases.values.quantities import Quantity

HEAD = ("name", "title")
FLAT = ("base", "motor", "run")  # sections of keys; the others hold parts by name
_PLAIN = re.compile(r"[A-Za-z0-9+-][A-Za-z0-9 ._+/^()'-]*", re.ASCII)


def long_text(values: dict[str, Any]) -> str:
    """YAML text of the nested values of a case in the long form."""
    return "\n".join(_lines(values)) + "\n"


def sections_text(values: dict[str, Any]) -> str:
    """YAML text of the nested values of a case in the short form: its sections, a line per key."""
    lines = [f"{name}: {scalar(values[name])}" for name in HEAD if values.get(name)]
    for section, content in values.items():
        if section in HEAD:
            continue
        lines += ["", f"{section}:"] if section == "blocks" else [f"{section}:"]
        lines += [f"  {name}: {flow(value)}" for name, value in content.items()]
    return "\n".join(lines) + "\n"


def _lines(values: dict[str, Any]) -> Iterator[str]:
    for name in HEAD:
        if values.get(name):
            yield f"{name}: {scalar(values[name])}"
    yield ""
    for section, content in values.items():
        if section in HEAD or not content:
            continue
        if section == "bodies" or section in FLAT:
            yield f"{section}: {flow(content)}"
        else:
            yield f"{section}:"
            yield from (f"  {scalar(name)}: {flow(part)}" for name, part in content.items())


def flow(value: Any, key: str = "") -> str:
    """A value, a part or a list of terms on one line."""
    if isinstance(value, dict) and key == "terms":
        return f"[{', '.join(flow(term) for term in value.values())}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{scalar(name)}: {flow(inner, name)}" for name, inner in value.items()) + "}"
    return str(value) if isinstance(value, Ends) else scalar(value)


def scalar(value: Any) -> str:
    """A value as plain text, in quotes where YAML would read it otherwise."""
    text = value.text if isinstance(value, Quantity) else str(value)
    is_plain = _PLAIN.fullmatch(text) and text == text.strip() and text not in ("null", "Null", "NULL")
    return text if is_plain else json.dumps(text, ensure_ascii=False)
