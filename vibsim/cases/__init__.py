"""Cases: YAML files, read and checked to the last digit, and turned into scenes.

case = load_case("II-B", overrides={"excitation.Omega0": "6.5 Hz"})
scene = case.scene()
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.cases.case import Case as Case
    from vibsim.cases.case import load_case as load_case
    from vibsim.cases.problems import CaseError as CaseError
    from vibsim.cases.problems import Problem as Problem
    from vibsim.cases.quantities import RangeError as RangeError
    from vibsim.cases.quantities import RangeValue as RangeValue
    from vibsim.cases.quantities import parse_range as parse_range
    from vibsim.cases.schema_keys import UnknownKeyError as UnknownKeyError
    from vibsim.cases.schema_keys import case_schema as case_schema
    from vibsim.cases.sources import gallery_case_names as gallery_case_names
    from vibsim.cases.sources import hard_case_names as hard_case_names
    from vibsim.cases.sources import shipped_case_names as shipped_case_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
