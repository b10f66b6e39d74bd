"""Orbits of shipped cases beside numbers that programs which share nothing with vibsim came to.

Each was written from the equations of its scene alone. Flights under a constant and a sinusoidal force have
a closed form, whose zeros Brent's method found; springs went through scipy's DOP853 (rtol 1e-13) from event
to event. Multipliers are eigenvalues of central differences of the return map.
"""

from functools import cache

import pytest

from vibsim.orbits.search import orbit

DIFFERENCED = 1e-7  # of a multiplier: rounding 1e-16 over steps of 1e-5 to 1e-7, and its spread over these


@cache
def orbit_of(case):
    return orbit(f"gallery/{case}")


def test_drift_of_an_oscillator_that_chatters_to_rest():
    """Closed form of each flight and slide; blows until they part with less than 1e-9 m/s: 15 of the 29.

    The ground's friction stops both bodies while they touch. Rest wipes out all but one multiplier.
    """
    drifting = orbit_of("drifting-oscillator")
    kinds = [kind for kind, _ in drifting.events]
    assert kinds[-4:] == ["chatter", "rest_begin", "stick_begin", "rest_end"]
    assert drifting.drift["slider"] == pytest.approx(0.03965442606858631, rel=1e-14)
    largest, *others = sorted(drifting.multipliers, key=abs, reverse=True)
    assert largest == pytest.approx(-0.51261714, abs=DIFFERENCED)
    assert others == [0, 0]


def test_multipliers_under_dry_friction_with_reversals():
    """A body on a spring and dry friction that turns round without a stick, at 0.9 rad/s."""
    sliding = orbit_of("friction-oscillator")
    assert sorted(mu.real for mu in sliding.multipliers) == pytest.approx(
        [0.08723319, 0.56936554], abs=DIFFERENCED
    )


def test_stick_slip_on_a_belt_with_stribeck_friction():
    """From the onset of slip, where the spring and the damper pull mu_s N, to the belt's speed, and the stick
    that leads back to it. Slip and stick last 5.8108208155 s and 0.5054855424 s.

    The integrator began 1e-12 m/s slower than the belt: a time of 1e-12 s is what it is good for.
    """
    cycle = orbit_of("belt-oscillator")
    assert cycle.period == pytest.approx(6.3163063578909, abs=2e-12)
    assert cycle.state["x_block"] == pytest.approx(-0.952825783, abs=1e-9)  # printed to so many digits
    assert list(cycle.multipliers) == [0]  # the onset of slip has one place
