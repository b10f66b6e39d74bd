"""Blows on one rigid stop that C takes by itself: bits of the Python engine, and energy over many of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibsim.engine.c_engine as c_engine
from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import differences, outcome, run
from tests.engine.test_closed_cases import harmonic, scene
from vibsim.engine.modes.rows import STRIKE
from vibsim.physics.parts import BASE, COMPRESSION, EXTENSION, GROUND, Body, Force, Link, RigidStop

G, H = 9.81, 0.05
MOST = 1500  # events
METHODS = ("auto", "taylor")


def ball(e, t_end, method="auto"):
    """A ball let fall from H onto the ground; next to no samples."""
    of = scene([Body("ball", 0.3, H, 0.0)], method, forces=(Force("g", 0, -0.3 * G, ()),), t_end=t_end)
    stop = RigidStop("floor", GROUND, 0, 0.0, COMPRESSION, e)
    return replace(of, stops=(stop,)).without_samples()


@pytest.fixture
def asked(monkeypatch):
    """Decisions at rigid stops that C leaves to Python."""
    kinds, decide = [], c_engine.CRun._decide

    def counting(self, number, event, *more):
        kinds.append(self.rows_of(number).events[event].kind)
        return decide(self, number, event, *more)

    monkeypatch.setattr(c_engine.CRun, "_decide", counting)
    return lambda: kinds.count(STRIKE)


def bounce(count):
    """Speeds in front of `count` impacts, and the loss, with e = 1."""
    found = run(ball(1.0, (count + 0.1) * 2 * np.sqrt(2 * H / G)), "c", ledger=True)
    assert found.totals["impacts"] == pytest.approx(count, abs=1)
    return np.abs(found.events["before_v_ball"][1:-1]), found.totals["loss_stops"]


def test_a_ball_keeps_its_energy(asked):
    """Speeds stay within two units in the last place of sqrt(2 g H); Python is not asked once."""
    speeds, loss = bounce(20_000)
    assert np.ptp(speeds) <= 2 * np.spacing(speeds[0]) and loss == 0
    assert speeds[0] == pytest.approx(np.sqrt(2 * G * H), rel=1e-15)
    assert asked() == 0


@pytest.mark.slow
def test_a_ball_keeps_its_energy_over_a_million_impacts():
    speeds, loss = bounce(1_000_000)
    assert np.ptp(speeds) <= 2 * np.spacing(speeds[0]) and loss == 0


@pytest.mark.parametrize("method", METHODS)
def test_chatter_is_pythons_at_its_end_alone(asked, method):
    """e = 0.8: 140 impacts from 1 s down to the resolution of time."""
    of = ball(0.8, 2.0, method)
    fast, slow = (run(of, engine, ledger=True, momentum=True) for engine in ("c", "python"))
    assert differences(fast, slow) == []
    assert fast.totals["impacts"] > 100 and fast.totals["chatters"] + fast.totals["rests"] >= 1
    assert asked() < fast.totals["impacts"] / 8


@pytest.mark.parametrize("method", METHODS)
def test_bodies_and_a_shaken_box(asked, method):
    """Blows of two bodies on each other and on walls that move, with works, losses and impulses."""
    of = scene(
        [Body("a", 1.0, 0.0, 0.2), Body("b", 0.4, 0.01, -0.1)],
        method,
        links=(Link("l", 0, BASE, 30.0, 0.2),),
        stops=(
            RigidStop("between", 0, 1, 0.002, COMPRESSION, 0.7),
            RigidStop("left", 0, BASE, 0.02, EXTENSION, 0.9),
            RigidStop("right", 1, BASE, 0.03, COMPRESSION, 1.0),
            RigidStop("far", 1, GROUND, 0.2, COMPRESSION, 0.5),
        ),
        base=(harmonic(0.01, 1.7, 0.3),),
        t_end=8.0,
    )
    fast, slow = (run(of, engine, ledger=True, momentum=True) for engine in ("c", "python"))
    assert differences(fast, slow) == [] and fast.totals["impacts"] > 20
    assert asked() <= 2


def assert_same(of):
    """Both engines, up to MOST events."""
    one, other = (outcome(of, engine, most=MOST, ledger=True, momentum=True) for engine in ("c", "python"))
    if isinstance(one, str) or isinstance(other, str):
        assert one == other
    elif len(one.events["t"]) < MOST:
        assert differences(one, other) == []


@settings(max_examples=25)
@given(rigid_scenes(radians=10.0, bodies=3, motor=False), st.sampled_from(METHODS))
def test_random_scenes_without_friction(of, method):
    assert_same(replace(of, method=method, frictions=()))


@pytest.mark.slow
@pytest.mark.timeout(3600)
@settings(max_examples=2000)
@given(rigid_scenes(radians=20.0, bodies=3), st.sampled_from(METHODS))
def test_many_random_scenes(of, method):
    assert_same(replace(of, method=method, frictions=()))
