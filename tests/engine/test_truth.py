"""Runs of many digits of scenes made of parts check each other, and the engines in doubles."""

from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.many_digits import exact_parts, truth
from tests.engine.random_parts import LENGTH, part_scenes
from tests.engine.runs import Run, outcome
from vibsim.cases import load_case
from vibsim.physics import precision
from vibsim.physics.parts import GROUND, Body, Friction, Link, Scene

pytest.importorskip("flint")
GALLERY = Path(__file__).parents[2] / "cases" / "gallery"
CLOSE = 1e-12 * LENGTH  # rounding of some hundred stretches of 1e-16 each, grown by a few impacts


def ends(make, digits):
    """End state of a run by name, as Decimals of all its digits."""
    *_, digit_columns, totals = truth(make, digits)
    return {name: Decimal(texts[-1].decode()) for name, texts in digit_columns.items()}, totals


@settings(max_examples=25)
@given(part_scenes())
def test_doubles_follow_the_truth(scene):
    doubles = outcome(scene, "auto")
    if not isinstance(doubles, Run) or doubles.totals["uncertified"]:
        return  # a start at a gap or at rest, where rounding may decide
    samples, events, _, _ = truth(exact_parts(scene), 40)
    assert doubles.events["kind"].tolist() == events["kind"].tolist()
    assert doubles.events["part"].tolist() == events["part"].tolist()
    for name in (column for column in samples if column.startswith("x_")):
        assert np.abs(doubles.samples[name] - samples[name]).max() < CLOSE


@pytest.mark.slow
@pytest.mark.timeout(3600)
@settings(max_examples=1000)
@given(part_scenes())
def test_doubles_follow_the_truth_often(scene):
    test_doubles_follow_the_truth.hypothesis.inner_test(scene)


def place(name):
    """A shipped case, or a file of the gallery."""
    file = GALLERY / f"{name}.yaml"
    return file if file.exists() else name


def apart(one, other):
    """Largest difference of end states, relative where they are above 1e-3 of a unit."""
    return max(float(abs(one[name] - other[name]) / max(abs(other[name]), Decimal("1e-3"))) for name in one)


@pytest.mark.parametrize("name", ["I-B", "drifting-capsule", "percussive-drill", "stack-of-blocks"])
def test_two_precisions_agree(name):
    case = load_case(place(name), {"run.t_end": "0.5 s", "run.every": "50 s"})
    coarse, _ = ends(case.exact_scene, 30)
    fine, totals = ends(case.exact_scene, 45)
    assert apart(coarse, fine) < 1e-26
    assert totals["events"] > 5


@pytest.mark.parametrize("name", ["I-C", "drifting-capsule", "stack-of-blocks"])
def test_closed_form_and_taylor_agree(name):
    found = []
    for method in ("auto", "taylor"):
        case = load_case(place(name), {"run.t_end": "0.5 s", "run.every": "50 s", "run.method": method})
        found.append(ends(case.exact_scene, 40))
    assert apart(found[0][0], found[1][0]) < 1e-36
    assert found[0][1]["events"] == found[1][1]["events"] > 5


def test_mpmath_agrees_with_flint(monkeypatch):
    case = load_case(place("drifting-capsule"), {"run.t_end": "0.1 s", "run.every": "50 s"})
    balls, _ = ends(case.exact_scene, 30)
    without = {name: kit for name, kit in precision.KITS.items() if name != "flint"}
    monkeypatch.setattr(precision, "KITS", without)  # put back, flint would come second
    floats, totals = ends(case.exact_scene, 30)
    assert apart(balls, floats) < 1e-28
    assert totals["events"] > 2


def test_a_stick_ends_where_it_should_to_forty_digits():
    """A block on a belt, started at the belt's speed, slips where the spring pulls as hard as friction, at
    t = N / (k belt).
    """

    def make(number, pi):
        link = Link("l", 0, GROUND, number(4), number(0))
        friction = Friction("f", 0, GROUND, number(1), number(1), number(Fraction(3, 10)))
        body = Body("m", number(1), number(0), number(Fraction(3, 10)))
        return Scene((body,), (link,), (), (friction,), t_end=number(2), every_num=1, every_den=1)

    _, events, digits, totals = truth(make, 40, momentum=True)
    assert events["kind"].tolist()[:2] == [0, 5]
    assert abs(Fraction(digits["t"][1].decode()) - Fraction(5, 6)) < Fraction(1, 10**38)
    assert abs(totals["energy_residual"]) < 1e-15
    assert abs(totals["momentum_residual"]) < 1e-15
