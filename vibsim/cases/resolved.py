"""The resolved form of a case: its values with the defaults filled in, and their canonical JSON text."""

import json
from collections.abc import Iterator
from typing import Any

from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.schema.schema import CaseFile, CaseHead, Motor
from vibsim.cases.schema.sections import Section
from vibsim.cases.values.quantities import Quantity

RESOLVED_FORMAT = 1  # of the JSON text
NOT_PHYSICS = ("name", "title", "run.trust_tolerance")


def nested_values(case: CaseHead) -> dict[str, Any]:
    """Sections as dicts of quantities, words and whole numbers; missing sections are left out."""
    values = _section_values(case)
    if not isinstance(case, CaseFile):
        from vibsim.cases.parts.defaults import with_defaults

        return with_defaults(values)
    for name in _absent_states(case):
        del values["initial"][name]
    return values


def flat_values(case: CaseHead) -> dict[str, Any]:
    """The same under dotted keys, e.g. "excitation.Omega0"."""
    return dict(_leaves(nested_values(case), ""))


def every_value(case: CaseHead) -> dict[str, Any]:
    """Flat values, with the initial states that the case has no use for."""
    return dict(_leaves(_section_values(case), ""))


def resolved_text(case: CaseHead) -> str:
    """Canonical JSON: every value, numbers as the texts that read back to the same exact quantity."""
    return json.dumps({"vibsim_case": RESOLVED_FORMAT} | _texts(nested_values(case)), ensure_ascii=False)


def resolved_values(text: str, source: str) -> dict[str, Any]:
    """Nested texts of what resolved_text() wrote. Raises CaseError where the text is something else."""
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        values = None
    if not isinstance(values, dict) or "vibsim_case" not in values:
        raise CaseError([Problem(source, None, None, "", "is not the resolved JSON text of a vibsim case")])
    version = values.pop("vibsim_case")
    if version != RESOLVED_FORMAT:
        what = f"is a resolved case of format {version}; this vibsim reads format {RESOLVED_FORMAT}"
        raise CaseError([Problem(source, None, None, "", what)])
    return values


def fingerprint(flat: dict[str, Any]) -> str:
    """SHA-256 of the exact values in any spelling (330 rpm is 5.5 Hz).

    Name, title and trust tolerance do not count: they leave the motion as it is.
    """
    import hashlib  # loads OpenSSL, 2 ms, which a run does while the engine runs already

    exact = {key: _exact_text(value) for key, value in flat.items() if key not in NOT_PHYSICS}
    return hashlib.sha256(json.dumps(exact, sort_keys=True).encode()).hexdigest()


def _section_values(section: Section | dict[str, Any]) -> dict[str, Any]:
    """The keys of a section, or its parts by name; empty sections of parts are left out."""
    inner = section if isinstance(section, dict) else section.__dict__
    return {
        name: _section_values(value) if isinstance(value, Section | dict) else value
        for name, value in inner.items()
        if value is not None and value != {}
    }


def _absent_states(case: CaseFile) -> list[str]:
    absent = [] if isinstance(case.blocks.m2, Quantity) else ["x2", "v2"]
    return absent if isinstance(case.excitation, Motor) else [*absent, "phi", "phidot"]


def _leaves(values: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _texts(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _texts(inner) for name, inner in value.items()}
    return value if isinstance(value, str | int) else str(value)


def _exact_text(value: Any) -> str:
    if not isinstance(value, Quantity):
        return str(value)
    return f"{value.value} turns" if value.per_turn else str(value.value)
