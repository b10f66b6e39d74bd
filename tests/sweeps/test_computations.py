"""What is computed on demand, against closed forms, ledgers of whole runs, and stored events."""

import math
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from tests.engine.runs import opened
from tests.scenes import fixed_block, harmonic, motor, paper, scene
from tests.sweeps.made import OMEGA0, assert_same_points, short_case, short_plan, swept
from vibsim.analysis.cycles import parse_discard
from vibsim.cases.case import load_case_text
from vibsim.engine.trajectory import Trajectory, open_trajectory
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results.simulation import open_result
from vibsim.sweeps import points
from vibsim.sweeps.computations import COMPUTATIONS, read_computations
from vibsim.sweeps.contact_computations import QUANTILES
from vibsim.sweeps.points import Measurement
from vibsim.sweeps.quantities import of_two_blocks
from vibsim.sweeps.statistics import GivenUpError, MeasuredRun, Statistics, sampled_for_statistics
from vibsim.sweeps.sweep_plan import PlanError, PointSettings


def computed(scene, *names, discard="50 %", section=10):
    """Values and arrays of one run by name."""
    settings = PointSettings(None, False, parse_discard(discard), section, None, names)
    parts = scene.as_parts()
    vars(settings)["of"] = of_two_blocks(parts)
    return Measurement(sampled_for_statistics(parts), settings, None).values()


def contact_begins(scene, begin):
    """Rows of the events table of the whole run, those that begin a contact from `begin` on."""
    blocks = list(opened(sampled_for_statistics(scene.as_parts()), section=True).blocks())
    events = {name: np.concatenate([block.events[name] for block in blocks]) for name in blocks[0].events}
    marks = np.concatenate([block.section["time"] for block in blocks])
    chosen = (events["kind"] == EVENT_KINDS["contact_begin"]) & (events["t"] >= begin)
    return {name: column[chosen] for name, column in events.items()}, marks[marks >= begin]


def linear(hertz=4.0, t_end=40.0, **changes):
    """Block 1 alone under 0.1 N, damped by 1 N s/m, and its response A / (k1 - m1 w^2 + i c w) [m]."""
    driven, w = fixed_block(harmonic(hertz, 0.1), c=1.0, t_end=t_end, **changes), 2 * math.pi * hertz
    return driven, 0.1 / (driven.k1 - driven.m1 * w * w + 1j * w)


def test_power_of_a_driven_linear_oscillator():
    """Mean power c (w X)^2 / 2 in the damper; nothing stored per period."""
    driven, response = linear(t_end=40.1)  # ends within a period
    values, _ = computed(driven, "power")
    expected = (2 * math.pi * 4.0 * abs(response)) ** 2 / 2
    # the transient has died to exp(-20 c / 2 m1) = 2e-15; sums of 1 J are kept to 1e-15, over 20 s
    assert values["power_source"] == pytest.approx(expected, rel=1e-12)
    assert values["power_damper"] == pytest.approx(expected, rel=1e-12)
    assert values["power_friction"] == 0.0
    assert values["power_stored"] == pytest.approx(0.0, abs=1e-13 * expected)


@pytest.mark.parametrize("name", ["I-A", "I-B", "I-C-eq211", "II-A", "II-B"])
def test_power_is_balanced_and_that_of_the_whole_run_in_between(name):
    """First law over the window; and the ledgers of two whole runs up to its ends differ by the same work."""
    scene = paper(name, t_end=24.0)
    values, _ = computed(scene, "power")
    lost = values["power_damper"] + values["power_friction"] + values["power_stored"]
    assert values["power_source"] == pytest.approx(lost, rel=1e-11, abs=1e-14)
    _, marks = contact_begins(scene, 12.0)
    work = []
    for t_end in (float(marks[0]), float(marks[-1])):
        trajectory = opened(paper(name, t_end=t_end), ledger=True)
        list(trajectory.blocks())
        work.append(trajectory.totals["work_source"])
    span = marks[-1] - marks[0]
    assert values["power_source"] * span == pytest.approx(work[1] - work[0], rel=1e-9)


def test_a_free_motor_takes_no_power_at_its_no_load_speed():
    """V9: M0 (1 - w/Omega0) w with w = Omega0 (1 - exp(-t/T)); over [t1, t2] its integral is elementary."""
    heavy = fixed_block(motor(5.5), m1=1e9, k1=0.0, c=0.0, t_end=60.0)
    constant = heavy.Omega0 * (heavy.J + heavy.m3 * heavy.e**2) / heavy.M0
    values, _ = computed(heavy, "power")
    _, marks = contact_begins(fixed_block(motor(5.5), m1=1e9, k1=0.0, c=0.0, k2=1.0, G=1.0, t_end=60.0), 30.0)
    first, last = float(marks[0]), float(marks[-1])

    def work(t):
        """Integral of M0 Omega0 (E - E^2) with E = exp(-t/T)."""
        share = math.exp(-t / constant)
        return heavy.M0 * heavy.Omega0 * constant * (share**2 / 2 - share)

    expected = (work(last) - work(first)) / (last - first)
    assert values["power_source"] == pytest.approx(expected, rel=1e-7)  # m1 = 1e9 kg moves by 1e-10
    assert values["power_damper"] == 0.0


@pytest.mark.parametrize("name", ["I-B", "II-B"])
def test_the_spectrum_of_impact_velocities(name):
    scene = paper(name, t_end=24.12 if name == "I-B" else 24.03)
    values, arrays = computed(scene, "impact-velocity")
    rows, marks = contact_begins(scene, scene.t_end / 2)
    inside = (rows["t"] >= marks[0]) & (rows["t"] < marks[-1])
    speeds = sorted(abs(a - b) for a, b in zip(rows["v1"][inside], rows["v2"][inside], strict=True))
    assert len(speeds) > 40 and not inside[-1]  # one follows on the last period
    assert values["impact_velocity_mean"] == pytest.approx(math.fsum(speeds) / len(speeds), rel=1e-14)
    spectrum = arrays["impact_velocity"]
    assert (spectrum[0], spectrum[-1]) == (speeds[0], speeds[-1]) and len(spectrum) == len(QUANTILES)
    for q, value in zip(QUANTILES, spectrum, strict=True):  # linear between neighbours in rank
        place = q * (len(speeds) - 1)
        low, high = speeds[math.floor(place)], speeds[math.ceil(place)]
        assert value == pytest.approx(low + (place - math.floor(place)) * (high - low), rel=1e-12)


@pytest.mark.parametrize("name", ["I-B", "II-B"])
def test_the_section_at_contact(name):
    scene = paper(name, t_end=24.0)
    _, arrays = computed(scene, "contact-section", section=10)
    rows, _ = contact_begins(scene, 12.0)
    assert arrays["contact_velocity"].tolist() == (rows["v1"] - rows["v2"])[-10:].tolist()
    assert max(arrays["contact_velocity"]) < 0  # they approach each other
    if name == "II-B":
        phase = 2 * np.pi * arrays["contact_phase"]
        np.testing.assert_allclose(np.sin(phase), np.sin(rows["phi"][-10:]), atol=1e-12)
        np.testing.assert_allclose(arrays["contact_speed"], rows["phidot"][-10:] / (2 * np.pi), rtol=1e-15)
    else:
        np.testing.assert_allclose(arrays["contact_phase"], (rows["t"][-10:] * 5.5) % 1, atol=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_the_grazing_margin_of_a_steady_motion(side):
    """V5: without contact the gap that is left is G less the amplitude, on either side."""
    driven, response = linear(k2=12400.0, G=0.01, stop_sign=side)
    values, _ = computed(driven, "grazing")
    assert values["impacts"] == 0
    left = pytest.approx(0.01 - abs(response), abs=1e-12 * abs(response))
    assert values["grazing_margin_late"] == left


@pytest.mark.parametrize("name", ["I-A", "I-C-eq211", "II-B"])
def test_the_grazing_margin_is_the_engines_where_that_is_late(name):
    scene = paper(name, t_end=24.0)
    for begin in ("12 s", "1 s", "0 s"):
        margin = computed(scene, "grazing", discard=begin)[0].get("grazing_margin_late", math.inf)
        trajectory = opened(sampled_for_statistics(scene.as_parts()))
        list(trajectory.blocks())
        totals = trajectory.totals
        assert margin > totals["grazing_margin"] - 1e-15
        if totals["grazing_time"] > float(begin.split()[0]):
            assert margin == pytest.approx(totals["grazing_margin"], abs=1e-15)


def test_the_certificate_counts_uncertified_searches(monkeypatch):
    totals = Trajectory.totals.fget
    assert computed(paper("II-B", t_end=4.0), "certificate")[0]["uncertified"] == 0
    doubtful = property(lambda run: totals(run) | {"uncertified": 2})
    monkeypatch.setattr(Trajectory, "totals", doubtful)
    assert computed(paper("II-B", t_end=4.0), "certificate")[0]["uncertified"] == 2


def test_names():
    motor, harmonic_force = (of_two_blocks(paper(name).as_parts()) for name in ("II-B", "I-B"))
    assert read_computations(["grazing", "power", "power"], motor) == ("power", "grazing")
    with_a_motor = [name for name in COMPUTATIONS if name != "end-state"]
    assert read_computations(["all"], motor) == tuple(with_a_motor)
    assert set(read_computations(["all"], harmonic_force)) == set(with_a_motor) - {"capture"}
    with pytest.raises(ValueError, match=r"'powr' \(did you mean power\?\); allowed: power, impact-velocity"):
        read_computations(["powr"], motor)
    bare = load_case_text("blocks: {m1: 1 kg, m2: fixed}\ncoupling: {k1: 9 N/m}", name="bare")
    with pytest.raises(PlanError, match="impact-velocity is for cases with a stop; bare is another kind of"):
        short_plan({"k1": "1, 2"}, bare, compute=["impact-velocity"])


def test_computed_columns_on_file_are_the_same_bits_for_any_number_of_jobs(tmp_path):
    plan = short_plan({OMEGA0: "3:5:1 Hz"}, short_case(t_end="8 s"), compute=["all"], section=6)
    one, two = swept(plan, jobs=1), swept(plan, tmp_path / "s.h5")
    assert_same_points(two.table, one.table)
    read = open_result(tmp_path / "s.h5")
    assert_same_points(read.table, one.table)
    assert read["impact_velocity"].shape == (3, 1, len(QUANTILES))
    assert read["contact_phase"].shape == (3, 1, 6)
    assert np.isfinite(read["power_source"]).all()
    assert set(read.plan.compute) == set(COMPUTATIONS) - {"end-state"}  # the source decides
    assert read.column("power_source").units == "W"


def test_the_orbit_that_a_run_goes_to():
    """Its multipliers in 16 digits: tests/orbits/truths.json; of a linear oscillator exp(-c T / 2 m)."""
    values, arrays = computed(paper("I-A", t_end=120.0), "orbit", "regime")
    assert (values["orbit_periods"], values["regime_period"]) == (5, 5)
    exact = [-0.1014027795150739557 - 0.7926851667393456842j, -0.1014027795150739557 + 0.7926851667393456842j]
    found = arrays["multiplier_real"] + 1j * arrays["multiplier_imaginary"]
    np.testing.assert_allclose(found, [*exact, 0.0], rtol=0, atol=1e-12)
    assert values["orbit_exponent"] == pytest.approx(math.log(abs(exact[0])) * 3.5 / 5, rel=1e-11)
    chaotic, none = computed(paper("II-B", t_end=40.0), "orbit")
    assert "orbit_periods" not in chaotic and np.isnan(none["multiplier_real"]).all()


# The numbers per point, against linear theory, and what must be there exactly.


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
    """V4: that of the response, after a transient of exp(-c t / 2 m1) < 1e-14."""
    driven, response = linear(frequency)
    statistics, run = measured(driven, 20.0)
    values, amplitude = statistics.values(run), abs(response)
    # what is left of the transient is 1e-14 of the amplitude, the rounding of the flow a few 1e-16
    assert values["amplitude_x1"] == pytest.approx(amplitude, rel=1e-12)
    assert values["amplitude_x1_max"] == pytest.approx(amplitude, rel=1e-12)
    assert values["relative_max"] == pytest.approx(amplitude, rel=1e-12)
    assert values["relative_min"] == pytest.approx(-amplitude, rel=1e-12)
    assert values["periods"] == math.floor(40.0 * frequency) - math.ceil(20.0 * frequency)
    assert "drift_rate" not in values and "mean_speed" not in values


def test_section_of_a_driven_linear_oscillator():
    """At t = k/f: x = Im(R), v = w Re(R) with the response R."""
    driven, response = linear()
    statistics, _ = measured(driven, 20.0)
    x, v = (statistics.section(100)[f"section_{name}"] for name in ("displacement", "velocity"))
    assert np.isnan(x[:19]).all() and not np.isnan(x[19:]).any()
    np.testing.assert_allclose(x[19:], response.imag, rtol=1e-11)
    np.testing.assert_allclose(v[19:], 2 * math.pi * 4.0 * response.real, rtol=1e-9)


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
    runs = [measured(paper("II-B", t_end=20.0), 10.0, every=every) for every in (None, Fraction(1, 2000))]
    coarse, fine = (statistics.values(run) for statistics, run in runs)
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
