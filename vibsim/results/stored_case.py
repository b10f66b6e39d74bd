"""The case in a result file."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibsim.results.structure import damaged

if TYPE_CHECKING:
    from vibsim.cases import Case


def stored_case(path: Path, attrs: Mapping[str, Any]) -> "Case":
    """The case that the attributes of a file describe. Raises ResultFileError where they do not."""
    from vibsim.cases import Case, CaseError

    try:
        case = Case.from_resolved_json(attrs["case_resolved_json"])
    except CaseError as error:
        problem = error.problems[0]
        key = f"{problem.key}: " if problem.key else ""
        raise damaged(path, f"the attribute case_resolved_json: {key}{problem.message}") from error
    except RecursionError as error:
        raise damaged(path, "the attribute case_resolved_json is nested too deep") from error
    return replace(case, text=attrs["case_yaml"], source=str(path))
