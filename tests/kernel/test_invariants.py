"""What must not change a trajectory, and what must not change along one."""

import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.engine.runs import run
from tests.random_scenes import scenes
from tests.scenes import TABLE_1, motor, paper, scene
from vibsim.physics.numbers import TWO_PI, TWO_PI_LO, Doubles
from vibsim.physics.precision import number_kit


def test_a_motor_scene_may_start_at_any_time():
    """No time occurs in Eqs. (2.8)-(2.10): a run from the state at an event repeats what follows it."""
    original = paper("II-B", t_end=10.0)
    result = run(original)
    i = 40
    row = result.row(i)
    names = ("x1", "v1", "x2", "v2", "phidot")
    state = {name: float(row[name]) for name in names}
    shifted = run(replace(original, **state, phi=float(row["phase"]), t_end=4.0))
    assert row["kind"] in (1, 2, 3, 4, 5)
    # rounding says on which side of the event the state is: the event itself may follow its start at once
    first = int(np.searchsorted(shifted.events["t"], 1e-12))
    later, count = slice(first, first + 59), 60
    np.testing.assert_array_equal(shifted.events["kind"][later], result.events["kind"][i + 1 : i + count])
    # time is kept to eps of itself: 10 s of it against 4 s; states grow apart e-fold per second at most
    times = result.events["t"][i + 1 : i + count] - row["t"]
    np.testing.assert_allclose(shifted.events["t"][later], times, rtol=0, atol=1e-11)
    for name in names:
        gap = shifted.events[name][later] - result.events[name][i + 1 : i + count]
        assert np.max(np.abs(gap)) <= 1e-9 * np.max(np.abs(result.events[name]))


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_a_far_stop_is_no_stop(method):
    far = paper("I-B", G=10.0, t_end=20.0, method=method)
    without = replace(far, k2=None, G=None)
    one, other = run(far), run(without)
    assert one.totals["impacts"] == 0
    assert one.kinds == other.kinds
    for name in ("x1", "v1", "x2", "v2"):
        # the stop only adds step ends to look at; the closed form is anchored at events alone
        bound = 1e-13 * np.max(np.abs(other.samples[name]))
        np.testing.assert_allclose(one.samples[name], other.samples[name], rtol=0, atol=bound)
    assert 9.0 < one.totals["grazing_margin"] < 10.0


def energy(scene, state):
    """Kinetic energy and that of both springs [J]; the stop's spring is compressed by x2 - x1 - G."""
    y = state["x1"] - state["x2"]
    depth = np.maximum(-scene.stop_sign * y - scene.G, 0.0)
    kinetic = scene.m1 * state["v1"] ** 2 + scene.m2 * state["v2"] ** 2
    return (kinetic + scene.k1 * y**2 + scene.k2 * depth**2) / 2


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_energy_over_a_thousand_periods_with_impacts(method):
    free = scene(c=0.0, N=None, x1=0.02, v1=0.5, v2=-0.5 * 0.297 / 2.94, t_end=140.0, method=method)
    result = run(free)
    assert result.totals["impacts"] > 1000
    total = energy(free, result.samples)
    # some 3000 events, each rounding the state by a few eps at random: 3000^(1/2) x 10 eps = 6e-14
    np.testing.assert_allclose(total, total[0], rtol=1e-12)
    momentum = 0.297 * result.samples["v1"] + 2.94 * result.samples["v2"]
    np.testing.assert_allclose(momentum, 0.0, rtol=0, atol=1e-12 * 0.297 * 0.5)


def test_momentum_and_energy_of_a_free_rotor():
    """No torque (M0 / Omega0 -> 0), no friction, no stop: blocks and rotor keep momentum and energy."""
    source = {**motor(5.0), "M0": 1e-300, "phidot": 30.0}
    free = scene(source, c=0.0, N=None, k2=None, G=None, t_end=60.0)
    result = run(free)
    s = result.samples
    m3, e = 0.03, 0.11
    # mass m3 sits at x1 + e cos phi, y3 = e sin phi: the paper's coupling has m3 e (w' sin phi + w^2 cos phi)
    vx, vy = s["v1"] - e * s["phidot"] * np.sin(s["phi"]), e * s["phidot"] * np.cos(s["phi"])
    momentum = 0.297 * s["v1"] + 2.94 * s["v2"] + m3 * vx
    kinetic = 0.297 * s["v1"] ** 2 + 2.94 * s["v2"] ** 2 + m3 * (vx**2 + vy**2) + 0.001 * s["phidot"] ** 2
    total = kinetic + 200.0 * (s["x1"] - s["x2"]) ** 2
    # 60 s are some 5000 steps of eps each, at random
    np.testing.assert_allclose(momentum, momentum[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(total, total[0], rtol=1e-12)
    assert np.ptp(s["phidot"]) > 1.0  # the rotor feels the blocks


# Any scene runs to its end; mirrored, it gives the mirrored trajectory, bit for bit. `vibsim verify` does so
# with the cases.


ODD = ("x1", "v1", "x2", "v2", "friction")  # change sign; all else stays: time, phi, phidot, contact, kinds


def assert_mirror_image(scene):
    """Of the scene seen in a mirror: signs of state and of A, F0 or e, and the stop on the other side."""
    names = ("A", "F0", "e", "x1", "v1", "x2", "v2")
    flipped = {name: -getattr(scene, name) for name in names if getattr(scene, name) is not None}
    one, other = run(scene), run(replace(scene, stop_sign=-scene.stop_sign, **flipped))
    assert one.events["t"][-1] == scene.t_end and np.all(np.diff(one.events["t"]) >= 0)
    assert len(one.samples["time"]) == scene.sample_count
    for table, image in ((one.samples, other.samples), (one.events, other.events)):
        for name, column in table.items():
            # without friction the flag means nothing and is absent; -0.0 == 0.0 holds
            np.testing.assert_array_equal(-image[name] if name in ODD else image[name], column, err_msg=name)
    assert one.totals == pytest.approx(other.totals, rel=0, abs=0, nan_ok=True)


@settings(max_examples=250)
@given(scenes(features=False), st.sampled_from(("auto", "taylor")))
def test_random_scenes_mirrored(scene, method):
    assert_mirror_image(replace(scene, method=method))


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
@pytest.mark.parametrize("name", TABLE_1)
def test_printed_cases_of_ideal_sources_are_certified_to_their_end(name, method):
    assert run(paper(name, t_end=300.0, method=method)).totals["uncertified"] == 0


# Phases keep full accuracy at any time: against exact rational arithmetic and mpmath.


EPS = 2.0**-53
frequencies = st.floats(1e-3, 1e3)
times = st.one_of(st.floats(1e-3, 1e3), st.floats(1e6, 1e9))


def exact_turns(cycles, cycles_lo, t):
    """(cycles + cycles_lo) t less the nearest whole turn, exactly."""
    turns = (Fraction(cycles) + Fraction(cycles_lo)) * Fraction(t)
    return turns - math.floor(turns + Fraction(1, 2))


def distance(turns, other):
    """Distance of two angles, in turns, on the circle."""
    gap = abs(turns - other)
    return min(gap, 1 - gap)


@given(frequencies, times, st.floats(-0.5, 0.5))
def test_turn_angle(cycles, t, share):
    cycles_lo = share * math.ulp(cycles)
    angle = Doubles.turn_angle(cycles, cycles_lo, t)
    exact = exact_turns(cycles, cycles_lo, t)
    assert abs(angle) <= math.pi * (1 + 4 * EPS)
    with mpmath.workdps(40):
        got = Fraction(*mpmath_ratio(mpmath.mpf(angle) / (2 * mpmath.pi)))
    # rounding of the sum of parts up to 1/2 turn, of cycles_lo t (eps of half an ulp of it) and of 2 pi
    small = Fraction(EPS) ** 2 * Fraction(cycles) * Fraction(t)
    assert (
        distance(got, exact)
        <= 2 * Fraction(EPS) * abs(exact) + Fraction(EPS) * Fraction(1, 2**20) + 4 * small
    )


def mpmath_ratio(value):
    numerator = int(mpmath.floor(value * mpmath.mpf(2) ** 120))
    return numerator, 2**120


@given(st.one_of(st.floats(-10, 10), st.floats(-1e4, 1e4)))
def test_reduce_angle(angle):
    reduced, turns = Doubles.reduce_angle(angle)
    assert turns == math.floor(turns)
    assert abs(reduced) <= math.pi * (1 + 4 * EPS) + 4 * EPS * abs(angle)
    with mpmath.workdps(40):
        exact = mpmath.mpf(angle) - 2 * mpmath.pi * turns
        # turns x TWO_PI is rounded: up to eps of the angle; exact for the |turns| <= 1 of a step
        allowed = 2 * EPS * abs(reduced) + EPS * abs(angle) * (abs(turns) > 1)
        assert abs(reduced - exact) <= allowed


def test_two_pi_in_two_parts():
    with mpmath.workdps(40):
        assert abs(mpmath.mpf(TWO_PI) + mpmath.mpf(TWO_PI_LO) - 2 * mpmath.pi) < 1e-31


@given(st.integers(-1000, 1000), st.floats(-3.14, 3.14))
def test_unwind_undoes_reduce(turns, phase):
    assert Doubles.unwind(phase, float(turns)) == pytest.approx(phase + 2 * math.pi * turns, rel=2 * EPS)


@pytest.mark.parametrize("halves", (1, 3, 1001))
@pytest.mark.parametrize("digits", (30, 40, 60))
def test_angles_of_many_digits_at_half_turns(digits, halves):
    """The middle of 0.5 turns and its rounding lie on both sides of where whole turns begin to count up."""
    kit = number_kit(digits)
    cycles = kit.number(Fraction(212, 100))
    exact = kit.number(Fraction(halves, 2)) / cycles
    for t in (exact, kit.next_after(exact, math.inf), exact * (1 - kit.eps)):
        angle = kit.turn_angle(cycles, kit.number(0), t)
        assert abs(kit.cos(angle) + 1) < 1e-25
        phase, turns = kit.reduce_angle(kit.pi * 2 * cycles * t)
        assert abs(kit.cos(phase) + 1) < 1e-25 and abs(turns - halves / 2) <= 0.5
