"""Was the motor captured? Speeds of known shape, and the motors of the paper."""

from dataclasses import replace

import numpy as np
import pytest

import vibsim
from tests.results.made import short_run
from tests.scenes import motor, scene
from vibsim.analysis import cycles
from vibsim.analysis.capture import averaged_load, capture_of_turns, judge_capture, resonances
from vibsim.analysis.cycles import BAND, TURNS, Span, cycle_ends, longest_stretch
from vibsim.cases.case import load_case_text
from vibsim.results import simulate

SCENE = scene(motor(5.5)).as_parts()  # time constant 9.42 s; half bilinear 3.685 Hz, free 4.149 Hz
TAU = 2 * np.pi * 5.5 * (0.001 + 0.03 * 0.11**2) / 0.005


def turns_of(speed, t_end, step=0.01):
    """Ends of the turns of a rotor of the speed `speed(t)` [Hz]."""
    t = np.arange(0, t_end, step)
    angle = np.concatenate([[0], np.cumsum(speed((t[1:] + t[:-1]) / 2) * step)])
    return np.interp(np.arange(1, int(angle[-1]) + 1), angle, t)


def run_up(t, no_load=5.5):
    """Speed of the motor alone [Hz], validation case V9."""
    return no_load * (1 - np.exp(-t / TAU))


def held(speed, end=1e9):
    """When a run-up gets to `speed` [Hz], and a run-up that is then held there until `end` [s]."""
    reached = -TAU * np.log(1 - speed / 5.5)

    def at(t):
        return np.where(t < end, np.minimum(run_up(t), speed), run_up(reached + np.maximum(t - end, 0)))

    return reached, at


def judged(speed, t_end, impacts=()):
    turns, start = turns_of(speed, t_end), 2 * np.pi * float(speed(np.float64(0.0)))
    begun = replace(SCENE, motor=replace(SCENE.motor, phidot=start))
    return capture_of_turns(turns, np.array(impacts, dtype=float), begun, Span(0.0, t_end))


IMPACTS = np.arange(0.0, 300.0, 0.13)


def test_a_free_run_up_is_no_capture():
    found = judged(run_up, 100.0)
    assert (found.verdict, found.holds) == ("passed", ())
    assert found.final_speed_hz == pytest.approx(5.5, rel=1e-3)
    for passage in found.passages:
        expected = -TAU * np.log(1 - passage.resonance.hz / 5.5)
        # the mean over D = 3.3 s lags by D^2/24 w''/w' = D^2/(24 TAU) = 0.048 s, of single turns by less
        assert passage.time == pytest.approx(expected, abs=0.05)
    assert [passage.resonance.name for passage in found.passages] == ["half bilinear", "free"]


def test_a_motor_held_to_the_end_is_captured():
    reached, speed = held(3.69)
    found = judged(speed, 200.0, IMPACTS)
    assert (found.verdict, found.resonance.name) == ("captured", "half bilinear")
    assert found.since == pytest.approx(reached, abs=TURNS / 2 / 3.5)
    assert found.until is None
    assert found.holds[-1].end == pytest.approx(200, abs=TURNS / 3.69)
    assert found.speed_hz == pytest.approx(3.69, rel=1e-3)


@pytest.mark.parametrize(("length", "verdict"), [(2.0, "passed"), (12.0, "passed"), (25.0, "escaped")])
def test_how_long_it_is_held_tells_a_passage_from_a_capture(length, verdict):
    """The free motor passes 3.69 Hz +- 3 % in 1.16 s; 15 times that is 17 s."""
    reached = -TAU * np.log(1 - 3.69 / 5.5)
    found = judged(held(3.69, reached + length)[1], 100.0, IMPACTS)
    assert found.verdict == verdict
    assert found.final_speed_hz == pytest.approx(5.5, rel=2e-3)
    if length > 10:
        delayed = found.holds[0]
        free = TAU * np.log((5.5 - 3.69 * (1 - BAND)) / (5.5 - 3.69 * (1 + BAND)))
        assert delayed.delay == pytest.approx((length + free) / free, rel=0.1)
        assert delayed.begin == pytest.approx(reached, abs=2)
        assert delayed.end == pytest.approx(reached + length, abs=2)


def test_a_hold_far_from_any_resonance_is_a_capture_too():
    found = judged(held(2.9)[1], 200.0)
    assert (found.verdict, found.resonance) == ("captured", None)


def test_a_motor_settles_at_its_final_speed():
    """One number: the mean over the last turns, and what that lies below the no-load speed."""
    found = judge_capture(short_run("II-C", "300 s"))
    below = 100 * (1 - found.final_speed_hz / 6.5)
    assert f"settled at {found.final_speed_hz:.3g} Hz, {below:.2g} % below no-load speed" in found.reason


def test_a_motor_settled_under_load_above_the_resonance_has_passed():
    found = judged(held(4.98)[1], 200.0, IMPACTS)
    assert found.verdict == "passed"
    assert found.holds[-1].at_end


def test_a_motor_that_ends_below_every_resonance_has_not_met_it():
    weak = scene(motor(3.5)).as_parts()
    turns = turns_of(lambda t: run_up(t, 3.47), 150.0)
    assert capture_of_turns(turns, IMPACTS, weak, Span(0, 150)).verdict == "not met"


def test_a_motor_that_slows_down_has_passed_nothing():
    found = judged(lambda t: 5.5 + 1.5 * np.exp(-t / TAU), 100.0)
    assert (found.verdict, found.passages) == ("not met", ())


@pytest.mark.parametrize("start", [0.0, 3.0])
def test_a_resonance_that_is_passed_in_the_first_turns_was_met(start):
    """So strong a motor that the mean over its first 12 turns lies above both resonances already."""
    found = judged(lambda t: 5.5 - (5.5 - start) * np.exp(-t / 0.4), 100.0)
    assert found.verdict == "passed"
    for passage in found.passages:
        expected = 0.4 * np.log((5.5 - start) / (5.5 - passage.resonance.hz))
        assert passage.time == pytest.approx(expected, abs=0.06)
    assert [passage.resonance.name for passage in found.passages] == ["half bilinear", "free"]


def test_a_window_later_on_tells_of_what_is_in_it():
    run = short_run("II-B", "300 s")
    assert [passage.resonance.name for passage in judge_capture(run).passages] == ["half bilinear", "free"]
    assert judge_capture(run, (200.0, 300.0)).passages == ()


IMPACT_DAMPER = """
name: damped
bodies: {left: 1 kg, middle: 2 kg, right: 1 kg, ball: 0.1 kg}
links:
  a: {between: [left, ground], k: 2 kN/m, c: 2 N s/m}
  b: {between: [left, middle], k: 2 kN/m, c: 2 N s/m}
  c: {between: [middle, right], k: 2 kN/m, c: 2 N s/m}
stops:
  wall_l: {between: [ball, right], law: rigid, gap: 5 mm, acts: extension, e: 0.7}
  wall_r: {between: [ball, right], law: rigid, gap: 5 mm, acts: compression, e: 0.7}
motor: {on: middle, m3: 50 g, e: 40 mm, J: 0.001 kg m^2, M0: 0.05 N m, Omega0: 8 Hz}
run: {t_end: 30 s, every: 2 ms}
"""


def test_a_run_up_through_the_first_of_three_natural_frequencies():
    """From rest through 2.695 Hz in half a second, where the speed at an instant passes it at 0.448 s."""
    run = simulate(load_case_text(IMPACT_DAMPER), trust=False)
    found = judge_capture(run)
    passed = run.time[np.argmax(run["phidot"] >= 2 * np.pi * 2.695328775478997)]
    assert (found.verdict, [one.resonance.name for one in found.passages]) == ("passed", ["free 1"])
    assert found.passages[0].time == pytest.approx(passed, abs=0.1)


def test_resonances_of_a_scene_with_rigid_stops_are_its_natural_frequencies():
    """A ball of a tenth of the mass that strikes rigid walls does not make them vanish."""
    damped = load_case_text(IMPACT_DAMPER).scene()
    K = np.array([[4000, -2000, 0], [-2000, 4000, -2000], [0, -2000, 2000]])
    M = np.diag([1, 2.05, 1])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)))) / (2 * np.pi)
    for impacting in (False, True):
        assert [one.hz for one in resonances(damped, impacting)] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("t_end", "reason"), [(8.0, "too few turns"), (14.0, "still changing"), (20.0, "lingers")]
)
def test_too_short_a_run_is_undecided(t_end, reason):
    found = judged(held(3.69)[1], t_end, IMPACTS)
    assert found.verdict == "undecided"
    assert reason in found.reason


class Rotor:
    """A run of nothing but a rotor of given angles."""

    def __init__(self, time, phi):
        self.columns = {"time": time, "phi": phi}
        self.case = short_run("II-B").case

    def column(self, name):
        return self.columns[name]


def test_a_rotor_that_rocks_back_is_counted_once():
    t = np.linspace(0, 10, 10_001)
    rocking = Rotor(t, 4 * t + 6 * np.sin(3 * t))  # phidot from -14 to 22 rad/s
    ends = cycle_ends(rocking, (0.0, 10.0))
    angles = rocking.column("phi")
    first = [t[np.argmax(angles >= 2 * np.pi * k)] for k in range(len(ends))]
    assert np.diff(angles).min() < 0
    np.testing.assert_allclose(ends, first, atol=1.1e-3)


def test_turns_end_where_the_angle_is_a_whole_one():
    wild = short_run("II-B", "20 s", initial__phi="-0.3 rad", initial__phidot="-3 rad/s")
    ends = cycle_ends(wild, (0.0, 20.0))
    assert wild["phi"].min() < -0.3
    assert np.all(np.diff(ends) > 0)
    np.testing.assert_allclose(wild.at(ends)["phi"], 2 * np.pi * np.arange(len(ends)), atol=2e-3)


def test_the_longest_stretch_against_all_stretches():
    rng = np.random.default_rng(3)
    ratio = (1 + BAND) / (1 - BAND)
    for _ in range(50):
        values = np.exp(np.cumsum(rng.normal(scale=0.015, size=40))) * rng.choice([1, 1, 1, -1], size=40)
        stretches = [
            (a, b)
            for a in range(40)
            for b in range(a, 40)
            if values[a : b + 1].min() > 0 and values[a : b + 1].max() <= ratio * values[a : b + 1].min()
        ]
        first, last = longest_stretch(values)
        assert last - first == max(b - a for a, b in stretches)
        assert (first, last) in stretches
    assert longest_stretch(np.array([-1.0, 0.0])) == (0, -1)


def test_an_ideal_source_is_not_captured():
    with pytest.raises(ValueError, match="ideal source"):
        judge_capture(short_run("I-A"))


@pytest.mark.parametrize(
    ("name", "changes", "verdict", "speed", "resonance"),
    [
        ("II-A", {}, "not met", None, None),
        ("II-B", {}, "passed", 3.69, "half bilinear"),
        ("II-C", {}, "passed", None, None),
        ("II-B", {"coupling__c": "0.03 N s/m"}, "captured", 3.69, "half bilinear"),
        ("II-B", {"coupling__c": "0.049 N s/m"}, "captured", 3.69, "half bilinear"),
        ("II-C", {"coupling__c": "0.046 N s/m"}, "escaped", 3.69, "half bilinear"),
        ("II-B", {"excitation__Omega0": "4 Hz"}, "captured", 3.7, "half bilinear"),  # 8 % below no-load
        ("II-B", {"stop": "none"}, "captured", 4.02, "free"),
        ("II-C", {"stop": "none"}, "captured", 4.04, "free"),
        ("II-B", {"excitation__Omega0": "10 Hz"}, "captured", 7.11, "bilinear"),
    ],
)
def test_the_motors_of_the_paper(name, changes, verdict, speed, resonance):
    found = judge_capture(short_run(name, "300 s", **changes))
    assert found.verdict == verdict
    assert found.speed_hz == (None if speed is None else pytest.approx(speed, abs=0.03))
    assert (found.resonance and found.resonance.name) == resonance


@pytest.mark.parametrize("rows", [7, 100, 3999])
def test_turns_are_the_same_in_pieces_of_any_size(rows, monkeypatch):
    t = np.linspace(0, 10, 10_001)
    for rotor in (Rotor(t, 4 * t + 6 * np.sin(3 * t)), short_run("II-B", "20 s")):
        whole = cycle_ends(rotor, (0.0, 10.0))
        monkeypatch.setattr(cycles, "ROWS", rows)
        np.testing.assert_array_equal(cycle_ends(rotor, (0.0, 10.0)), whole)
        monkeypatch.undo()


FRAME = """
bodies: {frame: 3 kg}
links: {support: {between: [frame, ground], k: 2000 N/m, c: 3 N s/m}}
motor: {on: frame, m3: 0.1 kg, e: 30 mm, J: 0.002 kg m^2, M0: 0.1 N m, Omega0: 4 Hz}
run: {t_end: 60 s, every: 2 ms}
"""


def test_the_load_by_averaging_is_that_of_the_linear_oscillator():
    """m3 e w^2 cos w t on mass m + m3: P = c (w |x|)^2 / 2, and the torque P / w."""
    scene = vibsim.load_case(FRAME).scene()
    w = 2 * np.pi * np.array([2.0, 4.04, 9.0])
    size = 0.003 * w**2 / abs(2000 - 3.1 * w**2 + 3j * w)
    np.testing.assert_allclose(averaged_load(scene, w), 3 * w * size**2 / 2, rtol=1e-12)


@pytest.mark.parametrize("support", ["", "friction: {guide: {between: [frame, ground], mu: 0.02, N: 10 N}}"])
def test_the_load_by_averaging_is_near_that_of_the_orbit(support):
    orbit = vibsim.orbit(FRAME + support)
    w = 2 * np.pi / orbit.period
    torque = 0.1 * (1 - w / (2 * np.pi * 4))
    assert averaged_load(orbit.scene, np.array([w])) == pytest.approx(torque, rel=0.02)
    assert torque > 2e-3


def test_averaging_knows_nothing_of_stops_and_formulas():
    w = np.array([2 * np.pi * 4.04])
    assert np.isnan(averaged_load(vibsim.load_case("II-B").scene(), w)).all()
    cubic = FRAME.replace("k: 2000 N/m, c: 3 N s/m", 'force: "k*d + k3*d**3", k: 2000 N/m, k3: 1e5 N/m^3')
    assert np.isnan(averaged_load(vibsim.load_case(cubic).scene(), w)).all()
