"""Extremes that the engine keeps as it runs: against closed forms and fine samples."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.random_parts import part_scenes
from tests.engine.runs import scene_of
from tests.scenes import fixed_block, harmonic, motor
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import GROUND

RARELY = {"every_num": 10**6, "every_den": 1}  # no samples


def run(scene, ends, since=0.0):
    """Extremes by period (2 * pairs, periods), those of all, and the section's times."""
    scene = replace(scene, **RARELY)
    trajectory = open_trajectory(scene, section=True, extremes=(ends, since))
    blocks = list(trajectory.blocks())
    rows = np.concatenate([block.extremes for block in blocks], axis=1)
    return rows, trajectory.extremes, np.concatenate([block.section["time"] for block in blocks])


# A mass of 1 kg on a spring of 4 pi^2 N/m: 1 Hz.
FREE = """
bodies: {a: 1 kg}
links: {s: {between: [a, ground], k: 39.47841760435743 N/m}}
initial: {a: {x: 1 mm}}
run: {t_end: 10 s}
"""
PUSHED = """
bodies: {a: 1 kg}
forces: {f: {on: a, A: 1 N, omega: 1 Hz}}
run: {t_end: 1 s, every: 1 us}
"""


@pytest.mark.parametrize("method", ["auto", "taylor"])
def test_the_amplitude_of_a_free_vibration_is_exact_to_rounding(method):
    scene = scene_of(FREE, {"a.v": 2 * math.pi * 0.002}, method=method)
    _, (least, greatest, _), _ = run(scene, [(0, GROUND)], 1.234)
    amplitude = math.hypot(0.001, 0.002)
    assert greatest == pytest.approx([amplitude], rel=4e-15)
    assert least == pytest.approx([-amplitude], rel=4e-15)


def test_each_period_has_its_own():
    """A force that moves a heavy mass steadily on: x = v t + ripple; every period begins where one ended."""
    scene = scene_of(PUSHED, {"bodies.a": 1000, "a.v": 0.5}, t_end=6.5, every=1)
    rows, (least, greatest, _), times = run(scene, [(0, GROUND)], 2.5)
    assert times.tolist() == [1, 2, 3, 4, 5, 6]
    mean = 0.5 + 1 / (1e3 * 2 * math.pi)  # x = mean t - sin(2 pi t) / (1000 (2 pi)^2), ascending
    assert rows[:, :2].tolist() == [[math.inf] * 2, [-math.inf] * 2]
    np.testing.assert_allclose(rows[0, 3:], mean * np.array([3, 4, 5]), rtol=1e-15)
    np.testing.assert_allclose(rows[1, 2:], mean * np.array([3, 4, 5, 6]), rtol=1e-15)
    assert (least[0], greatest[0]) == (rows[0, 2], pytest.approx(6.5 * mean, rel=1e-6))


def test_what_turns_twice_between_two_nodes_is_found():
    """A drift slower than the ripple on it turns twice a period, however short the way back."""
    ripple = 1 / (2 * math.pi)  # of the velocity, F / (m w)
    for excess in (1e-2, 1e-4, 1e-6):
        speed = ripple * (1 - excess)
        scene = scene_of(PUSHED, {"a.v": speed, "f.phase": "90 deg"})
        x = np.concatenate([block.samples["x_a"] for block in open_trajectory(scene).blocks()])
        _, (least, greatest, _), _ = run(scene, [(0, GROUND)])
        turn = math.asin(-speed / ripple)  # v = speed + ripple sin(2 pi t) = 0
        assert least[0] <= x.min() and greatest[0] >= x.max()
        if excess == 1e-2:
            places = [(math.pi - turn) / (2 * math.pi), (2 * math.pi + turn) / (2 * math.pi)]
            values = [speed * t + ripple * (1 - math.cos(2 * math.pi * t)) / (2 * math.pi) for t in places]
            assert max(values) <= greatest[0] * (1 + 1e-12)


@pytest.mark.parametrize("acts", ["extension", "compression"])
def test_the_smallest_gap_is_kept_of_open_stops_alone(acts):
    stop = f"between: [a, ground], acts: {acts}, k: 1e5 N/m"
    text = f"{FREE}stops: {{near: {{{stop}, gap: 1.1 mm}}, far: {{{stop}, gap: 4 mm}}}}"
    _, (_, _, margins), _ = run(scene_of(text), [(0, GROUND)])
    assert margins == pytest.approx([0.0001, 0.003], rel=1e-12)
    _, (_, _, margins), _ = run(scene_of(text, {"a.x": 0.002}, t_end=3), [(0, GROUND)])
    assert margins[0] == math.inf and 0.00199 < margins[1] < 0.003


def test_the_speed_of_a_motor_is_followed():
    """A rotor of no unbalance on a fixed mass runs up: w = Omega0 (1 - exp(-t / T)), greatest at the end."""
    scene = fixed_block(motor(5.5) | {"m3": 1e-12}, m1=1e9, k1=0.0, c=0.0, t_end=2.0).as_parts()
    _, (least, greatest, _), _ = run(scene, [(0, GROUND)], 1.0)
    constant = scene.motor.Omega0 * scene.motor.J / scene.motor.M0
    for value, t in ((least[-1], 1.0), (greatest[-1], 2.0)):
        assert value == pytest.approx(scene.motor.Omega0 * -math.expm1(-t / constant), rel=1e-9)


def test_a_driven_oscillator_has_its_amplitude_in_every_period():
    driven = fixed_block(harmonic(4.0, 0.1), c=1.0, t_end=30.0).as_parts()
    rows, _, times = run(driven, [(0, GROUND)], 20.0)
    w = 2 * math.pi * 4.0
    amplitude = 0.1 / math.hypot(driven.links[0].k - driven.bodies[0].m * w * w, w)
    np.testing.assert_allclose(rows[1, times > 20.25], amplitude, rtol=1e-13)
    np.testing.assert_allclose(rows[0, times > 20.25], -amplitude, rtol=1e-13)


@settings(max_examples=25, deadline=None)
@given(part_scenes())
def test_random_scenes(scene):
    """Samples stay within, and miss an extreme by a step at most."""
    ends = [(i, GROUND) for i in range(len(scene.bodies))]
    ends += [(stop.P, stop.Q) for stop in scene.stops if GROUND not in (stop.P, stop.Q)]
    since = scene.t_end / 3
    _, (least, greatest, _), _ = run(scene, ends, since)
    fine = replace(scene, every_num=1, every_den=math.ceil(20_000 / scene.t_end))
    blocks = list(open_trajectory(fine).blocks())
    time = np.concatenate([block.samples["time"] for block in blocks])
    for i, body in enumerate(scene.bodies):
        separator = "" if body.name.isdigit() else "_"
        x, v = (
            np.concatenate([b.samples[f"{s}{separator}{body.name}"] for b in blocks])[time >= since]
            for s in "xv"
        )
        missed = np.abs(v).max() / fine.every_den + 1e-15  # where it begins or ends between two samples
        assert least[i] <= x.min() <= least[i] + missed
        assert greatest[i] - missed <= x.max() <= greatest[i]


def test_a_long_run_without_events_can_be_left():
    """A call of C works out no more than a slice of the nodes: 3e4 vibrations come in many blocks."""
    scene = scene_of(FREE, t_end=3e4, every=1e4)
    trajectory = open_trajectory(scene, section=True, extremes=([(0, GROUND)], 0.0))
    assert sum(1 for _ in trajectory.blocks()) > 4
    assert trajectory.extremes[1] == pytest.approx([0.001], rel=4e-15)


def test_a_turn_near_a_point_of_inflection_is_found():
    """A drift against a ripple turns just before its velocity is least, where the curve bends both ways."""
    ripple = 1 / (2 * math.pi)  # of the velocity, F / (m w)
    draw = random.Random(3)
    for _ in range(100):
        speed, length = ripple * draw.uniform(0.8, 0.999), draw.uniform(0.7, 0.9)
        scene = scene_of(PUSHED, {"a.v": speed, "f.phase": "90 deg"}, t_end=length, every=1)
        _, (_, greatest, _), _ = run(scene, [(0, GROUND)])
        turn = 0.5 + math.asin(speed / ripple) / (2 * math.pi)
        turns = [t for t in (turn, length) if t <= length]
        x = [speed * t + ripple * (1 - math.cos(2 * math.pi * t)) / (2 * math.pi) for t in turns]
        assert greatest[0] == pytest.approx(max(x), rel=1e-14)
