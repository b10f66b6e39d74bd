"""User text as text: what a terminal would obey and no font can show is written out, such as \\x1b."""

import re
from unicodedata import category

UNSTORABLE = re.compile("[\0\ud800-\udfff]")  # the end of a text in HDF5; what UTF-8 does not take


def plain_text(text: object, allowed: str = "") -> str:
    """A text with every character that is not printed as an escape of ASCII characters.

    Control and format characters (colours, cursor, direction of writing), line breaks, lone surrogates and
    code points without a character become \\x1b, \\n, \\u202e ...; those in `allowed` stay as they are.
    """
    return "".join(
        ch if ch.isprintable() or ch in allowed or category(ch) == "Zs" else _escape(ch) for ch in str(text)
    )


def one_line(text: object) -> str:
    """A plain text on one line, runs of white space as one blank."""
    return plain_text(" ".join(str(text).split()))


def unstorable(text: str) -> str:
    """The first character of a text that files cannot hold (null, lone surrogates), written out."""
    match = UNSTORABLE.search(text)
    return _escape(match.group()) if match else ""


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
