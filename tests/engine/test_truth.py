"""Runs of many digits of scenes made of parts check each other, and the engines in doubles."""

from dataclasses import fields, is_dataclass, replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.random_parts import LENGTH, part_scenes
from tests.engine.runs import Run, outcome, whole
from vibsim.cases import load_case
from vibsim.engine.truth import open_truth
from vibsim.physics.arithmetic import number_kits
from vibsim.physics.parts import GROUND, Body, Friction, Harmonic, Link, RigidStop, Scene

pytest.importorskip("flint")
GALLERY = Path(__file__).parents[2] / "cases" / "gallery"
CLOSE = 1e-12 * LENGTH  # rounding of some hundred stretches of 1e-16 each, grown by a few impacts
KEPT = ("order", "tol", "every_num", "every_den")  # what is no physical number


def exact_parts(scene):
    """Makes the scene whose numbers are exactly those doubles, but for what follows from others: an omega is
    2 pi times its cycles, and the gap of a rigid stop that touches at the start is where its ends are.
    """

    def convert(part, number, pi):
        if isinstance(part, Harmonic):
            amplitude, phase = (number(Fraction(getattr(part, name))) for name in ("amplitude", "phase"))
            cycles = Fraction(part.cycles) + Fraction(part.cycles_lo)
            return Harmonic(amplitude, 2 * pi * number(cycles), cycles, 0, phase)
        if is_dataclass(part):
            names = [field.name for field in fields(part) if field.name not in KEPT]
            return replace(part, **{name: convert(getattr(part, name), number, pi) for name in names})
        if isinstance(part, tuple):
            return tuple(convert(one, number, pi) for one in part)
        return number(Fraction(part)) if isinstance(part, float) else part

    def make(number, pi):
        parts = convert(scene, number, pi)
        base = sum((term.amplitude * sine(term.phase) for term in parts.base), number(0))
        places = [*(body.x for body in parts.bodies), base, number(0)]  # BASE is -2, GROUND -1
        stops = (touching(stop, places) if touches(stop) else stop for stop in parts.stops)
        return replace(parts, stops=tuple(stops))

    return make


def touches(stop):
    """Whether a stop is a rigid one whose ends meet at the start."""
    return isinstance(stop, RigidStop) and stop.at_start


def touching(stop, places):
    """The stop with the gap that its ends leave."""
    return replace(stop, gap=-(stop.sense * (places[stop.P] - places[stop.Q])))


def sine(phase):
    """Sine of a phase [rad] in python-flint's numbers."""
    return phase.sin()


def truth(make, digits, **options):
    """(samples as doubles, events, digits of the events, totals) of a run of many digits."""
    trajectory = open_truth(make, digits, **options)
    blocks = list(trajectory.blocks())
    tables = [whole([getattr(b, name) for b in blocks]) for name in ("samples", "events", "event_digits")]
    return (*tables, trajectory.totals)


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
    without = {name: kit for name, kit in number_kits.KITS.items() if name != "flint"}
    monkeypatch.setattr(number_kits, "KITS", without)  # put back, flint would come second
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
