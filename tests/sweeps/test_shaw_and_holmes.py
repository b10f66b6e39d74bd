"""The map of Shaw and Holmes (1983): motions with one impact in n periods before a wall at x = 0."""

import numpy as np
import pytest
from scipy.optimize import brentq

import vibsim
from vibsim.sweeps.quantities import KINDS

CASE = "gallery/impact-oscillator"


def trace(w, e, n):
    """Sum of both multipliers, whose product is e^2, of x'' + x = cos wt, x <= 0: one impact in n periods."""
    c = np.cos(2 * np.pi * n / w)
    return -2 * e * c + (1 + e) ** 2 * (1 - w * w) * (1 + c) / 2


def doubling(w, e, n):
    return 1 + trace(w, e, n) + e * e


@pytest.mark.parametrize(("n", "low", "high"), [(1, 2.6, 2.7), (2, 4.6, 4.7), (3, 5.3, 5.4)])
def test_labels_on_both_sides_of_a_doubling(n, low, high):
    """Inside the motion has the closed form's multipliers; 0.02 rad/s outside it is another one."""
    edge = brentq(doubling, low, high, args=(0.6, n), xtol=1e-14)
    inside = float(np.sign(doubling(high, 0.6, n)))  # on which side it is stable
    values = ", ".join(f"{edge + side * 0.02 * inside!r} rad/s" for side in (1, -1)).replace(" rad/s,", ",")
    found = vibsim.sweep(
        CASE, {"drive.omega": values}, overrides={"wall.e": "0.6", "run.t_end": "600 s"}, section=0,
        compute="attractor", jobs=1,
    )  # fmt: skip
    kind, period, multiplier = (
        found[f"attractor_{name}"].ravel() for name in ("kind", "period", "multiplier")
    )
    word = found.attractors["word"][found["attractor"].ravel()[0]]
    assert (kind[0], period[0], word) == (KINDS["periodic"], n, "i")
    t = trace(edge + 0.02 * inside, 0.6, n)
    assert multiplier[0] == pytest.approx(np.abs(np.roots([1, -t, 0.36])).max(), rel=1e-11)
    assert kind[1] != KINDS["periodic"] or period[1] != n


def test_the_curve_of_doublings():
    orbit = vibsim.orbit(CASE, {"drive.omega": "3.7 rad/s"})
    branch = vibsim.continue_branch(orbit, "drive.omega", "3.34:3.7 rad/s")
    locus = vibsim.continue_locus(branch, {"wall.e": "0.7:0.9"}, label="PD1")
    exact = [brentq(doubling, 3.3, 3.4, args=(e, 2), xtol=1e-15) for e in locus["second"]]
    np.testing.assert_allclose(locus["parameter"], exact, rtol=1e-12)
