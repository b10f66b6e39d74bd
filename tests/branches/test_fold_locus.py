"""Folds beside the graze of a rigid stop, in two parameters, against a closed form."""

import numpy as np
import pytest

from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import read_span


def fold_of_one_impact(w, c=0.1, e=0.8):
    """Amplitude of the force at the fold of orbits with one impact on a rigid stop at 1 (m = k = 1).

    Behind the impact the free part of the motion is h = a v with the rate b v, v the impact speed: it comes
    back to a v with its rate larger by (1 + e) v. The forced part, of the amplitude A / sqrt((1 - w^2)^2 +
    (c w)^2), is there 1 - a v, its rate -(e + b) v: least where v = a / (a^2 + ((e + b) / w)^2).
    """
    T, wd = 2 * np.pi / w, np.sqrt(1 - c * c / 4)
    decay, sine, cosine = np.exp(-c * T / 2), np.sin(wd * T), np.cos(wd * T)
    flow = decay * np.array(
        [[cosine + c / (2 * wd) * sine, sine / wd], [-sine / wd, cosine - c / (2 * wd) * sine]]
    )
    a, b = np.linalg.solve(flow - np.eye(2), [0.0, 1 + e])
    other = (e + b) / w
    return np.sqrt(((1 - w * w) ** 2 + (c * w) ** 2) * other**2 / (a * a + other**2)), a


@pytest.mark.slow
def test_folds_beside_a_graze_are_followed():
    """From 3e-5 N beside the graze of a rigid stop to where the locus meets that of the graze: at the damped
    natural frequency, where a = 0. The test value changes by 0.2 over 1e-6, and differences told nothing.
    """
    branch = continue_branch("gallery/impact-oscillator-coco", "drive.A", "0.05:1.05 N")
    plan = locus_plan(branch, "F1", *read_span(branch.case, "drive.omega", "0.9:1.5 rad/s"))
    locus = complete(LocusStore(plan), 200)[0]
    exact = [fold_of_one_impact(w)[0] for w in locus["second"]]
    np.testing.assert_allclose(locus["parameter"], exact, rtol=1e-11)
    assert locus.ends == (
        "a rigid stop is grazed: here the locus meets that of the graze",
        "end of the range",
    )
    assert 0 < locus["second"][0] - np.sqrt(1 - 0.1**2 / 4) < 1e-3 and len(locus) < 60
