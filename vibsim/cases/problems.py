"""What is wrong with a case: one problem per line, all problems at once."""

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, and where.

    Attributes
    ----------
    file : path as the user gave it, "--set" for an override, or the name asked for
    line, column : counted from 1; None where there is no place (an override, a missing file)
    key : dotted key such as "excitation.Omega0"; empty where the problem belongs to no key
    message : what is wrong, what was found and what is allowed
    """

    file: str
    line: int | None
    column: int | None
    key: str
    message: str

    def __str__(self) -> str:
        key = shown(self.key, limit=100) if self.key else ""
        if self.line is None:
            return f"{f'{self.file} {key}'.strip()}: {self.message}"
        return f"{self.file}:{self.line}:{self.column}: {f'{key}: ' if key else ''}{self.message}"


class CaseError(Exception):
    """A case that cannot be used; `problems` lists everything that was found wrong with it."""

    def __init__(self, problems: Iterable[Problem]):
        self.problems = list(problems)
        super().__init__("\n".join(map(str, self.problems)))

    def __reduce__(self):
        return CaseError, (self.problems,)


def shown(text: object, limit: int = 60) -> str:
    """A user's text on one line, shortened, for use inside a message."""
    line = " ".join(str(text).split())
    printable = "".join(ch if ch.isprintable() else "?" for ch in line)
    if not printable:
        return "nothing"
    return printable if len(printable) <= limit else printable[: limit - 3] + "..."


def nearest(word: str, allowed: Iterable[str]) -> str | None:
    """The allowed word that `word` most likely stands for, or None; letter case is forgiven first."""
    names = list(allowed)
    for name in names:
        if name.casefold() == word.casefold():
            return name
    folded = {name.casefold(): name for name in reversed(names)}
    matches = get_close_matches(word.casefold()[:60], folded, n=1, cutoff=0.6)
    return folded[matches[0]] if matches else None


def did_you_mean(word: str, allowed: Iterable[str]) -> str:
    """ " (did you mean X?)", or an empty text where nothing allowed is near."""
    match = nearest(word, allowed)
    return f" (did you mean {match}?)" if match else ""
