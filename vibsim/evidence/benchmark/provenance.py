"""The root attributes of a bench file: what was measured, by what, on what machine."""

import json
import platform
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from vibsim.evidence.benchmark.plan import Plan
from vibsim.files.provenance import provenance
from vibsim.results.cores import available_cores

PACKAGES = ("scipy", "heyoka")


def origin(plan: Plan) -> dict[str, Any]:
    """Attributes that are known before the first row."""
    scene = plan.case.scene()
    return {
        **provenance("bench", plan.case),
        "t_end_s": float(scene.t_end),
        "check_times_s": plan.check_times,
        "limit_s": plan.limit,
        "methods": json.dumps([family.name for family in plan.families]),
        "not_installed": json.dumps([family.name for family in plan.absent()]),
        "cores": available_cores(),
        "processor": processor(),
        **{f"{package}_version": version_of(package) for package in PACKAGES},
    }


def version_of(package: str) -> str:
    """Version of an installed package, or the word none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"


def processor() -> str:
    """Name of the processor, as far as the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            names = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.processor() or platform.machine()
