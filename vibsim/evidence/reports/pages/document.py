"""A report before it has a shape: sections of paragraphs, tables, claims and pictures, in plain words.

`html_page` and `text_page` render the same document, so that both say the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from vibsim.evidence.reports.claims.claim import Claim, Finding
from vibsim.evidence.reports.quotes import Quote


@dataclass(frozen=True)
class Paragraph:
    """Running text."""

    text: str


@dataclass(frozen=True)
class Table:
    """A table: the first column names the rows; `verdict` is the number of a column that holds verdicts."""

    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    verdict: int | None = None


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
