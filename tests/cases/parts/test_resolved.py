"""The resolved long form of any case reads back to the same scene, and to the same fingerprint."""

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cases.test_any_case import BASE, changes, quantities
from vibsim.cases import Case, hard_case_names, load_case, shipped_case_names
from vibsim.cases.case import load_case_text

VALID = Path(__file__).parent / "valid"
FILES = [*sorted(VALID.glob("*.yaml")), *sorted(VALID.parents[1].glob("valid/*.yaml"))]


def reads_back(case):
    again = load_case_text(case.long_text(), name=case.name)
    assert again.scene() == case.scene()
    assert again.long_text() == case.long_text()
    assert (again.name, again.title) == (case.name, case.title)
    if case.is_long:
        assert (again.values, again.sha256) == (case.values, case.sha256)
    again = Case.from_resolved_json(case.resolved_json())
    assert (again.values, again.sha256, again.scene()) == (case.values, case.sha256, case.scene())
    assert (again.resolved_json(), again.name, again.title) == (case.resolved_json(), case.name, case.title)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_case(path):
    case = load_case(path)
    reads_back(case)
    assert case.with_values({}).scene() == case.scene()


@pytest.mark.parametrize("name", [*shipped_case_names(), *hard_case_names()])
def test_a_shipped_case(name):
    reads_back(load_case(name))


@settings(max_examples=100)
@given(changes())
def test_any_case_of_the_short_form(overrides):
    reads_back(BASE.with_values(overrides))


NAMES = st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,6}", fullmatch=True)
RESERVED = {"ground", "base", "motor", "none", "time", "t", "kind", "part", "phi", "phidot", "contact"}
TITLES = st.text(st.characters(codec="utf-8", categories=("L", "N", "P", "S", "Zs")), max_size=20)


@st.composite
def long_cases(draw):
    """Cases in the long form with parts of every kind between random ends."""
    names = draw(st.lists(NAMES, min_size=9, max_size=9, unique=True))
    names = [
        f"{name}_{i}" if name in RESERVED or name[:2] in ("x_", "v_") else name
        for i, name in enumerate(names)
    ]
    bodies, free = names[:3], iter(names[3:])

    def ends():
        return [draw(st.sampled_from(bodies)), draw(st.sampled_from(("ground", "base")))]

    def amount(dimension, *signs):
        return draw(quantities(dimension, signs or ("",)))

    case = {
        "title": draw(TITLES),
        "bodies": {name: amount("mass") for name in bodies},
        "links": {next(free): {"between": bodies[:2], "k": amount("stiffness")}},
        "stops": {
            next(free): {
                "between": ends(), "gap": amount("length", "", "-"), "k": amount("stiffness"),
                "c": amount("damping"), "acts": draw(st.sampled_from(("extension", "compression"))),
                "release": draw(st.sampled_from(("gap", "force"))),
            },
            next(free): {"between": [bodies[2], "base"], "gap": 0, "acts": "extension", "k": 1},
        },
        "friction": {next(free): {"between": ends(), "belt": amount("velocity", "", "-")}
                     | draw(st.sampled_from(({"mu": 0.2}, {"plus": {"mu": 0}, "minus": {"mu": 1.5}})))
                     | draw(st.sampled_from(({}, {"g": "1.62 m/s^2"}, {"N": "3 N"})))},
        "forces": {
            next(free): {"on": draw(st.sampled_from(bodies)), "F0": amount("force", "", "-")},
            next(free): {"on": bodies[0], "terms": [
                {"A": amount("force", "", "-"), "omega": amount("angular rate"),
                 "phase": amount("angle", "", "-")}
                for _ in range(draw(st.integers(1, 3)))
            ]},
        },
        "base": {"a": amount("length"), "omega": amount("angular rate")},
        "initial": {bodies[1]: {"x": amount("length", "", "-"), "v": amount("velocity", "", "-")}},
    }  # fmt: skip
    return load_case_text(json.dumps(case, ensure_ascii=False))


@settings(max_examples=20)
@given(long_cases())
def test_any_case_of_the_long_form(case):
    reads_back(case)


def test_resolved_text_of_a_shipped_case():
    text = load_case("I-A").long_text()
    assert "bodies: {1: 0.297 kg, 2: 2.94 kg}" in text
    assert (
        "  stop: {between: [1, 2], gap: 1 mm, acts: extension, law: elastic, k: 12400 N/m, c: 0 N s/m, "
        in text
    )
    assert "  excitation: {on: 1, A: 0.0725 N, omega: 3.5 Hz, phase: 0 rad, F0: 0 N}" in text
