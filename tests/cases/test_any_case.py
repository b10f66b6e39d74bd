"""A text of any kind, and any damage to a case, gives a case or its problems and never anything else."""

import string
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibsim.cases import CaseError, load_case
from vibsim.cases.case import load_case_text
from vibsim.cases.quantities import UNITS

number = st.decimals(allow_nan=False, allow_infinity=False, min_value="1e-9", max_value="1e9").map(str)


@st.composite
def quantities(draw, dimension, signs=("",)):
    names = [unit.name for unit in UNITS.values() if unit.dimension == dimension]
    return f"{draw(st.sampled_from(signs))}{draw(number)} {draw(st.sampled_from(names))}".strip()


@st.composite
def changes(draw):
    """Overrides of II-B that are all valid."""
    drawn = {
        "m1": quantities("mass"), "k1": quantities("stiffness"), "c": quantities("damping"),
        "G": quantities("length", ("", "-")), "k2": quantities("stiffness"), "mu": quantities("number"),
        "e": quantities("length", ("", "-")), "J": quantities("inertia"), "M0": quantities("torque"),
        "Omega0": quantities("angular rate"), "x1": quantities("length", ("", "-")),
        "phi": quantities("angle", ("-",)),
        "phidot": quantities("angular rate", ("-",)), "acts": st.sampled_from(["extension", "compression"]),
        "order": st.integers(4, 40), "on_violation": st.just("stop"), "value": quantities("length"),
    }  # fmt: skip
    keys = draw(st.sets(st.sampled_from(sorted(set(drawn) - {"on_violation"}))))
    keys |= {"on_violation"} if "value" in keys else set()
    return {key: draw(drawn[key]) for key in sorted(keys)}


PIECES = ["", "~", ":", "- ", "\n", "  ", "{", "}", "!!x ", "&a ", "*a", "<<: ", "none", "0x1", "\t"]
PIECES += ["ground", "base", "[ram, tool]", "[", "terms: ", "plus: ", "motor", "0 Hz", "none", "law: rigid"]
BASE = load_case("II-B")
HAMMER = (Path(__file__).parent / "parts/valid/hammer.yaml").read_text()


def only_case_or_problems(text, overrides=None):
    try:
        case = load_case_text(text, overrides)
    except CaseError as error:
        assert error.problems
        assert all(problem.message and str(problem).count("\n") == 0 for problem in error.problems)
    else:
        assert load_case_text(case.long_text()).scene() == case.scene()


@given(st.text(max_size=300))
def test_any_text_gives_a_case_or_its_problems(text):
    only_case_or_problems(text)


@given(st.text(alphabet="{}[]:,-&*!|>'\"%@`#?~ \n\tab1.<", max_size=80))
def test_any_punctuation_gives_a_case_or_its_problems(text):
    only_case_or_problems(text)
    only_case_or_problems(f"blocks: {text}\ncoupling: {{k1: 1}}\n")


@pytest.mark.parametrize("text", (BASE.text, HAMMER), ids=("II-B", "hammer"))
@given(data=st.data())
def test_a_damaged_case_gives_a_case_or_its_problems(data, text):
    """Cut a text anywhere, or put something into it."""
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 30)))
    insert = data.draw(st.sampled_from(PIECES) | st.text(string.printable, max_size=10))
    only_case_or_problems(text[:start] + insert + text[end:])


KEYS = [
    "bodies", "bodies.ram", "stops.wall", "stops.wall.between", "friction.guide.N", "friction.moon.mu",
    "friction.moon.plus", "forces.chord.terms", "forces.chord.terms.1", "forces.drive.A", "base",
    "base.terms", "motor", "initial", "initial.ram", "links.new.between", "run.every", "wall.k", "terms",
    "stop.k2",
]  # fmt: skip
VALUES = ["none", "", "1 kg", "[ram, ground]", "[ram", "{}", "3", "-1 N", "nan", "[ram, ram]", "0.1"]


@settings(max_examples=50)
@given(st.dictionaries(st.sampled_from(KEYS), st.sampled_from(VALUES), min_size=1, max_size=3))
def test_any_overrides_give_a_case_or_their_problems(overrides):
    only_case_or_problems(HAMMER, overrides)
