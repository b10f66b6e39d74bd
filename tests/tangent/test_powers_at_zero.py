"""Disturbances of motions through a zero of the base of a power, where the derivative of the force is
infinite or has no series.
"""

from dataclasses import replace
from math import gamma, pi, sqrt

import numpy as np
import pytest

from vibsim.cases.case import load_case_text
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.trajectory import open_trajectory


def scene(force, numbers, more=""):
    """One body of 1 kg on a spring of that force."""
    return load_case_text(
        f'bodies: {{a: 1 kg}}\nlinks: {{s: {{between: [a, ground], force: "{force}", {numbers}}}}}\n{more}\n'
        "run: {t_end: 1 s, every: 1 s}"
    ).scene()


def period(k, p, amplitude):
    """Period of x'' = -k |x|^p sign x [s]."""
    quarter = sqrt(pi) * gamma(1 + 1 / (p + 1)) / gamma(0.5 + 1 / (p + 1))
    return 4 * sqrt((p + 1) / (2 * k)) * amplitude ** ((1 - p) / 2) * quarter


@pytest.mark.parametrize("power", ["1/3", "1/2", "2/3", "0.9", "1.2", "1.5"])
def test_a_period_of_a_free_oscillation(power):
    """Energy is kept: M = [[1, 0], [a dT/dA, 1]] over a period T(A), with -a at the start."""
    p, k, A = eval(power), 100.0, 0.5
    T = period(k, p, A)
    carried = Carrier(scene(f"k*abs(d)**({power})*sign(d)", f"k: {k} N/m^({power})")).carry([A, 0.0], T)
    turn = k * A**p * (1 - p) / (2 * A) * T
    np.testing.assert_allclose(carried.state, [A, 0], atol=1e-12)
    np.testing.assert_allclose(carried.matrix, [[1, 0], [turn, 1]], atol=1e-12 * max(abs(turn), 1))


# force, its numbers, more of the case, start, end [s], monodromy matrix by difference quotients of 45 digits
QUOTIENTS = [
    ("k*abs(d)**(1/3)*sign(d)+c*v", "k: 5 N/m^(1/3), c: 0.1 N s/m",
     "forces: {f: {on: a, A: 2 N, omega: 0.7 Hz}}", [0.1, 0.3], 3.0,
     [-0.23223092586627214, 0.4417219848196926, 0.9524617960671004, -5.001666041560153]),
    ("k*sqrt(max(d,0 m))+q*d", "k: 2 N/m^0.5, q: 4 N/m", "", [0.5, 0.2], 6.0,
     [1.0215785871155187, 0.4308796647537987, -1.3595531699771226, 0.4054472080065794]),
    ("k*abs(d)**(1/3)*abs(d)**(1/2)*sign(d)+q*d", "k: 3 N/m^(5/6), q: 2 N/m", "", [0.5, 0.2], 6.0,
     [0.8250043309181018, 0.4912462017402297, -1.709796452112287, 0.1940219961909612]),
    ("k*sign(d)*(exp(sqrt(abs(d)/l))-1)+q*d", "k: 3 N, l: 1 m, q: 2 N/m", "", [0.5, 0.2], 6.0,
     [-1.9241995386245436, -0.46608679569635114, 4.089418942992798, 0.4708577011961641]),
]  # fmt: skip


@pytest.mark.parametrize(("force", "numbers", "more", "start", "end", "matrix"), QUOTIENTS)
def test_quotients_of_45_digits(force, numbers, more, start, end, matrix):
    """Driven and damped; a power on one side only; a product, and a function, of powers."""
    carried = Carrier(scene(force, numbers, more)).carry(start, end)
    np.testing.assert_allclose(carried.matrix, np.reshape(matrix, (2, 2)), atol=1e-12)


def test_no_derivative_is_told():
    """From rest x grows like t^2, and the derivative of sqrt(x) like 1 / t, which has no integral."""
    pushed = "forces: {f: {on: a, F0: 1 N}}"
    carried = Carrier(scene("k*sqrt(abs(d))*sign(d)", "k: 2 N/m^0.5", pushed)).carry([0.0, 0.0], 0.5)
    assert carried.undefined_at == 0 and np.isnan(carried.matrix).all()
    assert np.isfinite(carried.state).all()


def test_exponents_of_a_damped_oscillation():
    """Their sum is minus the damping by mass, and the volume of disturbances grows as it must."""
    more = "forces: {f: {on: a, A: 2 N, omega: 0.7 Hz}}"
    one = scene("k*abs(d)**(1/3)*sign(d) + c*v", "k: 5 N/m^(1/3), c: 0.1 N s/m", more)
    bodies = (replace(one.bodies[0], x=0.1),)
    trajectory = open_trajectory(one.but(t_end=5.0, bodies=bodies), tangent=2)
    list(trajectory.blocks())
    totals = trajectory.totals
    assert sum(totals["exponents"]) == pytest.approx(-0.1, abs=1e-12)
    assert abs(totals["volume_residual"]) < 1e-12
