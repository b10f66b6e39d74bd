"""Where a file comes from: the root attributes that every kind of file has."""

import platform
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim import __version__
from vibsim.files.declarations import TEXT, Attribute

if TYPE_CHECKING:
    from vibsim.cases import Case

FORMAT = 1  # raised when an older reader would misread a newer file
CASE = ("case_name", "case_yaml", "case_resolved_json", "case_sha256")
MACHINE = ("date_created", "platform", "python_version", "numpy_version")
PROVENANCE = [Attribute(name, TEXT) for name in ("title", "vibsim_version", *CASE, *MACHINE)]
ENGINE = Attribute("engine", TEXT, allowed=("c", "python"))  # that made it


def provenance(kind: str, case: "Case", title: str = "") -> dict[str, Any]:
    """Format, kind, case, versions and platform of a file that is made now.

    title : that of the case unless given
    """
    return {
        "Conventions": "CF-1.8",
        "title": title or case.title or case.name,
        "vibsim_format": FORMAT,
        "vibsim_kind": kind,
        "vibsim_version": __version__,
        "case_name": case.name,
        "case_yaml": case.text,
        "case_resolved_json": case.resolved_json(),
        "case_sha256": case.sha256,
        "date_created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "platform": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python_version": platform.python_version(),
        "numpy_version": np.__version__,
    }
