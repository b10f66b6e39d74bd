"""Names and titles of the user's in a picture: shown as they are, never obeyed.

matplotlib takes text between two $ for mathematics, leaves labels that begin with _ out of legends, and
writes control characters into SVG files, which no XML parser then reads.
"""

from vibsim.cases.plain_text import one_line

HAIR_SPACE = "\u200a"


def as_text(text: object) -> str:
    """A user's text as matplotlib draws it letter by letter, on one line."""
    line = one_line(text).replace("$", r"\$")
    return HAIR_SPACE + line if line.startswith("_") else line
