"""The report in words: a document without a shape, and the HTML and text made of it."""

from __future__ import annotations

import textwrap
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from html import escape
from pathlib import Path

from vibsim.evidence.reports.claims import VERDICTS, Claim, ClaimVerdict, Finding, Quote
from vibsim.evidence.reports.measurements import EACH_WAY

# A report before it has a shape: sections of paragraphs, tables, claims and pictures, in plain words.
#
# `html_page` and `text_page` render the same document, so that both say the same.


@dataclass(frozen=True)
class Paragraph:
    """Running text."""

    text: str


@dataclass(frozen=True)
class PageTable:
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
class JudgedClaim:
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
class QuotedWords:
    """Words of the paper that are not judged, and why."""

    quotes: tuple[Quote, ...]
    remark: str


Block = Paragraph | PageTable | JudgedClaim | QuotedWords | Picture


@dataclass(frozen=True)
class PageSection:
    """A part of the report."""

    key: str
    heading: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Document:
    """A whole report."""

    title: str
    subtitle: str
    sections: tuple[PageSection, ...]
    provenance: tuple[tuple[str, str], ...] = field(default=())


FROM_REST, FROM_STARTS = "From rest", f"From {2 * EACH_WAY} starts"
NO_START = "Whatever the start"


def verdicts_of(finding: Finding) -> list[tuple[str, ClaimVerdict]]:
    """Both verdicts of a finding with what each is about; the one verdict where no start enters."""
    if finding.starts is None:
        return [(NO_START, finding.rest)]
    return [(FROM_REST, finding.rest), (FROM_STARTS, finding.starts)]


# A document as one HTML file that needs nothing else: pictures and style inside, no scripts, no links.


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
{"".join(_html_section(section) for section in document.sections)}</main>
<footer><dl>{provenance}</dl></footer>
</body>
</html>
"""


def _html_section(section: PageSection) -> str:
    blocks = "".join(_block(block) for block in section.blocks)
    return f'<section id="{section.key}">\n<h2>{escape(section.heading)}</h2>\n{blocks}</section>\n'


def _block(block: Block) -> str:
    if isinstance(block, Paragraph):
        return f"<p>{escape(block.text)}</p>\n"
    if isinstance(block, PageTable):
        return _html_table(block)
    if isinstance(block, QuotedWords):
        return f'<div class="said">{_html_quotes(block.quotes)}<p>{escape(block.remark)}</p></div>\n'
    return _html_judged(block) if isinstance(block, JudgedClaim) else _html_picture(block)


def _html_table(table: PageTable) -> str:
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


def _html_judged(block: JudgedClaim) -> str:
    claim, finding = block.claim, block.finding
    verdicts = "".join(
        f'<p class="finding">{escape(words)}: {_badge(verdict.word)} {escape(verdict.condition)}</p>\n'
        for words, verdict in verdicts_of(finding)
    )
    measured = "".join(f"<li>{escape(line)}</li>" for line in finding.measured)
    remark = f"<dt>Remark</dt><dd>{escape(finding.remark)}</dd>" if finding.remark else ""
    return f"""<article id="{claim.key}">
<h3>{block.number}. {escape(claim.statement)}</h3>
{_html_quotes(claim.quotes)}{verdicts}<dl>
<dt>Criterion</dt><dd>{escape(claim.criterion)} <em>({escape(claim.whose)})</em></dd>
<dt>Measured</dt><dd><ul>{measured}</ul></dd>
<dt>Runs</dt><dd>{escape(block.trust)}</dd>
{remark}{_figures(block)}</dl>
{"".join(_html_picture(picture) for picture in block.pictures)}</article>
"""


def _html_quotes(quotes: Sequence[Quote]) -> str:
    return "".join(
        f"<blockquote><p><q>{escape(quote.text)}</q> <cite>{escape(quote.place)}</cite></p></blockquote>\n"
        for quote in quotes
    )


def _figures(block: JudgedClaim) -> str:
    links = ", ".join(f'<a href="#{key}">{escape(heading)}</a>' for key, heading in block.figures)
    return f"<dt>See</dt><dd>{links}</dd>" if links else ""


def _html_picture(block: Picture) -> str:
    data = b64encode(block.path.read_bytes()).decode("ascii")
    return (
        f'<figure id="{block.path.stem}"><img alt="{escape(block.alt)}" loading="lazy" '
        f'src="data:{MEDIA[block.path.suffix]};base64,{data}">'
        f"<figcaption><b>{escape(block.heading)}.</b> {escape(block.caption)}</figcaption></figure>\n"
    )


# How the HTML report looks: one readable column, light and dark, and on paper.


STYLE = """\
:root {
  --ink: #1b1d20; --soft: #565b63; --line: #d9dce1; --ground: #ffffff; --card: #f5f6f8; --link: #005a9c;
  --yes: #0b6b3a; --if: #8a5a00; --no: #a3221b; --open: #565b63;
}
@media (prefers-color-scheme: dark) {
  :root {
    --ink: #e6e7ea; --soft: #a8adb6; --line: #3a3f47; --ground: #16181b; --card: #1f2226; --link: #7fbcf0;
    --yes: #63c78f; --if: #e0b050; --no: #f08a80; --open: #a8adb6;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 2.5rem 1.25rem 4rem; max-width: 62rem;
  color: var(--ink); background: var(--ground);
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif;
}
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.35rem; margin: 3rem 0 1rem; padding-bottom: .3rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1.05rem; line-height: 1.35; margin: 0 0 .4rem; }
h3 small { font-weight: normal; color: var(--soft); }
a { color: var(--link); }
p { max-width: 46rem; }
header p { color: var(--soft); }
nav ul { display: flex; flex-wrap: wrap; gap: .3rem 1.25rem; padding: 0; margin: 1rem 0 0; list-style: none; }
.skip { position: absolute; left: -100rem; }
.skip:focus { left: 1rem; top: 1rem; background: var(--ground); padding: .5rem; }
article {
  margin: 1.1rem 0; padding: 1rem 1.2rem; background: var(--card);
  border: 1px solid var(--line); border-radius: 6px;
  break-inside: avoid;
}
blockquote { margin: 0 0 .5rem; padding-left: .8rem; border-left: 3px solid var(--line); }
blockquote p { margin: 0; max-width: none; font-style: italic; }
q { quotes: "\\201C" "\\201D"; }
cite { font-style: normal; color: var(--soft); font-size: .9rem; white-space: nowrap; }
cite::before { content: "· "; }
.said { margin: 1.2rem 0; }
.said > p { margin: 0; }
article figure { margin: 1.2rem 0 0; }
.finding { margin: .3rem 0 .8rem; max-width: none; }
.verdict { font-weight: 600; white-space: nowrap; border-bottom: 2px solid currentColor; }
.v0 { color: var(--yes); } .v1, .v2, .v3 { color: var(--if); } .v4 { color: var(--no); }
.v5, .v6 { color: var(--open); }
article dl, footer dl { display: grid; grid-template-columns: 6.2rem 1fr; gap: .35rem .8rem; margin: 0; }
dt { color: var(--soft); font-size: .9rem; }
dd { margin: 0; font-size: .95rem; overflow-wrap: anywhere; }
dd ul { margin: 0; padding-left: 1.1rem; }
.wide { overflow-x: auto; margin: 1.2rem 0; }
table { border-collapse: collapse; font-size: .92rem; font-variant-numeric: tabular-nums; min-width: 60%; }
caption { text-align: left; color: var(--soft); padding-bottom: .4rem; }
th, td {
  text-align: left; vertical-align: top; padding: .35rem .9rem .35rem 0; border-bottom: 1px solid var(--line);
}
thead th { font-weight: 600; border-bottom: 2px solid var(--line); }
tbody th { font-weight: 500; }
figure { margin: 1.8rem 0 2.4rem; break-inside: avoid; }
figure img {
  display: block; width: 100%; height: auto; background: #ffffff; padding: .5rem;
  border: 1px solid var(--line); border-radius: 6px;
}
figcaption { margin-top: .5rem; font-size: .92rem; color: var(--soft); max-width: 50rem; }
figcaption b { color: var(--ink); }
footer { margin-top: 3.5rem; padding-top: 1rem; border-top: 1px solid var(--line); color: var(--soft); }
@media (max-width: 40rem) {
  table.many { min-width: 42rem; }
  article dl, footer dl { grid-template-columns: 1fr; gap: .1rem; }
  dd { margin-bottom: .5rem; }
}
@media print {
  :root {
    --ink: #000; --soft: #333; --line: #bbb; --ground: #fff; --card: #fff;
    --yes: #000; --if: #000; --no: #000; --open: #000;
  }
  body { max-width: none; padding: 0; font-size: 10pt; }
  nav, .skip { display: none; }
  h2 { break-after: avoid; }
  .wide { overflow: visible; }
}
"""


# A document as plain text, 100 columns wide.


WIDTH = 100
WIDEST_CELL = 46

wrap = partial(textwrap.wrap, break_on_hyphens=False)  # II-B-captured stays in one piece


def render_text(document: Document) -> str:
    """The text, with a final newline."""
    lines = [document.title, "=" * len(document.title), "", *wrap(document.subtitle, WIDTH)]
    for section in document.sections:
        lines += ["", "", section.heading, "-" * len(section.heading), *_text_section(section)]
    lines += ["", "", *(f"{label}: {text}" for label, text in document.provenance)]
    return "\n".join(lines) + "\n"


def _text_section(section: PageSection) -> Iterator[str]:
    for block in section.blocks:
        yield ""
        if isinstance(block, Paragraph):
            yield from wrap(block.text, WIDTH)
        elif isinstance(block, PageTable):
            yield from _text_table(block)
        elif isinstance(block, JudgedClaim):
            yield from _text_judged(block)
        elif isinstance(block, QuotedWords):
            yield from _text_quotes(block.quotes, "")
            yield from wrap(block.remark, WIDTH, initial_indent="   ", subsequent_indent="   ")
        else:
            yield from _text_picture(block)


def _text_judged(block: JudgedClaim) -> Iterator[str]:
    claim, finding = block.claim, block.finding
    yield from wrap(f"{block.number}. {claim.statement}", WIDTH, subsequent_indent="   ")
    yield from _text_quotes(claim.quotes, "   ")
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


def _text_quotes(quotes: Sequence[Quote], indent: str) -> Iterator[str]:
    for quote in quotes:
        text = f"“{quote.text}” [{quote.place}]"
        yield from wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent)


def _text_picture(block: Picture) -> Iterator[str]:
    yield from wrap(f"{block.heading}. {block.caption} [{block.path.name}]", WIDTH, subsequent_indent="   ")


def _text_table(table: PageTable) -> Iterator[str]:
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
