"""Cases: YAML files, read and checked to the last digit, and turned into scenes.

case = load_case("II-B", overrides={"excitation.Omega0": "6.5 Hz"})
scene = case.scene()
"""

from vibsim.cases.case import Case
from vibsim.cases.json_schema import case_schema
from vibsim.cases.keys import UnknownKeyError
from vibsim.cases.loading import load_case
from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.ranges import RangeError, RangeValue, parse_range
from vibsim.cases.sources import gallery_case_names, hard_case_names, shipped_case_names

__all__ = [
    "Case",
    "CaseError",
    "Problem",
    "RangeError",
    "RangeValue",
    "UnknownKeyError",
    "case_schema",
    "gallery_case_names",
    "hard_case_names",
    "load_case",
    "parse_range",
    "shipped_case_names",
]
