"""A claim of the paper, and the finding on it: a pure function of the table of measured numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from vibsim.evidence.reports.quotes import Quote

HOLDS, ONLY_IF, FAILS, OPEN = "holds", "holds only if", "does not hold", "undecided"
VERDICTS = (HOLDS, ONLY_IF, FAILS, OPEN)

# whose a criterion is
PAPERS = "the paper's own"
OURS = "ours: the paper gives none"
OUR_MARGIN = "the paper's numbers, our tolerance"

Numbers = dict[str, Any]


@dataclass(frozen=True)
class Finding:
    """What came of a claim.

    Attributes
    ----------
    verdict : one of VERDICTS
    measured : the numbers it rests on, in words, one line each
    runs : names of the runs that they are from
    condition : what a claim that "holds only if" needs
    remark : what a reader should know besides
    basis : what it rests on besides the runs, or instead
    """

    verdict: str
    measured: tuple[str, ...]
    runs: tuple[str, ...] = ()
    condition: str = ""
    remark: str = ""
    basis: str = ""


@dataclass(frozen=True)
class Claim:
    """A statement of the paper and how it is judged.

    Attributes
    ----------
    key : a short name, such as "II-B-captured"
    statement : what it is about, in our words
    quotes : the paper's words, with their places
    criterion : what would make it true, in words
    whose : whose that criterion is: PAPERS, OURS or OUR_MARGIN
    judge : from the table of numbers to the finding
    figures : keys of the figures that show it, such as "fig-16"
    pictures : names of the audit's own pictures that decide it, such as "drift"
    """

    key: str
    statement: str
    quotes: tuple[Quote, ...]
    criterion: str
    whose: str
    judge: Callable[[Numbers], Finding]
    figures: tuple[str, ...] = ()
    pictures: tuple[str, ...] = ()


def only_if(printed: bool, otherwise: bool) -> str:
    """The verdict on a claim that is true as printed, or else under a condition."""
    return HOLDS if printed else ONLY_IF if otherwise else FAILS


def either(first: bool, second: bool) -> str:
    """The verdict on a claim about two situations: under a condition where it is true of one of them."""
    return HOLDS if first and second else ONLY_IF if first or second else FAILS


def one_of(first: bool, second: bool, if_first: str, if_second: str) -> str:
    """The condition under which a claim holds that is true of one of two situations."""
    return "" if first == second else if_first if first else if_second
