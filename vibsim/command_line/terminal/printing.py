"""What the command prints: text in which nothing of the user's is obeyed, and JSON."""

import json
import os
import re
from typing import Any

import click

from vibsim.files.plain_data import plain

_OWN = f"\x1b{os.urandom(8).hex()}"  # begins the colours of vibsim's own until they are printed
# control and format characters that JSON may hold as they are, and surrogates, which UTF-8 does not take
_UNSAFE_IN_JSON = re.compile(
    "[\x7f-\x9f\u00ad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
)


def style(text: object, **look: Any) -> str:
    """A text in colour or bold, as `click.style`; `say` prints it so."""
    from vibsim.cases.plain_text import plain_text

    return click.style(plain_text(text), **look).replace("\x1b", _OWN)


def say(text: str = "", err: bool = False, nl: bool = True, lines: bool = False) -> None:
    """Print a line; control characters in it are written out (\\x1b), but for `style`.

    lines : whether the text may have line ends of its own; in a line they come from a name of the user's
    """
    from vibsim.cases.plain_text import plain_text

    allowed = "\n\t" if lines else "\t"
    parts = [plain_text(part, allowed) for part in text.split(_OWN)]
    click.echo("\x1b".join(parts), err=err, nl=nl)


def print_json(value: Any, indent: int | None = None) -> None:
    """Print JSON, on one line unless indented; null for what is not finite, because NaN is no JSON."""
    text = json.dumps(plain(value), allow_nan=False, ensure_ascii=False, indent=indent)
    click.echo(_UNSAFE_IN_JSON.sub(_escaped, text))


def _escaped(match: re.Match[str]) -> str:
    return f"\\u{ord(match[0]):04x}"
