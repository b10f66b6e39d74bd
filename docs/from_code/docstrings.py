"""Docstrings as Sphinx reads them: plain text, and what a name means in place of its type."""

import re
from typing import Any

COLON = "\ufdd0"  # stands for one, in no text
ENTRY = re.compile(r"(\*{0,2}\w+(?:, \*{0,2}\w+)*) : (.+)")  # of a list of parameters or attributes


def setup_docstrings(app: Any) -> None:
    """Have every docstring made ready before napoleon reads it, which has priority 500."""
    app.connect("autodoc-process-docstring", before_napoleon, priority=400)
    app.connect("autodoc-process-docstring", after_napoleon, priority=600)


def before_napoleon(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Lists end where they end, and nothing but a type is taken for one."""
    end_lists(lines)
    meanings_below_names(lines)
    if what in ("attribute", "property") and lines:
        lines[0] = lines[0].replace(":", COLON)  # napoleon takes what stands before it for a type


def after_napoleon(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """The text as it was written."""
    lines[:] = [plain_text(line.replace(COLON, ":")) for line in lines]


def end_lists(lines: list[str]) -> None:
    """End lists of parameters before a paragraph that names none: napoleon waits for two blank lines."""
    for i in range(len(lines) - 1, 0, -1):
        heads_section = i + 1 < len(lines) and lines[i + 1].startswith("---")
        begins = not lines[i - 1] and lines[i][:1].strip()
        if begins and not heads_section and (not ENTRY.match(lines[i]) or lines[i].startswith(">>>")):
            lines.insert(i, "")


def meanings_below_names(lines: list[str]) -> None:
    """Set what a name means below it: what stands after its colon is a type to napoleon."""
    for i in range(len(lines) - 1, -1, -1):
        entry = ENTRY.fullmatch(lines[i])
        if entry:
            lines[i : i + 1] = [entry[1], "    " + entry[2]]


def plain_text(line: str) -> str:
    """|x| is a magnitude, and `Orbit`s a plural."""
    if line.lstrip().startswith((">>>", "...")):
        return line
    return re.sub(r"`(\w+)`(?=\w)", r"``\1``\\ ", line).replace("|", r"\|")
