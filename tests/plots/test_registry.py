import pytest

from vibsim.plots.registry import KINDS, NEEDS, choose, fitting, kind_named
from vibsim.plots.subject import PlotError

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
    from vibsim.plots.subject import open_subject

    case = open_subject("II-B")
    assert [kind.name for kind in choose(None, [case])] == ["stiffness", "motor"]
    with pytest.raises(
        PlotError, match="it shows a trajectory, and II-B is a case; kinds that fit: stiffness, motor"
    ):
        choose(["phase"], [case])
