"""What is measured, held against closed forms and against made-up courses."""

import re
from math import inf, pi

import numpy as np
import pytest

from tests.fitting.made import light_motor, run_up
from vibsim.cases import load_case
from vibsim.fitting.measures import CAPTURES, OBSERVABLES, REGIMES, Bounds, FitError, averaged
from vibsim.fitting.search import measure
from vibsim.fitting.statements import PHRASES, parse_statement
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


def test_a_free_motor_is_not_held_for_long(free_run):
    """The time through a band of +-3 % at 3.7 Hz, 0.9 s, is too few turns to be a hold at all."""
    held = measured(free_run, "held for at least 1 s", "released before 9 s", "held at 3 to 4 Hz")
    assert np.isnan(held).all()


def test_a_captured_motor_is_held_to_the_end():
    """Without the stop II-B stays near sqrt(k1/m)/2 pi, 4.0 to 4.1 Hz."""
    run = simulate(load_case("II-B", {"stop.G": "1000 m", "run.t_end": "100 s"}), trust=False)
    code, speed, length, since, released = measured(
        run, "captured", "held at 4 to 4.1 Hz", "held for at least 50 s", "held from 0 to 20 s",
        "released before 9 s",
    )  # fmt: skip
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
    asked = ("passes 1 Hz before 1 s", "held for at least 1 s", "settles above 1 Hz", "x2 ends above 0 m")
    assert np.isnan(measured(run, *asked)).all()


def test_the_rest_distance_is_that_of_the_run():
    run = simulate(load_case("II-B", {"run.t_end": "20 s"}), trust=False)
    (needed,) = measured(run, "rest distance below 1 m")
    assert needed == pytest.approx(float((run["x1"] - run["x2"]).max()), rel=1e-2)


# The language of statements: what is read, and what is refused with what is allowed.


MOTORS = [load_case("II-B"), load_case("II-C")]
MOTOR, IDEAL = [load_case("II-B")], [load_case("I-C")]


@pytest.mark.parametrize(
    ("text", "name", "bounds"),
    [("captured until the end", "capture", (CAPTURES["captured"],) * 2),
     ("Captured", "capture", (CAPTURES["captured"],) * 2),
     ("escapes", "capture", (CAPTURES["escaped"],) * 2), ("not met", "capture", (CAPTURES["not met"],) * 2),
     ("released between 80 and 120 s", "released", (80, 120)),
     ("released 1 to 2 min", "released", (60, 120)),
     ("released between 500 ms and 120 s", "released", (0.5, 120)),
     ("released before 2 min", "released", (-inf, 120)), ("passes 4.5 Hz after 80 s", "passes", (80, inf)),
     ("settles between 6.1 and 6.3 Hz", "final speed", (6.1, 6.3)),
     ("settles between 366 and 378 rpm", "final speed", (6.1, 6.3)),
     ("final speed at least 10 rad/s", "final speed", (10 / (2 * pi), inf)),
     ("held for at least 30 s", "held for", (30, inf)), ("held at 3.6 to 3.8 Hz", "held at", (3.6, 3.8)),
     ("x2 falls at least 10 %", "x2 falls", (0.1, inf)), ("x2 falls 0.1 to 0.5", "x2 falls", (0.1, 0.5)),
     ("drifts between -1 and 1 mm/s", "drift rate", (-1e-3, 1e-3)),
     ("impacts per cycle at least 0.9", "impacts per cycle", (0.9, inf)),
     ("vibration of x1 - x2 below 3 cm", "vibration of x1 - x2", (-inf, 0.03)),
     ("regime is quasi-periodic", "regime", (REGIMES["quasi-periodic"],) * 2),
     ("period 1 to 1", "period", (1, 1))],
)  # fmt: skip
def test_what_is_said_is_understood(text, name, bounds):
    found = parse_statement(text, MOTOR)
    assert (found.asked.name, found.case, found.text) == (name, 0, text)
    assert (found.bounds.low, found.bounds.high) == pytest.approx(bounds, rel=1e-15)
    assert (found.share, found.weight) == (0.8, 1.0)


def test_every_phrase_is_read_as_itself():
    for phrase in PHRASES:
        observable = OBSERVABLES[phrase.name]
        argument = " 4 Hz" if observable.argument else ""
        text = phrase.words + argument + ("" if observable.words else " at least 0" + _unit(observable))
        assert parse_statement(text, MOTOR).asked.name == phrase.name


def _unit(observable):
    return " Hz" if observable.dimension == "angular rate" else ""


@pytest.mark.parametrize(
    ("tail", "window", "last"),
    [
        ("over 100 to 170 s", (100, 170), 0),
        ("over 90 s to 3 min", (90, 180), 0),
        ("after 100 s", (100, inf), 0),
        ("in the last 50 s", None, 50),
    ],
)
def test_a_statement_may_name_a_span(tail, window, last):
    found = parse_statement(f"drift rate above 0 mm/s {tail}", MOTOR)
    assert (found.asked.window, found.asked.last) == (window, last)
    assert parse_statement(f"chaotic {tail}", MOTOR).asked.window == window


def test_a_span_is_cut_at_the_end_of_the_run():
    after = parse_statement("drifts above 0 m/s after 100 s", MOTOR).asked
    assert after.window_in(300.0) == (100.0, 300.0)
    assert parse_statement("chaotic in the last 50 s", MOTOR).asked.window_in(300.0) == (250.0, 300.0)
    assert parse_statement("chaotic", MOTOR).asked.window_in(300.0) is None


def test_share_weight_and_case():
    found = parse_statement("II-C: escapes from at least 60 % of the starts, weight 2.5", MOTORS)
    assert (found.case, found.share, found.weight) == (1, 0.6, 2.5)
    assert parse_statement("II-B: captured from every start", MOTORS).share == 1.0
    assert parse_statement("II-B: drifts 1 to 2 mm/s over 50 to 90 s from 10 %", MOTORS).share == 0.1


@pytest.mark.parametrize(
    ("text", "cases", "message"),
    [
        ("captrued", MOTOR, "did you mean captured?"),
        ("", MOTOR, "unknown words"),
        ("is nice", MOTOR, "a statement is [CASE:] WHAT [RANGE]"),
        ("captured", MOTORS, "say of which case it is, as in II-B: captured"),
        ("II-D: captured", MOTORS, "no case II-D (did you mean II-B?); the cases are II-B, II-C"),
        ("captured at 4 Hz", MOTOR, "a verdict takes no range"),
        ("released", MOTOR, "released needs a range: between A and B, at least A"),
        ("released at about 80 s", MOTOR, "got at about 80 s"),
        ("released between 120 and 80 s", MOTOR, "a range must rise, got "),
        ("released between 80 and 120 Hz", MOTOR, "must be a time in s, ms, us, min or h, got 80 Hz"),
        ("settles between 6.1 and 6.3", MOTOR, "needs a unit (Hz, rpm, rev/s, deg/s, rad/s)"),
        ("settles between 6 and 6.3 Hx", MOTOR, "unknown unit Hx"),
        ("passes before 80 s", MOTOR, "passes what? Such as passes 4.5 Hz before 120 s"),
        ("captured in the last 50 s", MOTOR, "capture is of the whole run; it takes no span of time"),
        ("drifts above 0 m/s over 200 to 100 s", MOTOR, "a range must rise, got "),
        ("drifts above 0 m/s after 400 s", MOTOR, "not within the run, 0 to 300 s"),
        ("chaotic in the last 301 s", MOTOR, "not within the run, 0 to 300 s"),
        ("captured from 120 % of the starts", MOTOR, "above 0 and at most 100 %, got 120 %"),
        ("captured from 0 %", MOTOR, "above 0 and at most 100 %"),
        ("captured, weight 0", MOTOR, "the weight must be positive, got 0"),
        ("captured", IDEAL, "capture needs a motor; I-C lacks it"),
        ("final speed below 3 Hz", IDEAL, "final speed needs a motor"),
    ],
)
def test_what_cannot_be_used_is_refused_with_what_is_allowed(text, cases, message):
    with pytest.raises(FitError, match=re.escape(message)) as error:
        parse_statement(text, cases)
    assert str(error.value).startswith(f"statement {text!r}: ")


def test_statements_on_ideal_sources():
    for text in (
        "chaotic",
        "drifts below 0 m/s",
        "impacts per cycle 0.9 to 1.1",
        "vibration of x1 below 1 m",
    ):
        assert parse_statement(text, IDEAL).bounds != Bounds()


def test_the_shortfall_grows_with_the_distance_and_never_passes_1():
    settles = parse_statement("settles between 6.1 and 6.3 Hz", MOTOR)
    values = [6.2, 6.1, 6.3, 6.4, 6.0, 5.9, 3.7, float("nan")]
    assert [settles.shortfall(value) for value in values] == pytest.approx([0, 0, 0, 0.5, 0.5, 1, 1, 1])
    longer = parse_statement("held for at least 30 s", MOTOR)
    assert [longer.shortfall(value) for value in (40, 30, 15, 0)] == pytest.approx([0, 0, 0.5, 1])
    captured = parse_statement("captured", MOTOR)
    assert [captured.shortfall(CAPTURES[word]) for word in ("captured", "escaped", "passed")] == [0, 1, 1]


def test_what_decides_a_statement():
    passes = parse_statement("passes 4.5 Hz before 120 s", MOTOR)
    assert passes.decided_at(95.0, 300.0) == 95.0
    assert passes.decided_at(float("nan"), 300.0) == 300.0
    assert parse_statement("captured", MOTOR).decided_at(4.0, 300.0) == 300.0
    assert parse_statement("drifts above 0 m/s over 50 to 90 s", MOTOR).decided_at(1.0, 300.0) == 90.0


def test_statements_on_named_parts_are_those_that_need_no_numbered_blocks():
    drill = [load_case("gallery/impact-damper")]
    for text in ("impacts per cycle 1 to 2", "impact velocity above 1 mm/s", "periodic", "period at most 2"):
        assert parse_statement(text, drill).bounds is not None
    for text, needs in {
        "drifts above 0 m/s": "a moving block 2",
        "frequency 1 to 2 Hz": "blocks 1 and 2",
        "captured": "a motor",
        "sticks per cycle 1 to 2": "friction",
    }.items():
        with pytest.raises(FitError, match=f"needs {needs}.*; impact-damper lacks it"):
            parse_statement(text, drill)


def test_the_vibration_of_named_bodies_is_that_of_their_columns():
    damper = [load_case("gallery/impact-damper")]
    asked = parse_statement("vibration of x_ball - x_body at least 2 mm", damper).asked
    run = damper[0].with_values({"run.t_end": "40 s"})
    result = simulate(run, {"initial.ball.v": "0.1 m/s"})
    whole = result["x_ball"] - result["x_body"]
    measured = asked.observable.measure(result, None, 0.0)
    assert 0.5 < measured / (np.ptp(whole[len(whole) // 2 :]) / 2) <= 1
    pendulum = [load_case("gallery/driven-pendulum")]
    name = pendulum[0].scene().line[0].columns[0]
    assert parse_statement(f"vibration of {name} below 90 deg", pendulum).bounds.high == pytest.approx(pi / 2)
    for text in ("vibration of x1 below 1 m", "vibration of x_ball - x_boby below 1 m"):
        with pytest.raises(FitError, match=r"no displacement of impact-damper.*; there are x_"):
            parse_statement(text, damper)
