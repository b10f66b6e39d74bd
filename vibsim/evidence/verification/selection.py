"""Which checks a list of names and prefixes stands for."""

from collections.abc import Iterable, Sequence

from vibsim.cases.spelling import did_you_mean
from vibsim.evidence.verification.check import Check


class UnknownCheckError(ValueError):
    """A name that no check has or begins with; the message names the nearest."""


def selected(checks: Sequence[Check], names: Iterable[str]) -> list[Check]:
    """The checks that the names stand for, in the order of the catalogue; all where there are none.

    V1 stands for V1/..., not for V10; hard/stiff for every check that begins so. Letter case does not matter.
    """
    chosen = {check.name for name in names for check in _named(checks, name)}
    return [check for check in checks if check.name in chosen] if chosen else list(checks)


def _named(checks: Sequence[Check], name: str) -> list[Check]:
    plain = name.strip().rstrip("/").casefold()
    whole = [check for check in checks if f"{check.name}/".casefold().startswith(f"{plain}/")]
    begun = [check for check in checks if check.name.casefold().startswith(plain)]
    if not plain or not (whole or begun):
        raise UnknownCheckError(f"no check {name!r}{did_you_mean(name, spellings(checks))}; see --list")
    return whole or begun


def spellings(checks: Sequence[Check]) -> list[str]:
    """Everything that names one check or several: V3, V3/taylor, hard/stiff-stop, ..."""
    names: dict[str, None] = {}
    for check in checks:
        parts = check.name.split("/")
        names |= {"/".join(parts[:count]): None for count in range(1, len(parts) + 1)}
    return list(names)
