"""The few lines that tell most about a run."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vibsim.cases.number import number
from vibsim.cases.plain_text import one_line
from vibsim.labelled.labelled import few

if TYPE_CHECKING:
    from vibsim.results.result import Result


def lines_of(result: "Result") -> list[tuple[str, str]]:
    """Label and text; what is not known has no line."""
    attrs = result.attrs
    lines = [("title", one_line(result.case.title))] if result.case.title else []
    lines.append(("method", f"{attrs.get('method')} on the {attrs.get('engine')} engine"))
    counted = [_counted(attrs[f"{word}s"], word) for word in ("impact", "stick") if f"{word}s" in attrs]
    if counted:
        lines.append(("motion", ", ".join(counted)))
    if result.trust_horizon is not None:
        lines.append(("right", _trust(result)))
    if "certified" in attrs:
        doubt = f"{attrs.get('uncertified')} stretches in doubt"
        lines.append(("certificate", "every event proved" if attrs["certified"] else doubt))
    return [*lines, ("columns", few(result.keys()))]


def _counted(count: int, word: str) -> str:
    return f"{count} {word}{'' if count == 1 else 's'}"


def _trust(result: "Result") -> str:
    tolerance = f"to {number(result.attrs['trust_tolerance_m'], 2)} m"
    horizon = result.trust_horizon
    assert horizon is not None
    if horizon < result.t_reached:
        return f"{tolerance} until {horizon:.4g} s{unknown_text(result.attrs)}"
    return f"{tolerance} over the whole run"


def unknown_text(attrs: Mapping[str, Any]) -> str:
    """From when on nothing is known of the error of a run, and why; empty where something is to its end."""
    if "trust_known_to_s" not in attrs:
        return ""
    return f"; nothing is known behind {attrs['trust_known_to_s']:.4g} s: {attrs['trust_unknown_why']}"
