"""A report before it has a shape: sections of paragraphs, tables, claims and pictures, in plain words.

`html_page` and `text_page` render the same document, so that both say the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from vibsim.evidence.reports.claims.claim import Claim, Finding, Verdict
from vibsim.evidence.reports.measured.ensembles import EACH_WAY
from vibsim.evidence.reports.quotes import Quote


@dataclass(frozen=True)
class Paragraph:
    """Running text."""

    text: str


@dataclass(frozen=True)
class Table:
    """A table: the first column names the rows; `verdicts` are the numbers of columns that hold verdicts."""

    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    verdicts: tuple[int, ...] = ()


@dataclass(frozen=True)
class Picture:
    """A figure on file."""

    path: Path
    heading: str
    caption: str
    alt: str


@dataclass(frozen=True)
class Judged:
    """A claim with its finding, until when its evidence is right, and what shows it.

    figures : key and heading of each figure elsewhere in the report; pictures : shown with the claim
    """

    number: int
    claim: Claim
    finding: Finding
    trust: str
    figures: tuple[tuple[str, str], ...] = ()
    pictures: tuple[Picture, ...] = ()


@dataclass(frozen=True)
class Said:
    """Words of the paper that are not judged, and why."""

    quotes: tuple[Quote, ...]
    remark: str


Block = Paragraph | Table | Judged | Said | Picture


@dataclass(frozen=True)
class Section:
    """A part of the report."""

    key: str
    heading: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Document:
    """A whole report."""

    title: str
    subtitle: str
    sections: tuple[Section, ...]
    provenance: tuple[tuple[str, str], ...] = field(default=())


FROM_REST, FROM_STARTS = "From rest", f"From {2 * EACH_WAY} starts"
NO_START = "Whatever the start"


def verdicts_of(finding: Finding) -> list[tuple[str, Verdict]]:
    """Both verdicts of a finding with what each is about; the one verdict where no start enters."""
    if finding.starts is None:
        return [(NO_START, finding.rest)]
    return [(FROM_REST, finding.rest), (FROM_STARTS, finding.starts)]
