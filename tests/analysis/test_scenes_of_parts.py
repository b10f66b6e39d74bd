"""Verdicts on scenes of named parts, with rigid stops, rotors and states too, against published numbers and
what mechanics tells.
"""

import json
from dataclasses import asdict
from decimal import Decimal, localcontext
from functools import cache
from json import dumps

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from tests.engine.test_impact_disturbances import THROWN
from tests.formula_cases import CURRENT, DRIVE, MACHINE, case_of
from vibsim import simulate
from vibsim.analysis import analyse, compare, count_impacts, find_frequencies, judge_regime, measure_drift
from vibsim.analysis.capture import resonances
from vibsim.analysis.comparison import block_values, unit_of
from vibsim.analysis.cycles import Span, cycle_ends
from vibsim.analysis.drift import displacement, drifting
from vibsim.analysis.sections import SectionCoordinates, section_of
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.physics.parts import EVENT_KINDS
from vibsim.plots.poincare_sections import turn_times

# a driven body with a motor beside it that turns against a spring, on a shaken base: three frequencies
SHAKEN = """
name: shaken
bodies: {cart: 2 kg, rider: 1 kg}
links:
  spring: {between: [cart, base], k: 500 N/m, c: 2 N s/m}
  tie: {between: [rider, cart], k: 200 N/m, c: 1 N s/m}
forces:
  push: {on: rider, A: 1 N, omega: 3 Hz}
base: {a: 1 mm, omega: 2 Hz}
run: {t_end: 200 s, every: 10 ms}
"""


@cache
def gallery(name, t_end):
    return vibsim.simulate(load_case(f"gallery/{name}", {"run.t_end": t_end}))


def test_the_published_orbit_of_the_bilinear_oscillator():
    """PWSDDE-cont: one impact in two periods, met with 1.073267857664968 m/s."""
    period = 2 * np.pi / 0.8
    window = 190 * period - 1e-6, 254 * period + 1e-6
    found = analyse(gallery("bilinear-oscillator", "2000 s"), window=window, exponent=False)
    assert (found.regime.verdict, found.regime.period, found.regime.word_period) == ("periodic", 2, 2)
    assert (found.impacts.impacts, found.impacts.impact_counts.keys()) == (0.5, {0, 1})
    assert found.impacts.velocity.mean == pytest.approx(1.073267857664968, rel=1e-7)
    orders = [line.hz * period for line in found.frequencies.lines[:3]]
    assert orders == pytest.approx([1, 1.5, 0.5], rel=1e-3)
    assert found.drift is None  # held by its spring
    assert found.capture is None


def test_a_symmetric_orbit_has_odd_harmonics_only():
    """Den Hartog's friction oscillator: x(t + T/2) = -x(t)."""
    run = gallery("friction-oscillator", "1000 s")
    assert judge_regime(run).period == 1
    lines = find_frequencies(run).lines
    assert {line.order or round(line.hz / (0.9 / (2 * np.pi))) for line in lines} == {1, 3}
    fine = run.at(np.linspace(1000 - 2 * np.pi / 0.9, 1000, 20001))["x_mass"]
    assert np.ptp(fine) / 2 == pytest.approx(2.42023635057437, rel=1e-6)


def test_the_capsule_drifts_as_its_displacement_says():
    """Over whole periods of a periodic motion: the mean velocity."""
    run = gallery("drifting-capsule", "80 s")
    found = measure_drift(run)
    assert (found.of, found.verdict) == ("x_capsule", "forward" if found.rate > 0 else "backward")
    ends = run.at(np.array([40.0, 80.0]))["x_capsule"]
    assert found.rate == pytest.approx((ends[1] - ends[0]) / 40, rel=1e-3)
    whole = measure_drift(run, of="centre")
    assert whole.rate == pytest.approx(found.rate, rel=1e-3)
    assert count_impacts(run).impacts == 1


def test_parts_that_are_several_are_told_by_name():
    found = analyse(gallery("impact-damper", "120 s"), exponent=False)
    assert list(found.impacts) == ["left", "right"]
    for side in found.impacts.values():
        assert (side.impacts, side.sticks, side.words) == (1, None, {"co": 60})
    assert list(found.frequencies) == ["spring", "left"]
    assert found.drift is None  # the ball is caged, the body held
    stack = analyse(gallery("stack-of-blocks", "40 s"), window=(10.0, 40.0), exponent=False)
    assert list(stack.drift) == ["lower", "middle", "upper"]
    assert [one.verdict for one in stack.drift.values()] == ["none"] * 3
    assert list(stack.frequencies) == ["table", "seat", "lid"]
    assert stack.frequencies["seat"].verdict == "still"  # 0.5 g holds against 0.35 g
    assert (stack.regime.verdict, stack.regime.period) == ("periodic", 1)
    dumps([asdict(found), asdict(stack)], allow_nan=False)


def test_each_stick_is_counted_at_its_friction():
    """The lower block of the stack slips both ways in a period; the middle one never does."""
    run = gallery("stack-of-blocks", "40 s")
    table, seat = (count_impacts(run, (10.0, 40.0), part) for part in ("table", "seat"))
    assert (table.impacts, seat.verdict, seat.sticks) == (None, "no sticks", 0)
    assert table.words.keys() == {"rr"} or table.sticks > 0
    with pytest.raises(ValueError, match="part must be one of table, seat, lid, got 'wall'"):
        count_impacts(run, part="wall")


def test_the_section_is_taken_once_in_the_common_period():
    """2 and 3 Hz: every second, twelve states in pairs of (y, u), steady after the transient."""
    run = vibsim.simulate(load_case_text(SHAKEN))
    section = section_of(run, Span(100.0, 200.0))
    np.testing.assert_allclose(section.times, np.arange(100, 201), rtol=1e-15)
    assert section.points.shape == (101, 4)
    found = judge_regime(run)
    assert (found.verdict, found.period) == ("periodic", 1)
    states = run.at(section.times)
    base = run.case.scene().base[0]
    assert base.omega == 4 * np.pi
    y = states["x_cart"]  # X = 0 at whole seconds
    np.testing.assert_allclose(section.points[:, 0] / section.points[0, 0], y / y[0], rtol=1e-6)
    assert find_frequencies(run, of="tie").source_hz == pytest.approx(1.0, rel=1e-12)


def test_frequencies_without_a_common_period_have_no_section():
    text = SHAKEN.replace("omega: 3 Hz", "omega: 20 rad/s")
    found = judge_regime(vibsim.simulate(load_case_text(text)))
    assert (found.verdict, found.reason) == (
        "undecided",
        "sources without a common period, so no stroboscopic section",
    )


def test_a_section_of_a_motor_knows_the_phase_of_a_force():
    """Motor and force together: the state at a whole turn is not all, so the phase of the force is there."""
    text = """
name: both
bodies: {cart: 1 kg}
links: {spring: {between: [cart, ground], k: 100 N/m, c: 1 N s/m}}
forces: {push: {on: cart, A: 0.1 N, omega: 2 Hz}}
motor: {on: cart, m3: 0.02 kg, e: 0.02 m, J: 0.001 kg m^2, M0: 0.05 N m, Omega0: 5 Hz}
run: {t_end: 60 s, every: 5 ms}
"""
    run = vibsim.simulate(load_case_text(text))
    section = section_of(run, Span(30.0, 60.0))
    assert section.points.shape[1] == 5  # y, u, w, cosine and sine
    np.testing.assert_allclose(section.points[:, 3], np.cos(4 * np.pi * section.times), atol=1e-9)
    assert vibsim.analyse(run, exponent=False).capture.verdict in ("passed", "not met")


def test_resonances_are_numbered_where_there_are_several():
    """Two equal masses between walls: w^2 = k/m and 3 k/m; a stop in the middle stiffens the second."""
    text = """
name: chain
bodies: {a: 1 kg, b: 1 kg}
links:
  one: {between: [a, ground], k: 100 N/m}
  two: {between: [a, b], k: 100 N/m}
  three: {between: [b, ground], k: 100 N/m}
stops: {hit: {between: [a, b], gap: 1 mm, acts: compression, k: 900 N/m}}
run: {t_end: 1 s, every: 5 ms}
"""
    scene = load_case_text(text).scene()
    hz = np.sqrt([100, 300, 100, 300 + 2 * 900]) / (2 * np.pi)
    assert [(one.name, pytest.approx(one.hz, rel=1e-12)) for one in resonances(scene, False)] == [
        ("free 1", hz[0]),
        ("free 2", hz[1]),
    ]
    bilinear = hz[0], 2 * hz[1] * hz[3] / (hz[1] + hz[3])
    expected = {f"bilinear {i}": f for i, f in enumerate(bilinear, 1)}
    expected |= {f"half {name}": f / 2 for name, f in expected.items()}
    found = {one.name: one.hz for one in resonances(scene, True)}
    assert found == pytest.approx(expected, rel=1e-12)
    assert sorted(found.values()) == [one.hz for one in resonances(scene, True)]


def test_runs_are_compared_by_all_their_bodies_and_parts():
    case = load_case("gallery/impact-damper", {"run.t_end": "120 s"})
    run, other = (vibsim.simulate(case.with_values({"run.method": method})) for method in ("auto", "taylor"))
    assert compare(run, run, 1e-6).verdict == "identical"
    assert compare(run, other, 1e-9).verdict == "agree"
    softer = vibsim.simulate(case.with_values({"stops.left.k": "5 kN/m"}))
    found = compare(run, softer, 1e-6)
    assert {difference.key for difference in found.differences} == {"stops.left.k"}
    names = [statistic.name for statistic in found.statistics]
    impacts = "impact rate of left", "impact rate of right"
    assert names == ["amplitude of spring", "amplitude of left", *impacts]
    assert [statistic.unit for statistic in found.statistics] == ["m", "m", "1/s", "1/s"]


def test_exponents_of_a_scene_add_up_to_its_damping():
    """Liouville: volumes shrink by exp(-c/m t), impacts or not."""
    case = load_case("gallery/bilinear-oscillator", {"run.t_end": "400 s"})
    found = vibsim.lyapunov(case)
    assert found.exponents.sum() == pytest.approx(-0.02, rel=1e-9)
    assert not found.warnings


def test_digits_of_a_scene_are_those_of_its_closed_form():
    """The chain of equal bodies: contact j begins at 5 ms + j (5 ms + pi sqrt(m/(2 k))/2), to 30 digits."""
    pytest.importorskip("mpmath")
    from mpmath import mp, mpf

    run = vibsim.simulate(load_case("gallery/chain-with-gaps", {"run.every": "10 ms"}), digits=40)
    begins = run.digits.events["t"][run.events["kind"] == 1]
    assert len(begins) == 4
    with mp.workdps(50), localcontext() as context:
        context.prec = 50
        half = mp.pi / mp.sqrt(mpf(2) * 10**6)
        for j, text in enumerate(begins):
            exact = Decimal(mp.nstr(mpf(5) / 1000 + j * (mpf(5) / 1000 + half / 2), 48))
            assert abs(Decimal(str(text)) - exact) < Decimal("1e-38")
    assert run.attrs["digits_right"] >= 30


@pytest.mark.parametrize(
    ("name", "t_end"),
    [("percussive-drill", "0.5 s"), ("two-masses-with-friction", "60 s"), ("chain-with-gaps", "40 ms")],
)
def test_digits_are_found_by_themselves(name, t_end):
    run = vibsim.simulate(load_case(f"gallery/{name}", {"run.t_end": t_end}), digits="auto")
    assert run.attrs["digits_right"] >= 10


def test_impacts_at_a_rigid_stop_count_with_their_speed_before():
    """A ball before a rigid wall, period 1: it leaves at e times the speed with which it came."""
    text = """
name: ball
bodies: {ball: 1 kg}
links: {spring: {between: [ball, ground], k: 40 N/m}}
stops: {wall: {between: [ball, ground], gap: 5 mm, acts: compression, law: rigid, e: 0.8}}
forces: {drive: {on: ball, A: 1 N, omega: 2 Hz}}
run: {t_end: 60 s, every: 5 ms}
"""
    run = vibsim.simulate(load_case_text(text))
    found = analyse(run, exponent=False)
    assert (found.impacts.verdict, found.impacts.impacts, found.impacts.words) == (
        "every cycle",
        1,
        {"i": 60},
    )
    (struck,) = np.flatnonzero((run.events["kind"] == 9) & (run.events["t"] > 59.5))[-1:]
    t = run.events["t"][struck]
    before, after = (run.at(t + apart)["v_ball"] for apart in (-1e-9, 0.0))
    assert found.impacts.velocity.greatest == pytest.approx(before, rel=1e-4)
    assert after == pytest.approx(-0.8 * before, rel=1e-6)
    own = compare(run, vibsim.simulate(load_case_text(text.replace("0.8", "0.5"))), 1e-9).statistics
    rates = [statistic for statistic in own if statistic.name == "impact rate"]
    assert rates[0].a.mean == pytest.approx(2.0, rel=1e-2)  # of whole impacts in blocks of time


def test_runs_without_a_displacement_in_common_are_not_compared():
    ram, tool = (
        simulate(f"bodies: {{{name}: 1 kg}}\nrun: {{t_end: 1 s, every: 0.1 s}}") for name in ("ram", "tool")
    )
    with pytest.raises(ValueError, match="no displacement in common: x_ram and x_tool"):
        compare(ram, tool, 1e-6)


# Verdicts on runs with rigid stops, exponents among them, which are never made up where there are none.


@pytest.fixture(scope="module")
def pair():
    """One impact at each wall in each period of 0.2 s."""
    return vibsim.simulate(load_case("gallery/impact-pair", {"run.t_end": "20 s"}), trust=False)


def test_a_periodic_motion_with_impacts_is_called_so(pair):
    found = vibsim.analyse(pair)
    assert (found.regime.verdict, found.regime.period) == ("periodic", 1)
    assert {name: each.impacts for name, each in found.impacts.items()} == {"left": 1.0, "right": 1.0}


def test_a_periodic_motion_has_negative_exponents():
    found = vibsim.lyapunov(load_case("gallery/impact-pair", {"run.t_end": "20 s"}))
    assert np.all(found.exponents < 0) and found.warnings == ()


def test_a_sweep_computes_all_of_them():
    case = load_case("gallery/impact-pair", {"run.t_end": "4 s"})
    sweep = vibsim.sweep(case, {"stops.left.e": "0.5:0.7/2"}, compute="all")
    assert np.all(sweep["status"] == 1) and np.all(np.isfinite(sweep["lyapunov"]))
    assert np.all(sweep["lyapunov_spectrum"] < 1.0)


def test_a_motion_that_grazes_has_no_exponents(tmp_path, monkeypatch):
    """2 t - t^2 just comes up to 1 at t = 1 s."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "grazing.yaml").write_text(THROWN)
    text = call("run", "grazing.yaml", "--lyapunov", "all", "--discard", "0").stdout
    assert "exponents       none, none 1/s" in text
    assert (
        "exponents are undefined: at 1 s the motion grazes a rigid stop or strikes several at one instant"
        in text
    )
    line = call("run", "grazing.yaml", "--lyapunov", "1", "--discard", "0", "--json", "--force").stdout
    attrs = json.loads(line)
    assert attrs["lyapunov_exponents"] == [None]
    assert attrs["lyapunov_undefined_time"] == pytest.approx(1.0, abs=1e-6)


def test_exponents_of_an_impact_pair_sum_up(tmp_path, monkeypatch):
    """Free flight between walls with e: each impact presses areas by e^2."""
    monkeypatch.chdir(tmp_path)
    words = ("gallery/impact-pair", "--lyapunov", "all", "--t-end", "20 s", "-o", "pair.h5")
    assert call("run", *words).exit_code == 0
    result = vibsim.open_result("pair.h5")
    growth = result.attrs["lyapunov_growth"]
    rows = result.events
    struck = rows["t"][rows["kind"] == EVENT_KINDS["impact"]]
    count = ((struck > growth[0, 0]) & (struck <= growth[-1, 0])).sum()
    e = load_case("gallery/impact-pair").scene().rigid_stops[0][1].e
    expected = 2 * np.log(e) * count
    assert growth[-1, 1:].sum() == pytest.approx(expected, abs=1e-9)


# Verdicts on runs with rotors, further states and formulas.


@pytest.fixture(scope="module")
def run():
    return vibsim.simulate(case_of(CURRENT, {"run.t_end": "3 s"}))


def test_cycles_are_turns_of_the_rotor(run):
    """The angle passes whole turns there, to the line between two samples, and exactly where it is drawn."""
    for times, error in ((cycle_ends(run, (1.0, 3.0)), 1e-3), (turn_times(run, (1.0, 3.0)), 1e-7)):
        angles = run.at(times)["phi_left"] / (2 * np.pi)
        assert len(times) > 15 and np.abs(angles - np.round(angles)).max() < error


def test_the_regime_of_a_motor_with_its_current(run):
    verdicts = vibsim.analyse(run)
    assert verdicts.regime.verdict == "periodic" and verdicts.regime.period == 1
    assert len(verdicts.regime.multipliers) == 4
    assert verdicts.capture is None and verdicts.frequencies.verdict == "lines"


def test_coordinates_of_a_section_have_speeds_angles_and_states():
    """Of the machine, which a push drives: y, u, speed of the rotor, state; its angle no force feels."""
    at = SectionCoordinates(case_of(MACHINE).scene())
    assert at.names == ("x_cart", "v_cart", "w_left", "i")
    states = {name: np.array([1.0, 2.0]) for name in ("time", *at.names)}
    sizes = at.sizes(np.array([-1.0, -2.0, 3.0, 4.0]), np.array([1.0, 2.0, 5.0, 4.0]))
    assert sizes.tolist() == [1.0, 2.0, 1.0, 0.004]  # what hardly changes counts by a thousandth of itself
    assert at.points(states, sizes).shape == (2, 4)


def test_the_angle_of_a_further_rotor_counts_by_sine_and_cosine():
    text = MACHINE.replace("e: 0 m", "e: 0.01 m")
    at = SectionCoordinates(case_of(text).scene())
    states = {name: np.array([0.0]) for name in ("time", *at.names)} | {"phi_left": np.array([np.pi / 3])}
    points = at.points(states, np.ones(4))
    assert points[0, 4:] == pytest.approx([0.5, np.sqrt(0.75)])


def test_runs_are_compared_by_speeds_and_states_too(run):
    values = block_values(run, [(0.5, 1.0), (1.0, 1.5)])
    assert set(values) == {"amplitude", "rotor speed", "mean i"}
    speed = run["phi_left"][300] - run["phi_left"][200]
    assert values["rotor speed"][1] == pytest.approx(speed / 0.5 / (2 * np.pi), rel=1e-2)
    scene = run.case.scene()
    assert [unit_of(name, scene) for name in ("amplitude", "rotor speed", "mean i")] == ["m", "Hz", "A"]
    assert unit_of("drift rate", case_of(DRIVE).scene()) == "rad/s"


def test_states_alone_do_not_make_runs_differ():
    """Another state that no force reads: the displacements agree to the end."""
    one, other = (
        vibsim.simulate(case_of(MACHINE, {"states.i.start": start})) for start in ("0.5 A", "0.7 A")
    )
    assert compare(one, other, 1e-9).verdict == "agree"
    assert float(one["i"][-1]) != float(other["i"][-1])


def test_the_centre_of_mass_has_unbalances_in_it():
    """m x + m_r e cos(phi), by the mass of all."""
    run = vibsim.simulate(case_of(MACHINE.replace("e: 0 m", "e: 0.02 m")))
    expected = (1.1 * run["x_cart"] + 0.1 * 0.02 * np.cos(run["phi_left"])) / 1.1
    assert displacement(run, slice(None), "centre") == pytest.approx(expected, abs=1e-16)


def test_what_drifts_is_on_the_line():
    assert drifting(case_of(DRIVE).scene()) == {"load": "x_load"}
    assert drifting(case_of(MACHINE).scene()) == {}
    verdicts = vibsim.analyse(case_of(DRIVE), what=["drift", "impacts"], exponent=False)
    assert verdicts.drift.of == "x_load"
    assert verdicts.impacts.velocity is None or verdicts.impacts.velocity.unit == "rad/s"


def test_exponents_leave_out_what_no_force_feels():
    """x, v of the cart, w of the rotor and the state: the angle and the x of the state are none."""
    spectrum = vibsim.lyapunov(case_of(MACHINE, {"run.t_end": "0.5 s"}))
    assert len(spectrum.exponents) == 4
    assert spectrum.exponents.sum() == pytest.approx(
        -2 / 1.1 - 2, rel=1e-9
    )  # c/m of the cart, 1/T of the state
