"""Results: a run recorded, written, read back and asked for its state at any instant.

    result = simulate(load_case("II-B"))
    result.save("II-B.h5")
    open_trajectory_file("II-B.h5")["x2"]

Names are imported when they are used: h5py takes longer to import than most runs take to run.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.files.errors import ResultFileError
    from vibsim.results.opening import is_result_file, kind_of, open_trajectory_file
    from vibsim.results.result import Result
    from vibsim.results.simulation import simulate, simulate_to_file

_HOMES = {
    "Result": "vibsim.results.result",
    "ResultFileError": "vibsim.files.errors",
    "is_result_file": "vibsim.results.opening",
    "kind_of": "vibsim.results.opening",
    "open_trajectory_file": "vibsim.results.opening",
    "simulate": "vibsim.results.simulation",
    "simulate_to_file": "vibsim.results.simulation",
}

__all__ = [
    "Result",
    "ResultFileError",
    "is_result_file",
    "kind_of",
    "open_trajectory_file",
    "simulate",
    "simulate_to_file",
]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
