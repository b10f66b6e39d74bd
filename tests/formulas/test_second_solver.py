"""Random scenes with formulas: events and states as a second solver has them, with equations of its own."""

import os
from dataclasses import replace

import numpy as np
import pytest

from tests.formulas import against_second_solver
from tests.formulas.against_second_solver import compared
from tests.formulas.drawn_models import Drawn
from tests.formulas.second_expressions import par, product
from tests.formulas.second_model import Force, Friction, Link, Model, Stop
from tests.formulas.second_solver import SecondSolver

FEW = range(1000, 1005)
MANY = range(2000, 2000 + int(os.environ.get("VIBSIM_SCENES", "400")))
K = par("k", 4.0, "N/m")


def agreement(seed):
    result = compared(seed)
    assert not result.disagreements, "\n".join([result.case, *result.disagreements[:6]])
    return result


@pytest.mark.parametrize("seed", FEW)
def test_a_scene_with_formulas(seed):
    agreement(seed)


def test_no_stick_follows_a_release_at_once():
    """A damper has its kink where the friction beside it lets go: the sliding velocity is zero at both."""
    agreement(1187)


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_many_scenes_with_formulas():
    results = [agreement(seed) for seed in MANY]
    followed = [result for result in results if not result.skipped]
    assert len(followed) > 0.95 * len(results)
    assert sum(result.events for result in followed) > 5 * len(followed)


def test_a_force_that_is_off_by_a_millionth_is_noticed(monkeypatch):
    """The comparison can fail."""

    class Heavier(Drawn):
        def __init__(self, seed):
            super().__init__(seed)
            bodies = {name: (m * (1 + 1e-6), x, v) for name, (m, x, v) in self.model.bodies.items()}
            self.model = replace(self.model, bodies=bodies)

    monkeypatch.setattr(against_second_solver, "Drawn", Heavier)
    assert sum(bool(compared(seed).disagreements) for seed in FEW[:3]) >= 2


@pytest.mark.slow
def test_an_event_that_is_missing_is_noticed(monkeypatch):
    class WithoutStops(Drawn):
        def __init__(self, seed):
            super().__init__(seed)
            self.model = replace(self.model, stops=[])

    monkeypatch.setattr(against_second_solver, "Drawn", WithoutStops)
    assert any("events of stop" in told for seed in FEW for told in compared(seed).disagreements)


# The second solver against closed forms.


def test_it_swings_as_a_spring_does():
    link = Link("s", "a", "ground", product(K, ("name", "d")))
    solver = SecondSolver(Model({"a": (1.0, 0.3, 0.0)}, links=[link], t_end=5.0))
    [state] = solver.run([5.0])
    assert state == pytest.approx([0.3 * np.cos(10), -0.6 * np.sin(10)], abs=1e-11)


def test_it_slides_and_stops():
    """v0/(mu g) = 1 s, and stays."""
    rub = Friction("rub", "a", "ground", par("N", 2.0, "N"), par("mu", 0.25))
    solver = SecondSolver(Model({"a": (1.0, 0.0, 0.5)}, frictions=[rub], t_end=3.0))
    [state] = solver.run([3.0])
    assert state == pytest.approx([0.25, 0.0], abs=1e-12)
    assert [event[1:] for event in solver.events] == [("stick_begin", "rub")]
    assert solver.events[0][0] == pytest.approx(1.0, abs=1e-12)


def test_it_strikes_and_bounces():
    """A ball thrown up against a ceiling at 1 m/s returns at e times that."""
    ceiling = Stop("top", "a", "ground", 0.5, 1, e=0.6)
    solver = SecondSolver(Model({"a": (2.0, 0.0, 1.0)}, stops=[ceiling], t_end=1.0))
    [state] = solver.run([1.0])
    assert state == pytest.approx([0.5 - 0.6 * 0.5, -0.6], abs=1e-12)


def test_it_meets_hertz():
    """12.811349348246876 ms."""
    wall = Stop("wall", "a", "ground", 1e-3, 1, product(par("K", 1e6, "N/m^1.5"), ("**", ("name", "p"), 1.5)))
    solver = SecondSolver(Model({"a": (1.0, 0.0, 1.0)}, stops=[wall], t_end=0.03))
    solver.run([0.03])
    (begin, *_), (end, *_) = solver.events
    assert end - begin == pytest.approx(12.811349348246876e-3, abs=1e-11)


def test_it_switches_at_a_knot():
    """1 N from 0.3 s on: v = 0.7 m/s at 1 s."""
    push = Force(
        "push", "a", ("where", ("name", "t"), "<", par("T", 0.3, "s"), ("num", 0), par("F", 1.0, "N"))
    )
    solver = SecondSolver(Model({"a": (1.0, 0.0, 0.0)}, forces=[push], t_end=1.0))
    [state] = solver.run([1.0])
    assert state == pytest.approx([0.245, 0.7], abs=1e-12)
    assert [event[1:] for event in solver.events] == [("switch", "push")]
