"""Cases: YAML files, read and checked to the last digit, and turned into scenes.

case = load_case("II-B", overrides={"excitation.Omega0": "6.5 Hz"})
scene = case.scene()
"""

from typing import TYPE_CHECKING

from vibsim.lazy_names import lazy_names

if TYPE_CHECKING:
    from vibsim.cases.case import Case as Case
    from vibsim.cases.loading import load_case as load_case
    from vibsim.cases.problems import CaseError as CaseError
    from vibsim.cases.problems import Problem as Problem
    from vibsim.cases.reading.sources import gallery_case_names as gallery_case_names
    from vibsim.cases.reading.sources import hard_case_names as hard_case_names
    from vibsim.cases.reading.sources import shipped_case_names as shipped_case_names
    from vibsim.cases.schema.json_schema import case_schema as case_schema
    from vibsim.cases.schema.keys import UnknownKeyError as UnknownKeyError
    from vibsim.cases.values.ranges import RangeError as RangeError
    from vibsim.cases.values.ranges import RangeValue as RangeValue
    from vibsim.cases.values.ranges import parse_range as parse_range

__getattr__, __dir__, __all__ = lazy_names(
    __name__,
    {
        "vibsim.cases.case": ["Case"],
        "vibsim.cases.schema.json_schema": ["case_schema"],
        "vibsim.cases.schema.keys": ["UnknownKeyError"],
        "vibsim.cases.loading": ["load_case"],
        "vibsim.cases.problems": ["CaseError", "Problem"],
        "vibsim.cases.values.ranges": ["RangeError", "RangeValue", "parse_range"],
        "vibsim.cases.reading.sources": ["gallery_case_names", "hard_case_names", "shipped_case_names"],
    },
)
