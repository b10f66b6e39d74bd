"""The Lyapunov exponents that a run took along, for people (lines) and for programs (JSON)."""

import math
from typing import Any

from vibsim.analysis.exponents import Lyapunov, stored_exponents
from vibsim.cases.number import number
from vibsim.command_line.terminal.printing import style
from vibsim.results import Result


def exponent_lines(result: Result) -> list[tuple[str, str]]:
    """Label and text: the exponents with their intervals, their span, and what speaks against them."""
    lyapunov = stored_exponents(result)
    if lyapunov is None:
        return []
    pairs = zip(lyapunov.exponents.tolist(), lyapunov.half_widths.tolist(), strict=True)
    begin, end = lyapunov.span
    lines = [
        ("exponents", f"{', '.join(exponent_text(*pair) for pair in pairs)} 1/s"),
        ("", f"from {begin:.4g} to {end:.4g} s{checks(lyapunov, bool(result.case.scene().rigid_stops))}"),
    ]
    return lines + [("", style(warning, fg="yellow")) for warning in lyapunov.warnings]


def exponent_object(result: Result) -> dict[str, Any]:
    """What the intervals and warnings add to the attributes of a run."""
    lyapunov = stored_exponents(result)
    if lyapunov is None:
        return {}
    return {"lyapunov_half_widths": lyapunov.half_widths, "lyapunov_warnings": list(lyapunov.warnings)}


def exponent_text(value: float, half_width: float) -> str:
    """1.27 +- 0.12; -inf where sticking took the direction, none where there is none."""
    if math.isnan(value):
        return "none"
    if math.isinf(value):
        return "-inf"
    text = number(value, 3)
    return text if math.isnan(half_width) else f"{text} +- {number(half_width, 2)}"


def checks(lyapunov: Lyapunov, rests: bool) -> str:
    """Rank losses, and how well volumes obey Liouville's identity."""
    parts = []
    if lyapunov.rank_losses:
        losses = f"{lyapunov.rank_losses} rank loss{'' if lyapunov.rank_losses == 1 else 'es'}"
        parts.append(f"{losses} by {'sticking, rest and blows' if rests else 'sticking'}")
    if not math.isnan(lyapunov.volume_residual):
        parts.append(f"volume residual {number(lyapunov.volume_residual, 2)}")
    return "".join(f", {part}" for part in parts)
