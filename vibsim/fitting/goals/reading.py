"""A reading: values put in place of printed ones, such as J=0.006 kg m^2, c=0.005 N s/m.

It is judged beside what a search finds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vibsim.cases.problems import CaseError
from vibsim.cases.schema.keys import UnknownKeyError
from vibsim.cases.values.quantities import Quantity
from vibsim.fitting.errors import FitError
from vibsim.fitting.goals.free_parameter import LEAVE, FreeParameter
from vibsim.physics.arithmetic.elementary import log10

if TYPE_CHECKING:
    from vibsim.cases import Case

PRINTED = "as given"
READING, SEARCHED = "reading", "search"


@dataclass(frozen=True)
class Candidate:
    """What is judged: the values that it changes in every case.

    Attributes
    ----------
    number : in the order in which candidates were made
    origin : PRINTED, READING or SEARCHED
    changes : dotted key -> text with unit
    leaving : what leaving the printed values costs
    """

    number: int
    origin: str
    changes: dict[str, str]
    leaving: float

    def __str__(self) -> str:
        named = (f"{key.rpartition('.')[2]} = {text}" for key, text in self.changes.items())
        return ", ".join(named) or PRINTED


def read_reading(cases: list[Case], text: str) -> dict[str, str]:
    """The changes that `text` spells, tried in every case. Raises FitError."""
    changes: dict[str, str] = {}
    for part in text.split(","):
        key, equals, value = (word.strip() for word in part.partition("="))
        if not key or not equals or not value:
            raise FitError(
                f"reading {text!r}: {part.strip()!r} is not KEY=VALUE, such as J=0.006 kg m^2, c=0.005 N s/m"
            )
        try:
            full = cases[0].full_key(key)
            for case in cases:
                case.quantity(full)
                case.with_values({full: value})
        except UnknownKeyError as error:
            raise FitError(f"reading {text!r}: {key}: {error}") from None
        except CaseError as error:
            raise FitError(
                f"reading {text!r}: {error.problems[0].key}: {error.problems[0].message}"
            ) from None
        if full in changes:
            raise FitError(f"reading {text!r}: {key} is given twice")
        changes[full] = value
    return changes


def leaving_price(cases: list[Case], changes: dict[str, str], free: tuple[FreeParameter, ...]) -> float:
    """What the changes cost: of a free parameter its price, of another number that of a usual free one."""
    prices = {each.key: each for each in free}
    return sum(
        sum(_price(case, key, text, prices.get(key)) for case in cases) / len(cases)
        for key, text in changes.items()
    )


def _price(case: Case, key: str, text: str, free: FreeParameter | None) -> float:
    changed, printed = case.with_values({key: text}).quantity(key), case.quantity(key)
    if free is not None:
        from vibsim.cases.values.units import UNITS

        return free.price(float(changed.value / UNITS[free.unit].factor))
    return LEAVE * _decades(changed, printed)


def _decades(value: Quantity, printed: Quantity) -> float:
    """Powers of ten between two values; 1 where there is no ratio, 0 for the same."""
    a, b = value.number(), printed.number()
    return abs(log10(a / b)) if a * b > 0 else float(a != b)
