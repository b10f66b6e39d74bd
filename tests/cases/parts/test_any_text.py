"""Any damage to a case of parts gives a case or its problems, never anything else."""

import string
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cases.test_any_case import PIECES
from vibsim.cases import CaseError
from vibsim.cases.case import load_case_text

TEXT = (Path(__file__).parent / "valid/hammer.yaml").read_text()
MORE = ["ground", "base", "[ram, tool]", "[", "terms: ", "plus: ", "motor", "0 Hz", "none", "law: rigid"]


def only_case_or_problems(text, overrides):
    try:
        case = load_case_text(text, overrides)
    except CaseError as error:
        assert error.problems
        assert all(problem.message and str(problem).count("\n") == 0 for problem in error.problems)
    else:
        assert load_case_text(case.long_text()).scene() == case.scene()


@settings(max_examples=50)
@given(st.data())
def test_a_damaged_case_gives_a_case_or_its_problems(data):
    start = data.draw(st.integers(0, len(TEXT)))
    end = data.draw(st.integers(start, min(len(TEXT), start + 30)))
    insert = data.draw(st.sampled_from([*PIECES, *MORE]) | st.text(string.printable, max_size=10))
    only_case_or_problems(TEXT[:start] + insert + TEXT[end:], {})


KEYS = [
    "bodies",
    "bodies.ram",
    "stops.wall",
    "stops.wall.between",
    "friction.guide.N",
    "friction.moon.mu",
    "friction.moon.plus",
    "forces.chord.terms",
    "forces.chord.terms.1",
    "forces.drive.A",
    "base",
    "base.terms",
    "motor",
    "initial",
    "initial.ram",
    "links.new.between",
    "run.every",
    "wall.k",
    "terms",
    "stop.k2",
]
VALUES = ["none", "", "1 kg", "[ram, ground]", "[ram", "{}", "3", "-1 N", "nan", "[ram, ram]", "0.1"]


@settings(max_examples=50)
@given(st.dictionaries(st.sampled_from(KEYS), st.sampled_from(VALUES), min_size=1, max_size=3))
def test_any_overrides_give_a_case_or_their_problems(overrides):
    only_case_or_problems(TEXT, overrides)
