"""A document as one HTML file that needs nothing else: pictures and style inside, no scripts, no links."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape

from vibsim.evidence.reports.claims.claim import VERDICTS
from vibsim.evidence.reports.pages.document import (
    Block,
    Document,
    Judged,
    Paragraph,
    Picture,
    Said,
    Section,
    Table,
    verdicts_of,
)
from vibsim.evidence.reports.pages.page_style import STYLE
from vibsim.evidence.reports.quotes import Quote

MANY = 3  # columns; wider tables scroll on a narrow screen instead of being squeezed
MEDIA = {".png": "image/png", ".svg": "image/svg+xml"}


def render_html(document: Document) -> str:
    """The page."""
    contents = "".join(
        f'<li><a href="#{section.key}">{escape(section.heading)}</a></li>' for section in document.sections
    )
    provenance = "".join(
        f"<dt>{escape(label)}</dt><dd>{escape(text)}</dd>" for label, text in document.provenance
    )
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{escape(document.title)}</title>
<style>
{STYLE}</style>
</head>
<body>
<a class="skip" href="#main">To the report</a>
<header>
<h1>{escape(document.title)}</h1>
<p>{escape(document.subtitle)}</p>
<nav aria-label="Contents"><ul>{contents}</ul></nav>
</header>
<main id="main">
{"".join(_section(section) for section in document.sections)}</main>
<footer><dl>{provenance}</dl></footer>
</body>
</html>
"""


def _section(section: Section) -> str:
    blocks = "".join(_block(block) for block in section.blocks)
    return f'<section id="{section.key}">\n<h2>{escape(section.heading)}</h2>\n{blocks}</section>\n'


def _block(block: Block) -> str:
    if isinstance(block, Paragraph):
        return f"<p>{escape(block.text)}</p>\n"
    if isinstance(block, Table):
        return _table(block)
    if isinstance(block, Said):
        return f'<div class="said">{_quotes(block.quotes)}<p>{escape(block.remark)}</p></div>\n'
    return _judged(block) if isinstance(block, Judged) else _picture(block)


def _table(table: Table) -> str:
    head = "".join(f'<th scope="col">{escape(column)}</th>' for column in table.columns)
    many = ' class="many"' if len(table.columns) > MANY else ""
    rows = "".join(
        f'<tr><th scope="row">{escape(row[0])}</th>'
        + "".join(_cell(cell, number in table.verdicts) for number, cell in enumerate(row[1:], start=1))
        + "</tr>\n"
        for row in table.rows
    )
    return (
        f'<div class="wide" tabindex="0" role="region" aria-label="{escape(table.caption)}"><table{many}>'
        f"<caption>{escape(table.caption)}</caption>\n<thead><tr>{head}</tr></thead>\n<tbody>{rows}</tbody>"
        "</table></div>\n"
    )


def _cell(text: str, verdict: bool) -> str:
    return f"<td>{_badge(text) if verdict and text else escape(text)}</td>"


def _badge(verdict: str) -> str:
    """A verdict in its colour; the word says it as well."""
    kind = VERDICTS.index(verdict) if verdict in VERDICTS else len(VERDICTS)
    return f'<span class="verdict v{kind}">{escape(verdict)}</span>'


def _judged(block: Judged) -> str:
    claim, finding = block.claim, block.finding
    verdicts = "".join(
        f'<p class="finding">{escape(words)}: {_badge(verdict.word)} {escape(verdict.condition)}</p>\n'
        for words, verdict in verdicts_of(finding)
    )
    measured = "".join(f"<li>{escape(line)}</li>" for line in finding.measured)
    remark = f"<dt>Remark</dt><dd>{escape(finding.remark)}</dd>" if finding.remark else ""
    return f"""<article id="{claim.key}">
<h3>{block.number}. {escape(claim.statement)}</h3>
{_quotes(claim.quotes)}{verdicts}<dl>
<dt>Criterion</dt><dd>{escape(claim.criterion)} <em>({escape(claim.whose)})</em></dd>
<dt>Measured</dt><dd><ul>{measured}</ul></dd>
<dt>Runs</dt><dd>{escape(block.trust)}</dd>
{remark}{_figures(block)}</dl>
{"".join(_picture(picture) for picture in block.pictures)}</article>
"""


def _quotes(quotes: Sequence[Quote]) -> str:
    return "".join(
        f"<blockquote><p><q>{escape(quote.text)}</q> <cite>{escape(quote.place)}</cite></p></blockquote>\n"
        for quote in quotes
    )


def _figures(block: Judged) -> str:
    links = ", ".join(f'<a href="#{key}">{escape(heading)}</a>' for key, heading in block.figures)
    return f"<dt>See</dt><dd>{links}</dd>" if links else ""


def _picture(block: Picture) -> str:
    data = b64encode(block.path.read_bytes()).decode("ascii")
    return (
        f'<figure id="{block.path.stem}"><img alt="{escape(block.alt)}" loading="lazy" '
        f'src="data:{MEDIA[block.path.suffix]};base64,{data}">'
        f"<figcaption><b>{escape(block.heading)}.</b> {escape(block.caption)}</figcaption></figure>\n"
    )
