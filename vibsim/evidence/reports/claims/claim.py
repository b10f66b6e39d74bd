"""A claim of the paper, and the finding on it: a pure function of the table of measured numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vibsim.evidence.reports.quotes import Quote
from vibsim.evidence.reports.wording import words_of

HOLDS, ONLY_IF, IN_KIND = "holds", "holds only if", "holds in kind"
EXAMPLE, FAILS, OPEN = "holds, for example, with", "does not hold", "undecided"
VERDICTS = (HOLDS, ONLY_IF, IN_KIND, EXAMPLE, FAILS, OPEN)

# whose a criterion is
PAPERS = "the paper's own"
OURS = "ours: the paper gives none"
OUR_MARGIN = "the paper's numbers, our tolerance"

Numbers = dict[str, Any]


@dataclass(frozen=True)
class Verdict:
    """One of VERDICTS, and with what: the condition, the other numbers, or how it differs in kind."""

    word: str
    condition: str = ""

    def __str__(self) -> str:
        return f"{self.word} {self.condition}".strip()


@dataclass(frozen=True)
class Finding:
    """What came of a claim.

    Attributes
    ----------
    verdicts : on the motion from rest and over the perturbed starts; one alone where no start enters
    measured : the numbers it rests on, in words, one line each
    runs : names of the runs that they are from
    remark : what a reader should know besides
    basis : what it rests on besides the runs, or instead
    """

    verdicts: tuple[Verdict, ...]
    measured: tuple[str, ...]
    runs: tuple[str, ...] = ()
    remark: str = ""
    basis: str = ""

    @property
    def rest(self) -> Verdict:
        """On the motion from rest, or on what no start enters into."""
        return self.verdicts[0]

    @property
    def starts(self) -> Verdict | None:
        """Over the perturbed starts; None where no start enters."""
        return self.verdicts[1] if len(self.verdicts) > 1 else None


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


def holds(true: bool) -> Verdict:
    """The verdict on a claim without conditions."""
    return Verdict(HOLDS if true else FAILS)


def with_numbers(true: Sequence[bool], numbers: str) -> Verdict:
    """The verdict on a claim that is true as printed, or else with other `numbers`, given as an example.

    true : as printed, and with those numbers
    """
    printed, otherwise = true
    return Verdict(EXAMPLE, numbers) if otherwise and not printed else holds(printed)


def only_if(true: Mapping[str, bool], what: str = "") -> Verdict:
    """The verdict on a claim about several situations: where it is true of some, with their names behind
    `what`.
    """
    names = [name for name, each in true.items() if each]
    if not names or len(names) == len(true):
        return holds(bool(names))
    return Verdict(ONLY_IF, f"{what} {words_of(names, 'or')}".strip())
