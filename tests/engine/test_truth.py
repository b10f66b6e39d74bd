"""Runs of many digits of scenes made of parts check each other, and the engines in doubles."""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from math import sqrt
from pathlib import Path

import numpy as np
import pytest

from tests.engine.impacts import GRAVITY, ball, times
from tests.engine.many_digits import exact_parts, faults, truth
from tests.engine.random_formulas import formula_scene
from tests.engine.random_parts import LENGTH, part_scenes, rigid_scenes
from tests.engine.runs import Run, by_instant, outcome, run, scene_of
from tests.random_scenes import always
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.errors import EngineError
from vibsim.engine.truth import open_truth
from vibsim.physics.parts import EVENT_KINDS

GALLERY = Path(__file__).parents[2] / "cases" / "gallery"
CLOSE = 1e-12 * LENGTH  # rounding of some hundred stretches of 1e-16 each, grown by a few impacts


def ends(make, digits):
    """End state of a run by name, as Decimals of all its digits."""
    *_, digit_columns, totals = truth(make, digits)
    return {name: Decimal(texts[-1].decode()) for name, texts in digit_columns.items()}, totals


def assert_truth_followed(scene):
    doubles = outcome(scene)
    if not isinstance(doubles, Run) or doubles.totals["uncertified"]:
        return  # a start at a gap or at rest, where rounding may decide
    samples, events, _, totals = truth(exact_parts(scene), 40)
    if totals["uncertified"]:
        return
    assert by_instant(doubles.events) == by_instant(events)
    for name in (column for column in samples if column.startswith("x_")):
        assert np.abs(doubles.samples[name] - samples[name]).max() < CLOSE


test_doubles_follow_the_truth = always(assert_truth_followed, part_scenes(), few=25, many=1000)


def place(name):
    """A shipped case, or a file of the gallery."""
    file = GALLERY / f"{name}.yaml"
    return file if file.exists() else name


def apart(one, other):
    """Largest difference of end states, relative where they are above 1e-3 of a unit."""
    return max(float(abs(one[name] - other[name]) / max(abs(other[name]), Decimal("1e-3"))) for name in one)


@pytest.mark.parametrize("name", ["I-A", "I-C", "drifting-capsule", "percussive-drill", "stack-of-blocks"])
def test_two_precisions_agree(name):
    case = load_case(place(name), {"run.t_end": "0.5 s", "run.every": "50 s"})
    coarse, _ = ends(case.exact_scene, 30)
    fine, totals = ends(case.exact_scene, 45)
    assert apart(coarse, fine) < 1e-26
    assert totals["events"] > 5


@pytest.mark.parametrize("name", ["I-A", "I-B", "I-C", "I-C-eq211", "drifting-capsule", "stack-of-blocks"])
def test_closed_form_and_taylor_agree(name):
    found = []
    for method in ("auto", "taylor"):
        case = load_case(place(name), {"run.t_end": "0.5 s", "run.every": "50 s", "run.method": method})
        found.append(ends(case.exact_scene, 40))
    assert apart(found[0][0], found[1][0]) < 1e-36
    assert found[0][1]["events"] == found[1][1]["events"] > 5


def test_a_stick_ends_where_it_should_to_forty_digits():
    """A block on a belt slips where the spring pulls as hard as friction, at t = N / (k belt)."""

    case = load_case_text("""
bodies: {m: 1 kg}
links: {l: {between: [m, ground], k: 4 N/m}}
friction: {f: {between: [m, ground], N: 1 N, mu: 1, belt: 0.3 m/s}}
initial: {m: {v: 0.3 m/s}}
run: {t_end: 2 s, every: 1 s}
""")
    _, events, digits, totals = truth(case.exact_scene, 40, momentum=True)
    assert events["kind"].tolist()[:2] == [0, 5]
    assert abs(Fraction(digits["t"][1].decode()) - Fraction(5, 6)) < Fraction(1, 10**38)
    assert abs(totals["energy_residual"]) < 1e-15
    assert abs(totals["momentum_residual"]) < 1e-15


# Runs with rigid stops against the exact flow in 40 digits: none missed, none invented where certified.


IMPACT = EVENT_KINDS["impact"]


def assert_truth_followed_at_rigid_stops(scene):
    doubles = outcome(scene)
    if not isinstance(doubles, Run) or doubles.totals["uncertified"]:
        return  # rounding may decide, and the run says so
    assert faults(scene, doubles) == []


test_doubles_follow_the_truth_at_rigid_stops = always(
    assert_truth_followed_at_rigid_stops, rigid_scenes(radians=4.0), few=12, many=4000
)


def test_a_ball_comes_to_rest_in_many_digits():
    """After 9 sqrt(2 h / g) at e = 0.8, in as many digits as are asked for; in doubles to their rounding."""
    case = ball(0.8, t_end=5.0)
    _, events, _, totals = truth(exact_parts(case), 40)
    rest = events["t"][events["kind"] == EVENT_KINDS["rest_begin"]]
    assert rest == pytest.approx([sqrt(2 / GRAVITY) * 9], rel=2e-16)
    assert totals["chatter_time"] < 1e-38
    assert abs(times(run(case), "rest_begin")[0] - rest[0]) < 4e-14


def test_bodies_at_rest_on_each_other_meet_the_wall_in_many_digits():
    """The friction between bodies that rest on each other has no sliding velocity."""
    scene = scene_of("""
bodies: {a: 0.75 kg, b: 0.95 kg}
links: {l: {between: [b, a], k: 56.6 N/m}}
stops:
  wall: {between: [b, ground], gap: 1 mm, acts: extension, law: rigid, e: 0.5}
  soft: {between: [ground, a], gap: 0 m, acts: extension, k: 109 N/m}
  between: {between: [b, a], gap: -1 cm, acts: compression, law: rigid, e: 0.5}
friction: {f: {between: [b, a], N: 0.27 N, plus: {mu: 1}, minus: {mu: 1, static: 1.3}}}
initial: {a: {x: 1 cm, v: 6 cm/s}}
run: {t_end: 0.12 s, every: 5 ms}
""")
    doubles, (samples, events, *_) = outcome(scene), truth(exact_parts(scene), 40)
    walls = [
        table["t"][(table["kind"] == IMPACT) & (table["part"] == 0)] for table in (doubles.events, events)
    ]
    assert len(walls[0]) == len(walls[1]) == 1
    assert abs(walls[0] - walls[1]) < 1e-12
    assert samples["x_b"].min() >= -0.001


def test_a_run_that_creeps_towards_a_singularity_ends():
    """By steps within the rounding of the time, which move it all the same: for minutes in 30 digits."""
    scene = replace(formula_scene(28), t_end=0.3)
    with pytest.raises(EngineError, match="no step is short enough"):
        for _ in open_truth(exact_parts(scene), 30).blocks():
            pass
