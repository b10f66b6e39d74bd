"""What is measured, held against closed forms and against made-up courses."""

import numpy as np
import pytest

from tests.fitting.made import light_motor, run_up
from vibsim.cases import load_case
from vibsim.fitting.measures import CAPTURES, REGIMES, averaged
from vibsim.fitting.search import measure
from vibsim.fitting.statements import parse_statement
from vibsim.results import Result, simulate


def measured(result, *texts):
    """What statements ask of a run."""
    asked = tuple(parse_statement(text, [result.case]).asked for text in texts)
    return list(measure(result, asked).values())


TAU = run_up(5.5 * (1 - np.exp(-1)))  # time constant of the run-up [s]


@pytest.fixture(scope="module")
def free_run():
    return simulate(light_motor(), trust=False)


def test_a_free_motor_passes_a_speed_when_its_run_up_says(free_run):
    """Averaged over a time T = 12 turns the speed lags by its curvature, w'' T^2/24: by T^2/(24 tau)."""
    for hertz in (3.0, 4.0, 5.0):
        (passed,) = measured(free_run, f"passes {hertz} Hz before 30 s")
        lag = (12 / hertz) ** 2 / 24 / TAU
        assert passed == pytest.approx(run_up(hertz) + lag, abs=0.3 * lag)
    assert np.isnan(measured(free_run, "passes 5.6 Hz before 30 s"))


def test_a_free_motor_settles_at_its_no_load_speed(free_run):
    final, mean = measured(free_run, "settles above 0 Hz", "mean speed above 0 Hz in the last 5 s")
    reached = 5.5 * (1 - np.exp(-29 / TAU))
    assert final == pytest.approx(reached, rel=1e-2)
    assert mean == pytest.approx(reached, rel=2e-2)


def test_a_free_motor_is_not_held_for_long():
    """The time through a band of +-3 % at 3.7 Hz, 0.9 s, is too few turns to be a hold at all."""
    fast = simulate(light_motor(), trust=False)
    held = measured(fast, "held for at least 1 s", "released before 9 s", "held at 3 to 4 Hz")
    assert np.isnan(held).all()


def test_a_captured_motor_is_held_to_the_end():
    """Without the stop II-B stays near sqrt(k1/m)/2 pi, 4.0 to 4.1 Hz."""
    run = simulate(load_case("II-B", {"stop.G": "1000 m", "run.t_end": "100 s"}), trust=False)
    code, speed, length, since, released = measured(
        run,
        "captured",
        "held at 4 to 4.1 Hz",
        "held for at least 50 s",
        "held from 0 to 20 s",
        "released before 9 s",
    )
    assert code == CAPTURES["captured"]
    assert 3.95 < speed < 4.15
    assert since + length == pytest.approx(100, abs=3)
    assert np.isnan(released)


def test_steady_vibration_of_a_linear_oscillator():
    """x1 = X sin(omega t), X = A/(k1 - m1 omega^2), from the start on where v1(0) = X omega."""
    omega, amplitude = 2 * np.pi * 3.0, 1.0 / (200 - 0.297 * (2 * np.pi * 3.0) ** 2)
    case = load_case(
        "I-A",
        {
            "stop.G": "1000 m", "coupling.c": "0", "friction.mu": "1000", "excitation.omega": "3 Hz",
            "excitation.A": "1 N", "initial.v1": f"{float(amplitude * omega)!r} m/s", "run.t_end": "60 s",
        },
    )  # fmt: skip
    run = simulate(case, trust=False)
    found = measured(
        run, "vibration of x1 below 1 m", "vibration of x1 - x2 below 1 m", "vibration of x2 below 1 m",
        "frequency above 0 Hz", "mean speed above 0 Hz", "regime is periodic", "impacts below 1",
        "period below 2",
    )  # fmt: skip
    assert found[:2] == pytest.approx([abs(amplitude)] * 2, rel=1.2e-3)  # 1 - cos(pi dt/T), dt = 5 ms
    assert found[2] == 0.0
    assert found[3:5] == pytest.approx([3.0, 3.0], rel=1e-3)
    assert found[5:] == [REGIMES["periodic"], 0, 1]


def test_impacts_of_the_case_that_strikes_once_a_cycle():
    """I-C: 1948 impacts in 300 s; from some time on one in each of 6.5 cycles a second."""
    run = simulate(load_case("I-C"), trust=False)
    found = measured(run, "impacts above 0", "impacts above 0 over 100 to 200 s", "impacts per cycle above 0")
    assert found[0] == 1948
    assert found[1] == pytest.approx(650, abs=1)
    assert found[2] == pytest.approx(1.0, abs=1e-3)
    assert measured(run, "impact velocity above 0 m/s", "sticks per cycle below 1")[1] == 0


def made_up(x2):
    """A run of II-A whose motor turns at 3 Hz and whose block 2 goes as said: x2(t)."""
    time = np.arange(0, 300.01, 0.1)
    zeros = np.zeros_like(time)
    samples = {
        "time": time, "x1": zeros, "v1": zeros, "x2": x2(time), "v2": zeros, "phi": 2 * np.pi * 3 * time,
        "phidot": zeros + 6 * np.pi,
    }  # fmt: skip
    events = {"t": np.empty(0), "kind": np.empty(0)}
    attrs = {"complete": 1, "t_reached_s": 300.0}
    return Result(attrs, samples, events, case=load_case("II-A"))


def test_the_course_of_a_displacement():
    """Up to 80 mm at 170 s, then down to 28 mm, with a vibration of 3 Hz on top, averaged out."""
    run = made_up(lambda t: np.interp(t, [0, 170, 300], [0, 0.08, 0.028]) + 0.02 * np.sin(2 * np.pi * 3 * t))
    peak, share, end, rate = measured(
        run, "x2 peaks between 150 and 190 s", "x2 falls at least 10 %", "x2 ends above 0 m",
        "drift rate above 0 m/s over 20 to 160 s",
    )  # fmt: skip
    assert peak == pytest.approx(170, abs=1)
    assert share == pytest.approx(1 - 0.028 / 0.08, abs=0.02)  # the mean over 4 s ends 2 s before the end
    assert end == pytest.approx(0.028 + 2 * 4e-4, abs=2e-4)
    assert rate == pytest.approx(0.08 / 170, rel=1e-2)


def test_the_average_is_over_twelve_cycles():
    run = made_up(lambda t: np.sin(2 * np.pi * 3 * t))
    times, mean = averaged(run)
    assert np.abs(mean).max() < 1e-3 + 1 / 40
    assert times[0] == pytest.approx(2.0, abs=0.1) and times[-1] == pytest.approx(298.0, abs=0.1)


def test_a_displacement_that_never_rises_does_not_fall():
    run = made_up(lambda t: -t / 300)
    assert np.isnan(measured(run, "x2 falls at least 10 %"))


def test_too_short_a_run_has_nothing_to_tell():
    run = simulate(load_case("II-B", {"run.t_end": "1 s"}), trust=False)
    found = measured(
        run, "passes 1 Hz before 1 s", "held for at least 1 s", "settles above 1 Hz", "x2 ends above 0 m"
    )
    assert np.isnan(found).all()


def test_the_rest_distance_is_that_of_the_run():
    run = simulate(load_case("II-B", {"run.t_end": "20 s"}), trust=False)
    (needed,) = measured(run, "rest distance below 1 m")
    assert needed == pytest.approx(float((run["x1"] - run["x2"]).max()), rel=1e-2)
