"""Axes, transients and plans: exact values, and what is refused."""

from fractions import Fraction

import numpy as np
import pytest

import vibsim
from tests.sweeps.made import OMEGA0, short_case, short_plan
from vibsim.analysis.cycles import parse_discard
from vibsim.cases import CaseError, RangeError, UnknownKeyError
from vibsim.sweeps.axes import read_axis
from vibsim.sweeps.sweep_plan import PlanError
from vibsim.sweeps.sweep_result import axis_text, sweep_lines


def test_the_81_values():
    axis = read_axis(short_case(), "Omega0", "3:7:0.05", "Hz")
    assert (axis.key, axis.name, axis.unit, len(axis)) == (OMEGA0, "omega0", "Hz", 81)
    assert axis.numbers().tolist() == [round(3 + i / 20, 2) for i in range(81)]
    assert axis.text(1) == "3.05 Hz"


@pytest.mark.parametrize(
    ("key", "text", "unit", "values"),
    [
        ("c", "0.01:0.05/9", "N s/m", [0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04, 0.045, 0.05]),
        ("stop.G", "2, 0.5, 1 mm", "mm", [2.0, 0.5, 1.0]),
        ("G", "1 mm, 0.2 cm", "cm", [0.1, 0.2]),
        ("k2", "log 1:1000/4 kN/m", "kN/m", [1.0, 10.0, 100.0, 1000.0]),
        ("Omega0", "240:300:30 rpm", "rpm", [240.0, 270.0, 300.0]),
        ("initial.phi", "0:90:45 deg", "deg", [0.0, 45.0, 90.0]),
    ],
)
def test_axes_of_any_number(key, text, unit, values):
    axis = read_axis(short_case(), key, text)
    assert axis.unit == unit and axis.numbers().tolist() == values


@pytest.mark.parametrize(
    ("text", "by_ratio"),
    [("log 1e3:1e6/31 N/m", True), ("log 5000:4000/100 N/m", True), ("1, 2, 4, 8 N/m", True),
     ("1000:5000/3 N/m", False), ("1, 2, 4, 9 N/m", False), ("1, 10 N/m", False)],
)  # fmt: skip
def test_values_spaced_by_ratio(text, by_ratio):
    axis = read_axis(short_case(), "k2", text)
    assert axis.by_ratio == by_ratio
    assert ("by ratio" in axis_text(axis)) == by_ratio


@pytest.mark.parametrize(
    ("key", "text", "error", "message"),
    [
        ("Omega", "3:4:1 Hz", UnknownKeyError, "did you mean"),
        ("run.method", "1,2", UnknownKeyError, "is no number"),
        ("Omega0", "3:4:1", CaseError, "axes excitation.Omega0: needs a unit"),
        ("c", "-1:1:1", CaseError, "must be >= 0, got -1"),
        ("c", "1,1.0", RangeError, "has the value 1 twice"),
        ("Omega0", "3 Hz, 20 rad/s", RangeError, "do not go together"),
    ],
)
def test_axes_that_are_refused(key, text, error, message):
    with pytest.raises(error) as caught:
        read_axis(short_case(), key, text)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "time"), [("1 s", 1.0), ("500ms", 0.5), ("0.25", 1.0), ("25%", 1.0), ("25 %", 1.0), ("0", 0.0)]
)
def test_transients(text, time):
    assert parse_discard(text).time(4.0) == time
    assert parse_discard(str(parse_discard(text))) == parse_discard(text)


@pytest.mark.parametrize("text", ["", "%", "1.5", "-1 s", "100%", "x", "5 mm", "2 %%"])
def test_transients_that_are_refused(text):
    with pytest.raises(ValueError):
        parse_discard(text)


@pytest.mark.parametrize(
    ("axes", "settings", "message"),
    [
        ({OMEGA0: "3 Hz"}, {"discard": "4 s"}, "leaves nothing of a run of 4 s"),
        ({OMEGA0: "3 Hz", "Omega0": "4 Hz"}, {}, "omega0 is given twice"),
        ({"x1": "0:1:1 mm"}, {"carry_state": True}, "cannot be swept first"),
        ({OMEGA0: "3 Hz"}, {"section": -1}, "negative"),
        ({OMEGA0: "3 Hz"}, {"direction": "left"}, "up, down or both"),
        ({OMEGA0: "3 Hz"}, {"every": "0 s"}, "positive"),
    ],
)
def test_plans_that_are_refused(axes, settings, message):
    with pytest.raises(PlanError, match=message):
        short_plan(axes, **settings)


def test_a_chain_goes_up_and_back_down_along_the_first_axis():
    plan = short_plan({"Omega0": "3, 4 Hz", "c": "0.1, 0.2"}, carry_state=True, direction="both")
    assert list(plan.chains()) == [
        [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
        [(0, 1, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1)],
    ]


def test_the_python_call():
    found = vibsim.sweep(short_case(), {"Omega0": "3:4:0.5 Hz", "c": "0.001, 0.1"}, jobs=2, section=5)
    assert found["omega0"].tolist() == [3.0, 3.5, 4.0] and found["c"].tolist() == [0.001, 0.1]
    assert found["mean_speed"].shape == (3, 2, 1) and found["section_speed"].shape == (3, 2, 1, 5)
    assert found.complete and found.case_at((2, 1, 0)).quantity("c").value == Fraction(1, 10)
    assert np.isfinite(found["amplitude_x1"]).all()
    with pytest.raises(KeyError, match="no speed; this sweep has omega0, c, mean_speed"):
        found["speed"]


def test_a_sweep_over_the_length_of_runs_says_how_long_they_are():
    """It told that of the case, which no point had."""
    result = vibsim.sweep(short_case(), {"run.t_end": "1:2/2 s"}, discard="50 %", section=1, jobs=1)
    lines = dict(sweep_lines(result))
    assert lines["run"] == "1, 2 s, 2 values, transient of 50 % left out of the statistics"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"discard": 0.5}, "discard must be a text with its unit, such as '100 s' or '50 %', got 0.5"),
        ({"every": 0.001}, "every must be a text with its unit, such as '5 ms', got 0.001"),
        ({"ensemble": 2, "spread": {"x1": 0.001}}, "spread of x1 must be a text .*, got 0.001"),
    ],
)
def test_what_needs_a_unit_is_no_bare_number(settings, message):
    """They ended in an AttributeError."""
    with pytest.raises(TypeError, match=message):
        vibsim.sweep(short_case(), {"c": "0.001, 0.1"}, **settings)
