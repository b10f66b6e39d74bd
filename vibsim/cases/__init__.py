"""Cases: YAML files, read and checked to the last digit, and turned into scenes.

case = load_case("II-B", overrides={"excitation.Omega0": "6.5 Hz"})
scene = case.scene()
"""

from vibsim.cases.case import Case
from vibsim.cases.loading import load_case
from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.sources import shipped_case_names

__all__ = ["Case", "CaseError", "Problem", "load_case", "shipped_case_names"]
