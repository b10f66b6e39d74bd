"""Rules for the names of bodies and parts: they become columns of a file and words of a command."""

import re
from collections.abc import Iterable, Iterator

from vibsim.cases.parts.draft import CALLED, PARTS, Draft, Finding
from vibsim.cases.parts.ends import NO_BODIES
from vibsim.cases.problems import shown
from vibsim.physics.parts import columns_of

LONGEST = 24  # characters: x_NAME stays a variable name in MATLAB
WORDS = (*NO_BODIES, "motor", "none")  # with a meaning of their own
# columns and groups of files, whether a file has them or not
COLUMNS = (
    "time",
    "t",
    "kind",
    "part",
    "phi",
    "phidot",
    "phase",
    "before_phidot",
    "contact",
    "error_estimate",
)
GROUPS = ("events", "digits", "orbit")
_BODY = re.compile(r"[A-Za-z0-9][A-Za-z0-9_]*", re.ASCII)
_PART = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def names_are_names(draft: Draft) -> Iterator[Finding]:
    """Letters, digits and _; a body may be called by a number."""
    for section in CALLED:
        pattern, first = (_BODY, "letter or digit") if section == "bodies" else (_PART, "letter")
        for name in draft.section(section):
            key = f"{section}.{name}"
            if not pattern.fullmatch(name) or len(name) > LONGEST:
                message = (
                    f"the name of a {CALLED[section]} may hold letters, digits and _, begins with a {first} "
                    f"and has at most {LONGEST} characters; got {shown(name)}"
                )
                yield Finding(key, message, of_the_name=True)
            elif name in WORDS:
                message = (
                    f"the name is taken by an end or a part; so are {_others(name, WORDS)}; choose another"
                )
                yield Finding(key, message, of_the_name=True)
            elif section != "bodies" and name in COLUMNS + GROUPS:
                others = _others(name, COLUMNS + GROUPS)
                message = f"the name is taken by a column or group of files; so are {others}; choose another"
                yield Finding(key, message, of_the_name=True)


def _others(name: str, names: Iterable[str]) -> str:
    return ", ".join(other for other in names if other != name)


def names_are_different(draft: Draft) -> Iterator[Finding]:
    """A part is found by its name alone, so no two bodies or parts share one."""
    first: dict[str, str] = {}
    for section in CALLED:
        for name in draft.section(section):
            if name in first:
                owner = CALLED[first[name]]
                message = (
                    f"{shown(name)} is the name of a {owner} already ({first[name]}.{name}); choose another"
                )
                yield Finding(f"{section}.{name}", message, of_the_name=True)
            first.setdefault(name, section)


def names_are_no_columns(draft: Draft) -> Iterator[Finding]:
    """A part named x_ram would share its column with the displacement of the body ram."""
    columns = {column: body for body in draft.bodies for column in columns_of(body)}
    columns |= {f"before_{columns_of(body)[1]}": body for body in draft.bodies}
    for section in PARTS:
        for name in draft.section(section):
            if name in columns:
                message = f"{name} is a column of body {columns[name]}; choose another name"
                yield Finding(f"{section}.{name}", message, of_the_name=True)
