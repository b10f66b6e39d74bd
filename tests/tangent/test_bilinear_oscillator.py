"""Floquet multipliers of the forced bilinear oscillator of Shaw & Holmes (J. Sound Vib. 90, 1983).

Their conditions for a motion that enters and leaves the second spring once per period are solved here by
matrix exponentials; the exponents are the logarithms of the multipliers per time.
"""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import root

from tests.scenes import fixed_block, harmonic, scene
from tests.tangent.test_liouville import exponents
from tests.trajectories import run

DAMPING, SECOND = 0.2, 9.0  # x'' + c x' + x + (k2 x while x > 0) = sin(omega t)
SETTLED, PERIODS = 1500, 64


def oscillator(stiffness):
    """Matrix of (x, v)."""
    return np.array([[0.0, 1.0], [-stiffness, -DAMPING]])


def driven(stiffness, omega):
    """Matrix of (x, v, sin, cos) with the force sin."""
    matrix = np.zeros((4, 4))
    matrix[:2, :2] = oscillator(stiffness)
    matrix[1, 2], matrix[2, 3], matrix[3, 2] = 1.0, omega, -omega
    return matrix


def multipliers(omega, guess):
    """Multipliers of the orbit that crosses x = 0 upwards near `guess` = (speed, phase, time in x > 0)."""
    period = 2 * math.pi / omega

    def mismatch(unknown):
        speed, phase, inside = unknown
        start = np.array([0.0, speed, math.sin(phase), math.cos(phase)])
        leaving = expm(driven(1 + SECOND, omega) * inside) @ start
        back = expm(driven(1.0, omega) * (period - inside)) @ leaving
        return leaving[0], back[0], back[1] - speed

    found = root(mismatch, guess, tol=1e-14)
    inside = found.x[2]
    matrix = expm(oscillator(1.0) * (period - inside)) @ expm(oscillator(1 + SECOND) * inside)
    return np.linalg.eigvals(matrix), found.x


def bilinear(omega, periods, method="closed_form"):
    force = harmonic(omega / (2 * math.pi), 1.0)
    t_end = periods * 2 * math.pi / omega
    return fixed_block(
        force, m1=1.0, k1=1.0, c=DAMPING, k2=SECOND, G=0.0, stop_sign=-1, t_end=t_end, method=method
    )


def settled_orbit(omega):
    """Speed, phase and time inside of the last orbit of a run."""
    events = run(bilinear(omega, SETTLED)).events
    entered = np.flatnonzero(events["kind"] == 1)[-2]
    t, end = events["t"][entered : entered + 2]
    return events["v1"][entered], math.fmod(omega * t, 2 * math.pi), end - t


@pytest.mark.parametrize("method", ["closed_form", "taylor"])
@pytest.mark.parametrize("omega", [0.88, 0.95, 1.0])  # real multipliers, far from and near to -1
def test_exponents_are_the_logarithms_of_the_multipliers(omega, method):
    found, _ = multipliers(omega, settled_orbit(omega))
    assert np.all(np.abs(found.imag) == 0) and np.ptp(found.real) > 0.1
    expected = np.sort(np.log(np.abs(found)))[::-1] * omega / (2 * math.pi)
    scene = bilinear(omega, SETTLED + PERIODS, method)
    ours = exponents(scene, begin=SETTLED * 2 * math.pi / omega)
    # directions have settled; Taylor rows begin up to a step, 0.2, late: the stretching within it counts
    bound = 1e-9 if method == "closed_form" else 0.5 / (PERIODS * 2 * math.pi / omega)
    np.testing.assert_allclose(ours.exponents, expected, rtol=0, atol=bound)


# Multipliers of an oscillator with dry friction under a harmonic force, from Den Hartog's solution (1931).
# x'' + x + s sgn(x') = sin(Omega t): between turning points of the symmetric motion without stops a
# disturbance turns by pi / Omega; at each its speed is multiplied by rho = (|S| - s) / (|S| + s).


HEAVY = 1e15  # block 1, moved as a sin(Omega t): a base that feels no reaction
LATE, CYCLES = 400, 50


def shaken(omega, friction, periods):
    """Block 2 (m = 1) on a spring (k = 1) from a base that moves as sin(omega t)."""
    force = harmonic(omega / (2 * math.pi), -HEAVY * omega**2)
    t_end = periods * 2 * math.pi / omega
    bare = {"m1": HEAVY, "m2": 1.0, "k1": 1.0, "c": 0.0, "k2": None, "G": None}
    return scene(force, **bare, N=friction, v1=omega, x2=0.5, t_end=t_end)


def expected_exponents(omega, friction):
    """Logarithms of the two multipliers per time, the base's own 0 first; of the symmetric motion, whose
    spring force at the turning points is |S|.
    """
    tau, amplification = math.pi / omega, 1 / (1 - omega**2)
    speed = -friction * math.sin(tau) / (1 + math.cos(tau))
    cosine = math.sqrt(1 - (speed / (amplification * omega)) ** 2)
    force = abs(cosine * (1 - amplification))
    rho = (force - friction) / (force + friction)
    turn = np.array([[math.cos(tau), math.sin(tau)], [-math.sin(tau), math.cos(tau)]])
    found = np.linalg.eigvals(turn @ np.diag([1.0, rho]))
    return [0.0, *np.sort(np.log(np.abs(found)))[::-1] / tau]


@pytest.mark.parametrize(("omega", "friction"), [(0.48, 0.1), (0.52, 0.2)])
def test_real_multipliers(omega, friction):
    scene = shaken(omega, friction, LATE + CYCLES)
    found = exponents(scene, begin=LATE * 2 * math.pi / omega)
    np.testing.assert_allclose(found.exponents, expected_exponents(omega, friction), rtol=0, atol=1e-8)
    assert found.rank_losses == 0
