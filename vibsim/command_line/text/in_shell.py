"""Messages that name arguments of Python, in the words of the command line: force=True is --force here."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.cases.problems import Problem

PLACES = {
    "overrides": "--set",
    "axes": "--param",
    "spread": "--spread",
    "free": "--free",
}  # of values of a case
PHRASES = (
    (r"\bforce=True (?=replaces|drops)", "--force "),
    (r"\(sweep with axes=\{KEY: RANGE\}\)", "(sweep with --param KEY=RANGE)"),
    (r"\(sweep with axes=\{KEY: RANGE\}, ensemble=N\)", "(sweep with --param KEY=RANGE, --ensemble N)"),
    (r"\(sweep with compute='([a-z-]+)'\)", r"(sweep with --compute \1)"),
    (r'\(continue_branch\(orbit, "Omega0", "FROM:TO"\)\)', "(vibsim continue --omega0)"),
    (r"\(search_orbits\), or give period=N$", "(--search), or give --period"),
    (r'such as spread=\{"x1": "1 mm"\}', "such as --spread x1=1mm"),
    (r"ask for none: ensemble=0$", "ask for none: --ensemble 0"),
)


def in_shell(text: str) -> str:
    """A message of the library with options in place of arguments."""
    for python, option in PHRASES:
        text = re.sub(python, option, text)
    return text


def problem_in_shell(problem: Problem) -> Problem:
    """A problem of a case; where an argument brought the value, its place is the option."""
    at_option = problem.line is None and problem.key
    place = PLACES.get(problem.file, problem.file) if at_option else problem.file
    return replace(problem, file=place, message=in_shell(problem.message))
