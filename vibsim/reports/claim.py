"""A claim of the paper, and the finding on it: a pure function of the table of measured numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

HOLDS, ONLY_IF, FAILS, OPEN = "holds", "holds only if", "does not hold", "undecided"
VERDICTS = (HOLDS, ONLY_IF, FAILS, OPEN)

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
    """

    verdict: str
    measured: tuple[str, ...]
    runs: tuple[str, ...] = ()
    condition: str = ""
    remark: str = ""


@dataclass(frozen=True)
class Claim:
    """A statement of the paper and how it is judged.

    Attributes
    ----------
    key : a short name, such as "capture-II-B"
    statement : what the paper says
    where : where it says so: section, table or figure
    criterion : what would make it true, in words
    judge : from the table of numbers to the finding
    """

    key: str
    statement: str
    where: str
    criterion: str
    judge: Callable[[Numbers], Finding]


def only_if(printed: bool, otherwise: bool) -> str:
    """The verdict on a claim that is true as printed, or else under a condition."""
    return HOLDS if printed else ONLY_IF if otherwise else FAILS


def all_or_none(truths: list[bool]) -> str:
    """The verdict on a claim about several cases, without conditions."""
    return HOLDS if all(truths) else FAILS
