"""What is wrong with a case: one problem per line, all problems at once."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from vibsim.cases.plain_text import one_line, plain_text

MOST_LISTED = 25  # problems of one case that are printed


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, and where.

    Attributes
    ----------
    file : path as the user gave it, "overrides" for one of them, or the name asked for
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
        file = plain_text(self.file)
        if self.line is None:
            return f"{f'{file} {key}'.strip()}: {self.message}"
        return f"{file}:{self.line}:{self.column}: {f'{key}: ' if key else ''}{self.message}"


class CaseError(Exception):
    """A case that cannot be used; `problems` lists everything that was found wrong with it.

    >>> import vibsim
    >>> try:
    ...     vibsim.load_case("II-B", {"c": "1 kg", "mu": -1})
    ... except vibsim.CaseError as error:
    ...     print([problem.key for problem in error.problems])
    ['coupling.c', 'friction.mu']
    """

    def __init__(self, problems: Iterable[Problem]):
        self.problems = list(problems)
        super().__init__("\n".join(listed(self.problems)))

    def __reduce__(self) -> tuple[Any, ...]:
        return CaseError, (self.problems,)


def listed(problems: Sequence[Problem]) -> list[str]:
    """A line for each problem, of many for the first ones: a file that is no case is wrong in every line."""
    more = len(problems) - MOST_LISTED
    rest = [f"and {more} more problem{'s' if more > 1 else ''}"] if more > 0 else []
    return [*map(str, problems[:MOST_LISTED]), *rest]


def shown(text: object, limit: int = 60) -> str:
    """A user's text on one line, shortened, for use inside a message."""
    line = one_line(text)
    if not line:
        return "nothing"
    return line if len(line) <= limit else line[: limit - 3] + "..."
