"""Impacts on one rigid stop that C takes alone: few are left to Python, and energy over many of them."""

from dataclasses import replace

import numpy as np
import pytest

import vibsim.engine.c_engine as c_engine
from tests.engine.runs import run
from tests.engine.test_closed_cases import harmonic, scene
from vibsim.engine.modes.rows import STRIKE
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    RigidStop,
)

G, H = 9.81, 0.05
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
    found = run(ball(1.0, (count + 0.1) * 2 * np.sqrt(2 * H / G)), ledger=True)
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
    fast = run(of, ledger=True, momentum=True)
    assert fast.totals["impacts"] > 100 and fast.totals["chatters"] + fast.totals["rests"] >= 1
    assert asked() < fast.totals["impacts"] / 8


@pytest.mark.parametrize("method", METHODS)
def test_bodies_and_a_shaken_box(asked, method):
    """Impacts of two bodies on each other and on walls that move, with works, losses and impulses."""
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
    fast = run(of, ledger=True, momentum=True)
    assert fast.totals["impacts"] > 20
    assert asked() <= 2


def drifting_oscillator(method, e=0.3):
    """Gallery case of that name: a driven mass strikes a slider that dry friction holds."""
    return scene(
        [Body("mass", 1.0, 0.0, 0.0), Body("slider", 0.5, 0.0, 0.0)],
        method,
        stops=(RigidStop("face", 0, 1, 0.02, COMPRESSION, e),),
        frictions=(Friction("ground_around", 1, GROUND, 8.0, 8.0, 0.0),),
        forces=(Force("drive", 0, 2.0, (harmonic(5.0, 2.0),)),),
        t_end=4.0,
    )


@pytest.mark.parametrize("method", METHODS)
def test_impacts_that_let_slip(asked, method):
    """Impacts that make a slider slip, and those on it while it slips: Python is asked where hops end."""
    of = drifting_oscillator(method)
    fast = run(of, ledger=True, momentum=True)
    impacts, ends = fast.totals["impacts"], fast.totals["chatters"]
    assert impacts > 150 and 4 <= ends < 10
    assert asked() <= 2 * ends + 2  # some hops before the last it is not clear whether they are


def test_impacts_that_turn_frictions_round(asked):
    """Two blocks on a belt, a rail and each other between two walls, one of which moves."""
    of = scene(
        [Body("a", 1.0, 0.0, 0.5), Body("b", 0.4, 0.01, -0.3)],
        stops=(
            RigidStop("between", 0, 1, 0.03, COMPRESSION, 0.9),
            RigidStop("left", GROUND, 0, 0.05, COMPRESSION, 1.0),
            RigidStop("right", 1, BASE, 0.06, COMPRESSION, 1.0),
        ),
        frictions=(
            Friction("belt", 0, GROUND, 0.3, 0.2, 0.15),
            Friction("rail", 1, BASE, 0.05, 0.1, 0.0),
            Friction("rub", 0, 1, 0.1, 0.1, 0.0),
        ),
        forces=(Force("drive", 0, 0.0, (harmonic(3.0, 1.1),)),),
        base=(harmonic(0.02, 1.7, 0.3),),
        t_end=8.0,
    )
    fast = run(of, ledger=True, momentum=True)
    assert fast.totals["impacts"] > 40 and fast.totals["reversals"] > 20
    assert asked() < fast.totals["impacts"] / 5


def test_a_rotor_is_struck_with_its_body(asked):
    """A motor of limited power on a body between two walls: each impact changes the speed of its rotor."""
    of = scene(
        [Body("body", 1.0, 0.0, 0.0)],
        stops=(
            RigidStop("left", GROUND, 0, 0.004, COMPRESSION, 0.8),
            RigidStop("right", 0, GROUND, 0.006, COMPRESSION, 0.8),
        ),
        frictions=(Friction("rail", 0, GROUND, 0.2, 0.2, 0.0),),
        motor=Motor(0, 0.2, 0.03, 1e-4, 0.05, 60.0, 0.0, 0.0),
        t_end=3.0,
    )
    fast = run(of, ledger=True, momentum=True)
    assert fast.totals["impacts"] > 40
    assert asked() < fast.totals["impacts"] / 5
    assert fast.totals["energy_residual"] == pytest.approx(0, abs=1e-12)


def test_what_sticks_on_the_base_is_struck_with_its_velocity():
    """A body that rides on a shaken base, another that hops on it: rounding of the stretch is left out of the
    impact.
    """
    of = scene(
        [Body("rider", 1.0, 0.0, 0.0), Body("carriage", 10.0**0.001, 0.0, 0.0)],
        stops=(RigidStop("buffer", 1, 0, 0.0, EXTENSION, 0.3, at_start=True),),
        frictions=(Friction("bed", BASE, 1, 0.39478417604357435, 0.39478417604357435, 0.0),),
        base=(
            Harmonic(-0.0035299999999999997, 6.283185307179586, 1.0, 0.0, 0.0),
            Harmonic(0.00263, 8.45629000211985, 1.3458603540559484, 0.0, 0.0),
        ),
        t_end=0.08,
        every_den=40,
    )
    fast = run(of, ledger=True, momentum=True)
    assert fast.totals["impacts"] > 10
