"""A document as plain text, 100 columns wide."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from functools import partial

from vibsim.evidence.reports.pages.document import (
    Document,
    Judged,
    Paragraph,
    Picture,
    Said,
    Section,
    Table,
    verdicts_of,
)
from vibsim.evidence.reports.quotes import Quote

WIDTH = 100
WIDEST_CELL = 46

wrap = partial(textwrap.wrap, break_on_hyphens=False)  # II-B-captured stays in one piece


def render_text(document: Document) -> str:
    """The text, with a final newline."""
    lines = [document.title, "=" * len(document.title), "", *wrap(document.subtitle, WIDTH)]
    for section in document.sections:
        lines += ["", "", section.heading, "-" * len(section.heading), *_section(section)]
    lines += ["", "", *(f"{label}: {text}" for label, text in document.provenance)]
    return "\n".join(lines) + "\n"


def _section(section: Section) -> Iterator[str]:
    for block in section.blocks:
        yield ""
        if isinstance(block, Paragraph):
            yield from wrap(block.text, WIDTH)
        elif isinstance(block, Table):
            yield from _table(block)
        elif isinstance(block, Judged):
            yield from _judged(block)
        elif isinstance(block, Said):
            yield from _quotes(block.quotes, "")
            yield from wrap(block.remark, WIDTH, initial_indent="   ", subsequent_indent="   ")
        else:
            yield from _picture(block)


def _judged(block: Judged) -> Iterator[str]:
    claim, finding = block.claim, block.finding
    yield from wrap(f"{block.number}. {claim.statement}", WIDTH, subsequent_indent="   ")
    yield from _quotes(claim.quotes, "   ")
    parts = [
        ("verdict" if i == 0 else "", f"{words}: {verdict if verdict.condition else verdict.word.upper()}")
        for i, (words, verdict) in enumerate(verdicts_of(finding))
    ]
    parts += [("criterion", f"{claim.criterion} ({claim.whose})")]
    parts += [("measured" if i == 0 else "", line) for i, line in enumerate(finding.measured)]
    parts += [("runs", block.trust)]
    parts += [("remark", finding.remark)] if finding.remark else []
    see = [heading for _, heading in block.figures] + [picture.path.name for picture in block.pictures]
    for label, text in [*parts, *([("see", ", ".join(see))] if see else [])]:
        yield from wrap(text, WIDTH, initial_indent=f"   {label:10} ", subsequent_indent=" " * 14)


def _quotes(quotes: Sequence[Quote], indent: str) -> Iterator[str]:
    for quote in quotes:
        text = f"“{quote.text}” [{quote.place}]"
        yield from wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent)


def _picture(block: Picture) -> Iterator[str]:
    yield from wrap(f"{block.heading}. {block.caption} [{block.path.name}]", WIDTH, subsequent_indent="   ")


def _table(table: Table) -> Iterator[str]:
    """Columns as wide as their longest cell, long cells on several lines."""
    yield from wrap(table.caption, WIDTH)
    rows = [table.columns, *table.rows]
    widths = [min(WIDEST_CELL, max(len(row[i]) for row in rows)) for i in range(len(table.columns))]
    for index, row in enumerate(rows):
        cells = [wrap(cell, width) or [""] for cell, width in zip(row, widths, strict=True)]
        for line in range(max(map(len, cells))):
            texts = [cell[line] if line < len(cell) else "" for cell in cells]
            yield "  ".join(f"{text:{width}}" for text, width in zip(texts, widths, strict=True)).rstrip()
        if index == 0:
            yield "  ".join("-" * width for width in widths)
