"""How pages are laid out: pictures in their printed size, lines of code that wrap, tables that stack."""

import html
import re
import struct
from itertools import zip_longest
from pathlib import Path
from typing import Any

from docutils import nodes

PIXELS_PER_INCH = 150  # on screen, of a picture that is 3.4 in wide in print
STACKED_FROM = 4  # columns
NARROW = 40  # characters that the longest words of all columns may have beside each other at 400 pixels
LABEL = re.compile(r"  \w[\w -]*? {2,}(?=\S)")  # of a line of a summary
LONGEST_LABEL = 24
PRE = re.compile(r"<pre>(.*?)</pre>", re.DOTALL)
TABLE = re.compile(r'<table class="(docutils[^"]*)">(.*?)</table>', re.DOTALL)
TAG = re.compile(r"<[^>]+>")


def setup_layout(app: Any) -> None:
    """Lay pages out as they are read and written."""
    app.add_css_file("vibsim.css")
    app.connect("doctree-read", size_pictures)
    app.connect("html-page-context", lay_out)


def size_pictures(app: Any, doctree: Any) -> None:
    """Give pictures the width on screen that they have in print, by the resolution in the file."""
    for picture in doctree.findall(nodes.image):
        path = Path(app.srcdir) / picture["uri"].lstrip("/")
        inches = printed_width(path) if path.suffix == ".png" and path.exists() else None
        if inches and not within_a_table(picture):
            picture["width"] = f"{round(inches * PIXELS_PER_INCH)}px"


def within_a_table(node: Any) -> bool:
    while node.parent is not None:
        node = node.parent
        if isinstance(node, nodes.entry):
            return True
    return False


def printed_width(path: Path) -> float | None:
    """Width [in] of a PNG file that states its resolution."""
    content = path.read_bytes()
    at = content.find(b"pHYs")
    if at < 0:
        return None
    pixels = struct.unpack(">I", content[16:20])[0]
    per_metre = struct.unpack(">I", content[at + 4 : at + 8])[0]
    return float(pixels / per_metre / 0.0254)


def lay_out(app: Any, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Let the code of a page wrap and its tables stack."""
    if "body" in context:
        context["body"] = TABLE.sub(stackable, PRE.sub(wrapping, context["body"]))


def wrapping(match: re.Match[str]) -> str:
    """A block of code, each line an element of its own that says how far its continuation is indented."""
    lines = match[1].removesuffix("\n").split("\n")
    return "<pre>" + "".join(_line(line) + "\n" for line in lines) + "</pre>"


def _line(line: str) -> str:
    label = LABEL.match(html.unescape(TAG.sub("", line)))
    hang = f' style="--hang:{label.end()}ch"' if label and label.end() <= LONGEST_LABEL else ""
    return f'<span class="line"{hang}>{line}</span>'


def stackable(match: re.Match[str]) -> str:
    """A table; one too wide for a narrow screen, by its columns, pictures or words, as cards that know the
    heads of their columns.
    """
    heads = [TAG.sub("", head) for head in re.findall(r"<th(?: [^>]*)?>(.*?)</th>", match[2], re.DOTALL)]
    if len(heads) < STACKED_FROM and "<img" not in match[2] and _least_width(match[2]) <= NARROW:
        return match[0]
    rows = re.sub(r"<tr[^>]*>.*?</tr>", lambda row: _row(row[0], heads), match[2], flags=re.DOTALL)
    return f'<table class="{match[1]} cards">{rows}</table>'


def _least_width(table: str) -> int:
    """Characters that the longest words of the columns have beside each other."""
    longest: list[int] = []
    for row in re.findall(r"<tr[^>]*>.*?</tr>", table, re.DOTALL):
        cells = re.findall(r"<t[dh](?: [^>]*)?>(.*?)</t[dh]>", row, re.DOTALL)
        words = [html.unescape(TAG.sub("", cell)).split() for cell in cells]
        lengths = [max(map(len, each), default=0) for each in words]
        longest = [max(pair) for pair in zip_longest(longest, lengths, fillvalue=0)]
    return sum(longest)


def _row(row: str, heads: list[str]) -> str:
    names = iter(heads)
    return re.sub(r"<td(?=[ >])", lambda _: _cell(next(names, "")), row)


def _cell(head: str) -> str:
    return f'<td data-head="{html.escape(html.unescape(head))}"' if head else "<td"
