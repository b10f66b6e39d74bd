"""Derived facts against numbers known from linear theory and from the published discussion of the cases."""

from math import pi, sqrt

import pytest

from vibsim.cases import load_case, shipped_case_names
from vibsim.cases.case import load_case_text
from vibsim.cases.validation import derived_facts


def facts(name, overrides=None):
    return {fact.name: fact.value for fact in derived_facts(load_case(name, overrides).scene())}


def test_case_one():
    found = facts("I-A")
    assert found["block 1 on its spring"] == pytest.approx(4.130, abs=5e-4)
    assert found["free"] == pytest.approx(4.3337, abs=5e-5)
    assert found["in contact"] == pytest.approx(34.397, abs=5e-4)
    assert found["bilinear"] == pytest.approx(7.6975, abs=5e-5)
    assert found["friction band"] == pytest.approx(0.001 * 2.94 * 9.81 / 200, rel=1e-14)
    assert "run-up time constant" not in found


def test_case_two():
    found = facts("II-B")
    assert found["free"] == pytest.approx(4.149, abs=5e-4)
    assert found["bilinear"] == pytest.approx(7.37, abs=5e-3)
    inertia = 0.001 + 0.03 * 0.11**2
    assert found["run-up time constant"] == pytest.approx(11 * pi * inertia / 0.005, rel=1e-14)
    assert found["full force"] == pytest.approx(load_case("I-B-eq211").two_blocks().A, rel=1e-14)


def test_a_wall_without_stop_and_friction():
    off = {"m2": "fixed", "stop": "none", "friction": "none", "excitation": "none", "c": "0.5 N s/m"}
    assert facts("II-B", off) == {
        "block 1 on its spring": pytest.approx(sqrt(200 / 0.297) / (2 * pi), rel=1e-14),
        "damping ratio": pytest.approx(0.25 / sqrt(200 * 0.297), rel=1e-14),
    }


def test_no_coupling_spring():
    found = facts("II-B", {"k1": "0 N/m", "M0": "0 N m"})
    assert found["free"] == found["bilinear"] == 0.0
    assert not {"damping ratio", "friction band", "run-up time constant"} & set(found)


def test_scenes_of_parts():
    """Two masses on springs in a row: w^2 = (3 +- sqrt(5))/2; bilinear: 1 and sqrt(30) rad/s."""
    found = facts("gallery/two-masses-with-friction")
    golden = sqrt((3 + sqrt(5)) / 2)
    assert found["open 1"] == pytest.approx(1 / golden / (2 * pi), rel=1e-12)
    assert found["open 2"] == pytest.approx(golden / (2 * pi), rel=1e-12)
    assert found["floor"] == 0.5
    bilinear = facts("gallery/bilinear-oscillator")
    assert bilinear["closed 1"] == pytest.approx(sqrt(30) / (2 * pi), rel=1e-14)
    assert bilinear["bilinear 1"] == pytest.approx(2 * sqrt(30) / (1 + sqrt(30)) / (2 * pi), rel=1e-14)


def test_a_spring_called_coupling_makes_no_machine_of_the_paper():
    """Three bodies in a row: the first link's name is a name."""
    text = """
    bodies: {a: 1 kg, b: 2 kg, c: 3 kg}
    links: {coupling: {between: [a, b], k: 100 N/m}, other: {between: [b, c], k: 50 N/m}}
    """
    assert {fact.name for fact in derived_facts(load_case_text(text).scene())} == {"open 1", "open 2"}


@pytest.mark.parametrize("name", shipped_case_names())
def test_the_long_form_of_the_papers_machine_is_known_as_such(name):
    case = load_case(name)
    assert derived_facts(load_case_text(case.long_text()).scene()) == derived_facts(case.scene())
    assert "block 1 on its spring" in {fact.name for fact in derived_facts(case.scene())}


def test_friction_of_bodies_that_turn_is_a_torque():
    text = """
bodies: {bit: 374 kg m^2}
friction: {rock: {between: [bit, ground], N: 1 kN m, mu: 1, static: 2.2}}
run: {t_end: 1 s, every: 0.1 s}
"""
    facts = [(fact.value, fact.unit, fact.meaning) for fact in derived_facts(load_case_text(text).scene())]
    assert facts == [(2200, "N m", "limit friction torque"), (1000, "N m", "friction torque while slipping")]
