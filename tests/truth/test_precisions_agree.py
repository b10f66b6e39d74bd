"""Truth runs check each other: precisions, flows, number types, and the engines in doubles."""

import numpy as np
import pytest

import vibsim
from tests.truth.made import case, true_end
from vibsim.cases import shipped_case_names
from vibsim.engine.tangent.error_growth import error_growth
from vibsim.engine.trajectory import open_trajectory
from vibsim.engine.truth import open_truth
from vibsim.physics import precision
from vibsim.results.many_digits import agreement


@pytest.mark.parametrize("name", ["I-A", "I-C", "II-B"])
def test_two_precisions_agree(name):
    span = "6 s" if name.startswith("II") else "10 s"  # a motor costs the most
    _, coarse = true_end(name, span, 30)
    _, fine = true_end(name, span, 45)
    assert 23 < agreement(coarse, fine) < 31


@pytest.mark.parametrize("name", ["I-A", "I-B", "I-C-eq211"])
def test_closed_form_and_taylor_agree(name):
    totals, closed = true_end(name, "5 s", 40)
    others, series = true_end(name, "5 s", 40, method="taylor")
    assert [totals[key] for key in ("impacts", "sticks", "reversals")] == [
        others[key] for key in ("impacts", "sticks", "reversals")
    ]
    assert agreement(closed, series) > 35


@pytest.mark.parametrize(("name", "method"), [("I-A", "closed_form"), ("I-A", "taylor"), ("II-A", "taylor")])
def test_mpmath_agrees_with_flint(name, method, monkeypatch):
    t_end = "1.2 s" if name == "II-A" else "0.7 s"
    _, balls = true_end(name, t_end, 30, method)
    without = {name: kit for name, kit in precision.KITS.items() if name != "flint"}
    monkeypatch.setattr(precision, "KITS", without)  # put back, flint would come second
    trajectory = open_truth(case(name, t_end, method).exact_scene, 30)
    assert trajectory.kit.name == "mpf"
    *_, last = trajectory.blocks()
    end = {key: texts[-1].decode() for key, texts in last.event_digits.items()}
    for key, value in balls.items():
        assert abs(value - type(value)(end[key])) <= abs(value) * type(value)("1e-25"), key


@pytest.mark.parametrize("name", shipped_case_names())
def test_doubles_follow_the_truth(name):
    """Their distance stays below rounding times the growth that kicks find; in ideal cases below 1e-12 m."""
    span = "8 s" if name.startswith("II") else "20 s"  # 30 digits of a motor cost half a second a second
    short = case(name, span)
    *_, last = open_trajectory(short.scene()).blocks()
    _, end = true_end(name, span, 30)
    bound = 100 * 2.0**-53 * 10 ** error_growth(short.scene())
    for column in ("x1", "x2"):
        apart = abs(float(end[column]) - last.events[column][-1])
        assert apart < bound
        if name in ("I-A", "I-B", "I-C"):
            assert apart < 1e-12


@pytest.mark.parametrize("engine", ["c", "python"])
def test_doubles_take_the_same_events(engine):
    short = case("II-C", "12 s")
    expected, _ = true_end("II-C", "12 s", 30)
    trajectory = open_trajectory(short.scene(), engine)
    list(trajectory.blocks())
    for key in ("impacts", "sticks", "reversals"):
        assert trajectory.totals[key] == expected[key]


def test_a_run_ends_where_one_in_doubles_does():
    """0.7 s is no double: both runs end at the double nearest to it, with the sample that lies there."""
    short = case("I-A", "0.7 s", every="0.1 s")
    exact, doubles = vibsim.simulate(short, digits=30), vibsim.simulate(short)
    assert np.array_equal(exact.time, doubles.time)
    assert exact.events["t"][-1] == doubles.events["t"][-1] == 0.7
