"""The language of statements: what is read, and what is refused with what is allowed."""

import re
from math import inf, pi

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.fitting.measures import CAPTURES, OBSERVABLES, REGIMES, Bounds, FitError
from vibsim.fitting.statements import PHRASES, parse_statement

MOTORS = [load_case("II-B"), load_case("II-C")]
MOTOR, IDEAL = [load_case("II-B")], [load_case("I-C")]


@pytest.mark.parametrize(
    ("text", "name", "bounds"),
    [
        ("captured until the end", "capture", (CAPTURES["captured"],) * 2),
        ("Captured", "capture", (CAPTURES["captured"],) * 2),
        ("escapes", "capture", (CAPTURES["escaped"],) * 2),
        ("not met", "capture", (CAPTURES["not met"],) * 2),
        ("released between 80 and 120 s", "released", (80, 120)),
        ("released 1 to 2 min", "released", (60, 120)),
        ("released between 500 ms and 120 s", "released", (0.5, 120)),
        ("released before 2 min", "released", (-inf, 120)),
        ("passes 4.5 Hz after 80 s", "passes", (80, inf)),
        ("settles between 6.1 and 6.3 Hz", "final speed", (6.1, 6.3)),
        ("settles between 366 and 378 rpm", "final speed", (6.1, 6.3)),
        ("final speed at least 10 rad/s", "final speed", (10 / (2 * pi), inf)),
        ("held for at least 30 s", "held for", (30, inf)),
        ("held at 3.6 to 3.8 Hz", "held at", (3.6, 3.8)),
        ("x2 falls at least 10 %", "x2 falls", (0.1, inf)),
        ("x2 falls 0.1 to 0.5", "x2 falls", (0.1, 0.5)),
        ("drifts between -1 and 1 mm/s", "drift rate", (-1e-3, 1e-3)),
        ("impacts per cycle at least 0.9", "impacts per cycle", (0.9, inf)),
        ("vibration of x1 - x2 below 3 cm", "vibration of x1 - x2", (-inf, 0.03)),
        ("regime is quasi-periodic", "regime", (REGIMES["quasi-periodic"],) * 2),
        ("period 1 to 1", "period", (1, 1)),
    ],
)
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
    from vibsim import simulate

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
