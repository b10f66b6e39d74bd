"""Properties: any valid case reads back exactly, and a text of any kind gives a case or its problems."""

import string

from hypothesis import given
from hypothesis import strategies as st

from vibsim.cases import Case, CaseError, load_case
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
BASE = load_case("II-B")


@given(changes())
def test_any_valid_case_reads_back_from_its_resolved_text(overrides):
    case = BASE.with_values(overrides)
    again = Case.from_resolved_json(case.resolved_json())
    assert again.values == case.values
    assert again.two_blocks() == case.two_blocks()
    assert again.sha256 == case.sha256
    assert again.resolved_json() == case.resolved_json()


def only_case_or_problems(text):
    try:
        case = load_case_text(text)
    except CaseError as error:
        assert error.problems
        assert all(str(problem).count("\n") == 0 and problem.message for problem in error.problems)
    else:
        assert case.two_blocks().m1 > 0


@given(st.text(max_size=300))
def test_any_text_gives_a_case_or_its_problems(text):
    only_case_or_problems(text)


@given(st.text(alphabet="{}[]:,-&*!|>'\"%@`#?~ \n\tab1.<", max_size=80))
def test_any_punctuation_gives_a_case_or_its_problems(text):
    only_case_or_problems(text)
    only_case_or_problems(f"blocks: {text}\ncoupling: {{k1: 1}}\n")


@given(st.data())
def test_a_damaged_case_gives_a_case_or_its_problems(data):
    """Cut a shipped text anywhere, or put something into it."""
    text = BASE.text
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 30)))
    pieces = st.sampled_from(
        ["", "~", ":", "- ", "\n", "  ", "{", "}", "!!x ", "&a ", "*a", "<<: ", "none", "0x1", "\t"]
    )
    insert = data.draw(pieces | st.text(string.printable, max_size=10))
    only_case_or_problems(text[:start] + insert + text[end:])
