"""Pieces of Markdown: tables and text that is to be read as it stands."""

import re
from collections.abc import Iterable, Sequence

SPECIAL = re.compile(r"([\\`*_{}\[\]<>$|~^])")


def plain(text: str) -> str:
    """Text with everything that Markdown would read as markup escaped, on one line."""
    return SPECIAL.sub(r"\\\1", " ".join(text.split()))


def code(text: str) -> str:
    """Text in a code span; empty for no text."""
    return f"`{text}`".replace("|", "\\|") if text else ""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; its cells are Markdown, with pipes escaped already."""
    lines = [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]
    return "\n".join(lines) + "\n"


def fence(text: str, language: str = "text") -> str:
    """A code block."""
    return f"```{language}\n{text.rstrip()}\n```\n"


def with_code(text: str) -> str:
    """A paragraph whose `quoted` words stay code."""
    pieces = text.split("`")
    return "".join(code(piece) if i % 2 else _plain_inside(piece) for i, piece in enumerate(pieces))


def _plain_inside(text: str) -> str:
    """As `plain`, with the spaces at both ends kept."""
    if not text.strip():
        return " " if text else ""
    front, back = text[: len(text) - len(text.lstrip())], text[len(text.rstrip()) :]
    return f"{' ' if front else ''}{plain(text)}{' ' if back else ''}"
