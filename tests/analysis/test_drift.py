"""Drift rates of known motions, and how often their intervals hold."""

import numpy as np
import pytest

import vibsim
from tests.results.made import short_case, short_run
from vibsim.analysis.cycles import Span
from vibsim.analysis.drift import drift_of_blocks, measure_drift
from vibsim.orbits.coordinates import case_on_orbit

SPAN = Span(0.0, 300.0)
T = np.arange(0, 300, 0.01)
BLOCKS = 25


def drift_of(t, x):
    """The drift of displacements x [m] at t [s], in BLOCKS blocks."""
    return drift_of_blocks(*(np.mean(np.split(column, BLOCKS), axis=1) for column in (x, t)), SPAN)


def test_an_even_slide_under_a_vibration():
    """Whole periods cancel: only rounding is left of the vibration."""
    x = 7.0 + 2e-4 * T + 0.03 * np.sin(2 * np.pi * 5.5 * T)
    found = drift_of(T, x)
    assert found.rate == pytest.approx(2e-4, rel=1e-9)
    assert found.half_width < 1e-10
    assert (found.verdict, found.blocks) == ("forward", BLOCKS)
    assert drift_of(T, -x).verdict == "backward"


def test_an_interval_that_contains_0_and_more_is_undecided():
    """5.03 Hz fits blocks of 12 s in no whole number: what is left of it scatters about 0."""
    found = drift_of(T, 0.03 * np.sin(2 * np.pi * 5.03 * T))
    assert abs(found.rate) <= found.half_width > 1e-9
    assert (found.verdict, found.reason) == ("undecided", "95% interval from 25 blocks, which contains 0")


def test_what_stays_where_it_is_does_not_drift():
    """Less than 1e-12 m/s either way, 0.3 nm in the run."""
    assert drift_of(T, np.full_like(T, 3.0)).verdict == "none"
    assert drift_of(T, 3.0 + 1e-14 * T).verdict == "none"
    assert drift_of(T, 3.0 + 1e-9 * T).verdict == "forward"


def test_the_drift_of_an_orbit_that_is_known_is_exact():
    """II-B is still on its way to an orbit that drifts, while the interval of its span contains 0; from the
    orbit the drift of 150 periods is the same.
    """
    found = vibsim.analyse("II-B", what="drift").drift
    assert abs(found.rate) < found.half_width
    assert found.verdict == "forward"
    orbit = vibsim.orbit("II-B")
    t_end = 150 * orbit.period
    run = vibsim.simulate(case_on_orbit(orbit.case, orbit.state, t_end), trust=False)
    assert found.orbit_rate == pytest.approx((run.at([t_end])["x2"][0] - run["x2"][0]) / t_end, rel=1e-9)


def test_the_file_of_an_orbit_tells_its_drift():
    """One period is too short for blocks; what the orbit moves in it is known."""
    orbit = vibsim.orbit("I-C")
    found = vibsim.analyse(orbit.run, what="drift").drift
    assert (found.verdict, found.rate) == ("backward", None)
    assert found.orbit_rate == pytest.approx(orbit.drift["2"] / orbit.period, rel=1e-12)
    centre = measure_drift(orbit.run, of="centre", orbit_rates=orbit.drift_rates)
    assert centre.orbit_rate == pytest.approx(found.orbit_rate, rel=1e-12)


@pytest.mark.parametrize("wander", ["white", "correlated", "walk"])
def test_intervals_hold_as_often_as_they_say(wander):
    """95 % intervals of 25 blocks; displacements that scatter about a line, slowly too, or walk."""
    rng = np.random.default_rng(5)
    t = np.arange(0, 300, 0.4)
    held = 0
    for _ in range(400):
        noise = rng.normal(size=len(t))
        if wander == "walk":
            noise = np.cumsum(noise)
        elif wander == "correlated":  # over 20 s
            for i in range(1, len(t)):
                noise[i] = 0.98 * noise[i - 1] + 0.2 * noise[i]
        found = drift_of(t, noise + 0.01 * t)
        held += abs(found.rate - 0.01) <= found.half_width
    assert held / 400 >= 0.92


def test_block_2_and_the_centre_of_mass_drift_alike():
    run = short_run("I-C", "200 s")
    found = [measure_drift(run, of=of) for of in ("x2", "centre")]
    assert found[0].verdict == "backward"
    assert abs(found[0].rate - found[1].rate) <= found[0].half_width + found[1].half_width


def test_the_centre_of_mass_moves_by_friction_alone():
    """Without friction no outer force acts but the ideal source's: with a motor there is none at all."""
    run = short_run("II-B", "200 s", friction="none")
    found = measure_drift(run, of="centre")
    assert found.verdict == "none"
    assert abs(found.rate) < 1e-13  # rounding, in 200 s


def test_too_short_a_run_is_undecided():
    found = measure_drift(short_run("I-A"))
    assert (found.verdict, found.rate) == ("undecided", None)
    assert "8 are needed" in found.reason
    found = measure_drift(short_run("I-A", "300 s", run__every="1 s"))
    assert (found.verdict, found.reason) == ("undecided", "too few samples to a block")


def test_a_free_vibration_is_cut_into_vibrations():
    case = short_case("I-A", "100 s", excitation="none", initial__v2="1 mm/s", friction="none", stop="none")
    found = measure_drift(vibsim.simulate(case))
    assert found.rate == pytest.approx(1e-3 * 2.94 / 3.237, rel=1e-4)


def test_what_cannot_drift_or_is_not_there():
    with pytest.raises(ValueError, match="springs hold every body"):
        measure_drift(short_run("I-A", blocks__m2="fixed", friction="none"))
    with pytest.raises(ValueError, match="x1, x2, centre"):
        measure_drift(short_run("I-A"), of="x3")
    with pytest.raises(ValueError, match="lies outside the run, 0 to 5 s"):
        measure_drift(short_run("I-A"), (7.0, 9.0))
