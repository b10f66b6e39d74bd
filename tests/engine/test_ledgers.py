"""Energy and momentum are neither made nor lost: the ledgers close to round-off, and every entry is the work
or the loss that mechanics says it is.
"""

from dataclasses import replace
from math import exp, pi

import numpy as np
import pytest

from tests.engine.random_parts import LENGTH, RATE, part_scenes
from tests.engine.runs import Run, outcome, run, scene_of
from tests.engine.test_closed_cases import METHODS, ON_A_BELT, case
from tests.random_scenes import always

# rounding of some hundred stretches of 12 nodes each, of energies and momenta that go in and out many times
ENERGY, MOMENTUM = 1e-12 * (LENGTH * RATE) ** 2, 1e-12 * LENGTH * RATE


def assert_closed(scene):
    for method in METHODS:
        result = outcome(replace(scene, method=method), momentum=True)
        if isinstance(result, Run):
            assert abs(result.totals["energy_residual"]) < ENERGY
            assert abs(result.totals["momentum_residual"]) < MOMENTUM


test_random_scenes_close = always(assert_closed, part_scenes(), few=50, many=5000)


@pytest.mark.parametrize("method", METHODS)
def test_block_carried_by_a_belt(method):
    """It sticks until the spring pulls as hard as friction, x = N / k: so far the belt has done N^2 / 2k, all
    of it stored; the belt's impulse is N^2 / (2 k belt), and all of it goes to the ground through the spring.
    """
    k, N, belt = 4.0, 1.0, 0.3
    totals = run(case(ON_A_BELT, method, t_end=f"{N / k / belt} s"), momentum=True).totals
    assert totals["work.friction.f"] == totals["work_belt"] == pytest.approx(N * N / (2 * k), rel=1e-14)
    assert totals["energy_end"] - totals["energy_start"] == pytest.approx(N * N / (2 * k), rel=1e-14)
    assert totals["loss_friction"] == pytest.approx(0, abs=1e-15)
    assert totals["impulse_belt"] == pytest.approx(N * N / (2 * k * belt), rel=1e-14)
    assert totals["impulse_ground"] == pytest.approx(-N * N / (2 * k * belt), rel=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_block_slipping_on_a_belt(method):
    """A free block on a belt: the belt pulls with N, does N belt t, and half of that heats."""
    m, N, belt = 2.0, 3.0, 0.5
    until = m * belt / N  # it has the speed of the belt
    text = f"""
bodies: {{m: {m} kg}}
friction: {{f: {{between: [m, ground], N: {N} N, mu: 1, belt: {belt} m/s}}}}
"""
    of = case(text, method, t_end=f"{2 * until} s")
    result = run(of, momentum=True).totals
    assert "work_belt" not in run(of).totals
    assert result["work_belt"] == pytest.approx(N * belt * until, rel=1e-14)
    assert result["loss_friction"] == pytest.approx(m * belt**2 / 2, rel=1e-14)
    assert result["energy_end"] == pytest.approx(m * belt**2 / 2, rel=1e-14)
    assert result["impulse_belt"] == pytest.approx(m * belt, rel=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_base_that_carries_a_stuck_block(method):
    """The base moves a block that sticks to it: work and impulse are what its motion needs."""
    m, a, frequency = 1.7, 0.01, 0.6
    omega, t = 2 * pi * frequency, 0.3
    text = f"""
bodies: {{m: {m} kg}}
friction: {{f: {{between: [m, base], N: 1 kN, mu: 1}}}}
base: {{a: {a} m, omega: {frequency} Hz}}
initial: {{m: {{v: {a * omega} m/s}}}}
"""
    totals = run(case(text, method, t_end=f"{t} s"), momentum=True).totals
    v = a * omega * np.cos(omega * t)
    assert totals["work_base"] == pytest.approx(m * (v**2 - (a * omega) ** 2) / 2, rel=1e-13)
    assert totals["impulse_base"] == pytest.approx(m * (v - a * omega), rel=1e-13)
    assert totals["loss_friction"] == totals["work_belt"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_base_that_rubs_on_a_stuck_block(method):
    """A block that the ground holds fast never follows the base, not even where that turns: each turn is a
    reversal of what rubs there, N |V| heats, 4 N a a period.
    """
    a, frequency, N = 0.01, 0.5, 1.0
    text = f"""
bodies: {{m: 1 kg}}
friction: {{held: {{between: [m, ground], N: 10 N, mu: 1}}, rubs: {{between: [m, base], N: {N} N, mu: 1}}}}
base: {{a: {a} m, omega: {frequency} Hz}}
"""
    result = run(case(text, method), momentum=True)
    turns = result.events["t"][result.events["kind"] == 3]
    assert turns == pytest.approx((np.arange(10) + 0.5) / (2 * frequency), rel=1e-14)
    assert result.totals["sticks"] == result.totals["uncertified"] == 0
    assert result.totals["loss.friction.rubs"] == pytest.approx(4 * N * a * frequency * 10, rel=1e-13)
    assert result.totals["work_base"] == pytest.approx(4 * N * a * frequency * 10, rel=1e-13)
    assert not result.samples["x_m"].any()


@pytest.mark.parametrize("method", METHODS)
def test_steady_work_of_a_force_and_of_a_base_is_what_the_damper_takes(method):
    """Over a period of a steady oscillation all that goes in is lost: pi c omega X^2 (Den Hartog 1956)."""
    m, k, c, F, omega = 1.0, 9.0, 0.4, 0.2, 2 * pi
    X = F / np.hypot(k - m * omega**2, c * omega)
    shift = -np.arctan2(c * omega, k - m * omega**2)
    text = f"""
bodies: {{m: {m} kg}}
links: {{l: {{between: [m, ground], k: {k} N/m%s}}}}
initial: {{m: {{x: {X * np.sin(shift)} m, v: {X * omega * np.cos(shift)} m/s}}}}
run: {{t_end: 1 s}}
"""
    push = f"forces: {{F: {{on: m, A: {F} N, omega: 1 Hz}}}}"
    forced = run(scene_of(text % f", c: {c} N s/m" + push, method=method), ledger=True)
    lost = pi * c * omega * X * X
    assert forced.totals["work.forces.F"] == pytest.approx(lost, rel=1e-13)
    assert forced.totals["loss.links.l"] == pytest.approx(lost, rel=1e-13)
    # the same mass on a spring to the ground, its damper to a base that moves as the force would ask
    damper = f"}}, d: {{between: [m, base], c: {c} N s/m"
    base = f"base: {{a: {F / (c * omega)} m, omega: 1 Hz, phase: -90 deg}}"
    totals = run(scene_of(text % damper + base, method=method), ledger=True).totals
    assert totals["work_base"] == pytest.approx(totals["loss.links.d"], rel=1e-12)
    assert totals["energy_residual_relative"] < 1e-15


@pytest.mark.parametrize("method", METHODS)
def test_decay_is_the_loss(method):
    """A mass on a damper alone: v = v0 exp(-c t / m)."""
    m, c, v, t = 1.5, 0.8, 0.4, 3.0
    text = f"""
bodies: {{m: {m} kg}}
links: {{d: {{between: [m, ground], c: {c} N s/m}}}}
initial: {{m: {{v: {v} m/s}}}}
"""
    totals = run(case(text, method, t_end=f"{t} s"), momentum=True).totals
    lost = m * v * v / 2 * (1 - exp(-2 * c * t / m))
    assert totals["loss_viscous"] == pytest.approx(lost, rel=1e-14)
    assert totals["impulse_ground"] == pytest.approx(-m * v * (1 - exp(-c * t / m)), rel=1e-14)


MOTOR_BESIDE_A_ROTOR = """
bodies: {a: 1 kg, b: 2 kg}
links: {spring: {between: [a, ground], k: 300 N/m, c: 1 N s/m}}
friction: {rub: {between: [a, b], N: 50 N, mu: 1}}
motor: {on: a, m3: 0.1 kg, e: 0.05 m, J: 1e-3 kg m^2, M0: 0.01 N m, Omega0: 30 rad/s}
rotors: {r: {on: b, m: 0.1 kg, e: 0.1 m, J: 1e-3 kg m^2}}
initial: {a: {x: 1 cm}, r: {phi: 1 rad, w: 25 rad/s}, motor: {phi: 0.4 rad, phidot: 20 rad/s}}
run: {t_end: 1 s, every: 20 ms}
"""


@pytest.mark.parametrize("N", ["1 N", "50 N"])
def test_a_motor_and_a_rotor_on_bodies_that_stick_to_each_other(N):
    totals = run(scene_of(MOTOR_BESIDE_A_ROTOR, {"friction.rub.N": N}), ledger=True).totals
    assert abs(totals["energy_residual_relative"]) < 1e-14
