"""Kinds of pictures, views, and quantities with their units."""

import math

import numpy as np
import pytest

from vibsim.plots.registry import KINDS, NEEDS, choose, fitting, kind_named
from vibsim.plots.sheet import amount, rounded, scale_for, seconds, symbol
from vibsim.plots.subject import PlotError, open_subject, parse_span

SPECTRA = {"spectrum", "spectrogram", "waterfall"}
ALWAYS = {"overview", "displacement", "velocity", "phase", "relative", "stiffness"} | SPECTRA
OF_FORMULAS = {"rotor-speed", "states"}  # of rotors and states, which none of these runs has
PERIODIC = {"impact-velocity", "stroboscopic", "phase-drift-free", "power"}
FITTING = {
    "ideal": ALWAYS | PERIODIC,
    "motor": {"power"}
    | {kind.name for kind in KINDS if kind.reads in ("trajectory", "case")}
    - {"orbit-portrait", *OF_FORMULAS},
    "fixed": (ALWAYS | PERIODIC) - {"phase-drift-free"},  # a spring to the wall
    "bare": ALWAYS,
    "quiet": ALWAYS | PERIODIC,
}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_kind_can_be_drawn_and_its_needs_are_known(kind):
    assert callable(kind.draw)
    assert set(kind.needs) <= set(NEEDS)
    assert kind.reads in ("trajectory", "case", "sweep", "branch", "locus", "fit", "bench")


@pytest.mark.parametrize("name", FITTING)
def test_which_kinds_fit(subject, name):
    assert {kind.name for kind in fitting([subject(name)])} == FITTING[name]


def test_together_only_what_fits_both(subject):
    both = {kind.name for kind in fitting([subject("bare"), subject("motor")])}
    assert both == FITTING["bare"] - {"spectrogram"}


def test_unknown_kind_names_the_nearest():
    with pytest.raises(
        PlotError, match=r"unknown kind 'motor_sped': did you mean motor-speed\? The kinds are overview,"
    ):
        kind_named("motor_sped")
    with pytest.raises(PlotError, match="unknown kind 'zzzz': the kinds are overview,"):
        kind_named("zzzz")


def test_unfit_kind_names_those_that_fit(subject):
    with pytest.raises(PlotError) as caught:
        choose(["motor-speed"], [subject("bare")])
    assert "kind motor-speed: it needs a motor" in str(caught.value)
    assert "bare.h5 has none; kinds that fit: overview, displacement," in str(caught.value)


def test_choices(subject):
    one = [subject("ideal")]
    assert [kind.name for kind in choose(None, one)] == ["overview"]
    assert [kind.name for kind in choose(["phase", "relative", "phase"], one)] == ["phase", "relative"]
    assert {kind.name for kind in choose(["all"], one)} == FITTING["ideal"]


def test_a_case_has_no_trajectory():
    case = open_subject("II-B")
    assert [kind.name for kind in choose(None, [case])] == ["stiffness", "motor"]
    with pytest.raises(
        PlotError, match="it shows a trajectory, and II-B is a case; kinds that fit: stiffness, motor"
    ):
        choose(["phase"], [case])


@pytest.mark.parametrize(
    ("text", "span"),
    [("100:110", (100, 110)), (":20", (-math.inf, 20)), ("1.5:", (1.5, math.inf)), ("1e2:2e2", (100, 200))],
)
def test_spans(text, span):
    assert parse_span(text) == span


@pytest.mark.parametrize("text", ["100", "a:b", "nan:3", "1:2:3", ""])
def test_what_is_no_span(text):
    with pytest.raises(PlotError, match="write FIRST:LAST in seconds"):
        parse_span(text)


@pytest.mark.parametrize("text", ["3:3", "5:2"])
def test_empty_spans(text):
    with pytest.raises(PlotError, match="is empty"):
        parse_span(text)


@pytest.mark.parametrize(
    ("largest", "unit", "label"),
    [(0.0868, "m", "mm"), (0.352, "m", "mm"), (1.0, "m", "m"), (0.001, "m", "mm"), (0.000999, "m", "µm"),
     (5.0, "m", "m"), (12e3, "N", "kN"), (0.112, "m/s", "mm/s"), (2.2, "m/s", "m/s"), (0.005, "N m", "mN m"),
     (0.0, "m", "m"), (3e-13, "m", "fm"), (3e-22, "m", "am")],
)  # fmt: skip
def test_prefix_puts_the_largest_magnitude_between_1_and_1000(largest, unit, label):
    scale = scale_for(unit, [0.0, -largest], np.empty(0))
    assert scale.unit == label
    assert 1 <= scale(largest) < 1000 or largest in (0.0, 3e-22)


def test_label_carries_the_unit():
    assert scale_for("m", [0.02]).label("Displacement") == "Displacement (mm)"


def test_nan_is_no_magnitude():
    assert scale_for("m", [np.nan, 0.02], [np.nan]).unit == "mm"


def test_seconds():
    assert seconds((290.0, 300.0)) == "290–300 s"


def test_rounded_decimals_tell_values_apart():
    assert rounded([0.001, 53 / 3500, 0.1]) == ["0.001", "0.0151", "0.1"]
    assert rounded([1.00001, 1.00002]) == ["1.00001", "1.00002"]
    assert rounded([2.5, 2.5]) == ["2.5", "2.5"]
    assert rounded([12345.6]) == ["12300"]
    assert rounded([]) == []


def test_amounts():
    assert amount(12600, "N/m") == "12.6 kN/m"
    assert amount(1.00022e6, "N/m") == "1 MN/m"
    assert amount(200, "N/m") == "200 N/m"
    assert scale_for("m", [3e7]).unit == "km"


def test_symbols():
    assert symbol("x1") == "$x_{1}$"
    assert symbol("v_drill") == r"$v_\mathrm{drill}$"
