"""Numbers as the report writes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def hz(value: float | None) -> str:
    """A frequency to 10 mHz."""
    return "unknown" if value is None else f"{value:.2f} Hz"


def mm(value: float | None) -> str:
    """A length [m] in mm, to three digits."""
    return "unknown" if value is None else f"{1e3 * value:.3g} mm"


def mm_per_s(value: float | None) -> str:
    """A slow velocity [m/s] in mm/s, to three digits."""
    return "undecided" if value is None else f"{1e3 * value:.3g} mm/s"


def drift_rate(drift: Mapping[str, Any]) -> str:
    """A measured drift with its uncertainty."""
    if drift["rate"] is None:
        return "undecided"
    return f"{1e3 * drift['rate']:.3g} ± {1e3 * drift['half_width']:.1g} mm/s"


def seconds(value: float | None) -> str:
    """A time to a second, short ones to three digits."""
    return "unknown" if value is None else f"{value:.0f} s" if value >= 100 else f"{value:.3g} s"


def between(least: float, greatest: float, unit: str) -> str:
    """Two ends to three digits, or the one number that they are."""
    ends = [f"{end:.3g}" for end in (least, greatest)]
    return f"{' to '.join(dict.fromkeys(ends))} {unit}".strip()


def of_all(count: int, total: int) -> str:
    """How many of how many."""
    return f"{count} of {total}"


def percent(share: float) -> str:
    """A share in whole percent."""
    return f"{100 * share:.0f} %"


def words_of(names: Sequence[str], last: str = "and") -> str:
    """A list in words: "a", "a and b", "a, b and c"."""
    return f" {last} ".join(part for part in (", ".join(names[:-1]), *names[-1:]) if part)


def typeset(text: str) -> str:
    """Squares of units as they are printed."""
    return text.replace("^2", "²")
