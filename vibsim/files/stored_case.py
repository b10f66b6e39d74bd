"""The case in a result file."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibsim.cases.problems import CaseError
from vibsim.files.checking import damaged

if TYPE_CHECKING:
    from vibsim.cases import Case

WRONG = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError, CaseError)


@contextmanager
def understood(path: Path, else_damaged: str) -> Iterator[None]:
    """Turn whatever is raised over data that make no sense into a ResultFileError that says so."""
    try:
        yield
    except WRONG as error:
        raise damaged(path, else_damaged) from error


def stored_case(path: Path, attrs: Mapping[str, Any]) -> "Case":
    """The case that the attributes of a file describe. Raises ResultFileError where they do not."""
    from vibsim.cases import Case

    try:
        case = Case.from_resolved_json(attrs["case_resolved_json"])
    except CaseError as error:
        problem = error.problems[0]
        key = f"{problem.key}: " if problem.key else ""
        raise damaged(path, f"the attribute case_resolved_json: {key}{problem.message}") from error
    except RecursionError as error:
        raise damaged(path, "the attribute case_resolved_json is nested too deep") from error
    return replace(case, text=attrs["case_yaml"], source=str(path))
