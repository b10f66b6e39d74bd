"""The numbers per point, against linear theory, and what must be there exactly."""

import math
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from tests.scenes import fixed_block, harmonic, motor, paper, scene
from tests.sweeps.made import short_plan
from vibsim.engine.trajectory import open_trajectory
from vibsim.sweeps import points
from vibsim.sweeps.quantities import of_two_blocks
from vibsim.sweeps.statistics import GivenUpError, MeasuredRun, Statistics, sampled_for_statistics


def measured(scene, begin, every=None):
    """Statistics of a run of two blocks as a sweep takes them."""
    scene = sampled_for_statistics(scene.as_parts(), every)
    of = of_two_blocks(scene)
    run, statistics = MeasuredRun(scene, of, begin), Statistics(scene, of, begin)
    for block in run.blocks():
        statistics.update(block)
    return statistics, run


@pytest.mark.parametrize("frequency", [1.0, 4.0, 7.3])
def test_amplitude_of_a_driven_linear_oscillator(frequency):
    """V4: A / sqrt((k1 - m1 w^2)^2 + (c w)^2), after a transient of exp(-c t / 2 m1) < 1e-14."""
    c, w, t_end = 1.0, 2 * math.pi * frequency, 40.0
    driven = fixed_block(harmonic(frequency, 0.1), c=c, t_end=t_end)
    statistics, run = measured(driven, 20.0)
    values = statistics.values(run)
    amplitude = 0.1 / math.hypot(driven.k1 - driven.m1 * w * w, c * w)
    # what is left of the transient is 1e-14 of the amplitude, the rounding of the flow a few 1e-16
    assert values["amplitude_x1"] == pytest.approx(amplitude, rel=1e-12)
    assert values["amplitude_x1_max"] == pytest.approx(amplitude, rel=1e-12)
    assert values["relative_max"] == pytest.approx(amplitude, rel=1e-12)
    assert values["relative_min"] == pytest.approx(-amplitude, rel=1e-12)
    assert values["periods"] == math.floor(t_end * frequency) - math.ceil(20.0 * frequency)
    assert "drift_rate" not in values and "mean_speed" not in values


def test_section_of_a_driven_linear_oscillator():
    """At t = k/f: x = A Im(H), v = A w Re(H) with H = 1 / (k1 - m1 w^2 + i c w)."""
    c, w = 1.0, 2 * math.pi * 4.0
    driven = fixed_block(harmonic(4.0, 0.1), c=c, t_end=40.0)
    statistics, _ = measured(driven, 20.0)
    response = 0.1 / (driven.k1 - driven.m1 * w * w + 1j * c * w)
    x, v = (statistics.section(100)[f"section_{name}"] for name in ("displacement", "velocity"))
    assert np.isnan(x[:19]).all() and not np.isnan(x[19:]).any()
    np.testing.assert_allclose(x[19:], response.imag, rtol=1e-11)
    np.testing.assert_allclose(v[19:], w * response.real, rtol=1e-9)


def test_free_vibration_has_no_periods_but_an_amplitude():
    """Block 1 released from x1 = 2 mm on an undamped spring: amplitude 2 mm over the whole time."""
    free = fixed_block(c=0.0, x1=0.002, t_end=10.0)
    statistics, run = measured(free, 5.0)
    values = statistics.values(run)
    assert values["amplitude_x1"] == pytest.approx(0.002, rel=1e-12)
    assert values["periods"] == 0
    assert math.isnan(values["impacts_per_period"]) and math.isnan(values["sticks_per_period"])


def test_free_flight_drifts_at_the_speed_of_the_centre_of_mass():
    """No friction, no source, both blocks at 0.25 m/s: they fly on, nothing vibrates."""
    flying = scene(N=None, k2=None, v1=0.25, v2=0.25, t_end=8.0)
    statistics, run = measured(flying, 2.0)
    values = statistics.values(run)
    assert values["drift_rate"] == pytest.approx(0.25, rel=1e-13)
    assert values["amplitude_relative"] == pytest.approx(0.0, abs=1e-15)


def test_extremes_do_not_depend_on_the_sampling():
    """They are those of the motion, not of samples."""
    case = paper("II-B", t_end=20.0)
    coarse, fine = (
        statistics.values(run)
        for statistics, run in (measured(case, 10.0, every=every) for every in (None, Fraction(1, 2000)))
    )
    assert coarse == fine


def test_transient_apart_changes_no_number():
    """The part after the transient, resumed from an event, is that of the uninterrupted run, bit for bit."""
    case = paper("II-C", t_end=30.0)
    apart, run = measured(case, 15.0)
    of, scene = of_two_blocks(case.as_parts()), sampled_for_statistics(case.as_parts())
    whole, ends = Statistics(scene, of, 15.0), [(motion.P, motion.Q) for motion in of.motions]
    trajectory = open_trajectory(scene, section=True, extremes=(ends, 15.0))
    for block in trajectory.blocks():
        whole.update(block)
    whole_run = SimpleNamespace(late=trajectory.totals, extremes=trajectory.extremes, t_reached=30.0)
    assert apart.values(run) == whole.values(whole_run)
    np.testing.assert_equal(apart.section(50), whole.section(50))
    assert {name: trajectory.totals[name] for name in run.totals} == run.totals


def test_motor_in_empty_space_runs_up_to_its_no_load_speed():
    """V9, heavy block: w = Omega0 (1 - exp(-t/T)); the mean late is Omega0."""
    heavy = fixed_block(motor(5.5), m1=1e9, k1=0.0, c=0.0, t_end=500.0)
    constant = heavy.Omega0 * (heavy.J + heavy.m3 * heavy.e**2) / heavy.M0
    statistics, run = measured(heavy, 450.0)
    values = statistics.values(run)
    left = math.exp(-450.0 / constant)
    assert values["mean_speed"] == pytest.approx(5.5, rel=1e-9 + left)
    assert values["max_speed"] == pytest.approx(5.5, rel=1e-9 + left)
    assert values["min_speed"] == pytest.approx(5.5 * (1 - left), rel=1e-7)


def test_run_that_stops_before_the_transient_ends_has_totals_only():
    stopped = replace(paper("II-B", t_end=20.0), rest_distance=0.002, stop_on_violation=True)
    statistics, run = measured(stopped, 10.0)
    assert statistics.values(run) == {} and run.t_reached < 10.0
    assert run.totals["events"] > 0


def test_run_is_given_up_when_nobody_wants_it():
    scene = sampled_for_statistics(paper("II-B").as_parts())
    run = MeasuredRun(scene, of_two_blocks(scene), 100.0, lambda: False)
    with pytest.raises(GivenUpError):
        list(run.blocks())


def test_what_is_not_known_of_a_table_is_nan_in_every_piece(monkeypatch):
    monkeypatch.setattr(points, "PIECE", 7)
    plan = short_plan(section=5)
    assert all(np.isnan(column).all() for column in points.Table(plan).numbers.values())
