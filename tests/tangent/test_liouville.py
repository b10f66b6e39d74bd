"""V10: a volume grows by the integral of the trace and by the determinants at the events; known exponents."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import root

from tests.engine.bundles import totals, volume_bound
from tests.engine.runs import run
from tests.scenes import fixed_block, harmonic, motor, paper, scene
from vibsim.engine.tangent.lyapunov import exponents_of


def test_free_masses_over_one_long_piece():
    """The longest step of a series, 100 s and more: the unit square becomes a sliver of 1 by 400."""
    free = replace(paper("I-A"), k1=0.0, c=0.0, k2=None, G=None, N=None, source="none", A=None, F0=None)
    still = replace(free, omega=None, cycles=None, cycles_lo=None, x1=0.0, v1=0.0, x2=0.0, v2=0.0)
    one = replace(still, m1=1.0, m2=1.0, t_end=400.0, every_num=133333334, every_den=10**6, method="taylor")
    found = totals(one.as_parts())
    assert found["tangent_pieces"] <= 4
    assert abs(found["volume_residual"]) <= volume_bound(found, one.t_end) < 1e-8


def exponents(scene, count=None, begin=0.0):
    """The exponents of two blocks as `LyapunovExponents`."""
    return exponents_of(totals(scene.as_parts(), count, begin))


# Exponents of linear scenes without events: known exactly.


m1, m2, k1 = 0.297, 2.94, 200.0
MOBILITY = 1 / m1 + 1 / m2
METHODS = ("closed_form", "taylor")
ROUNDING = 1e-12  # of some 100 pieces over some 10 s


def turns(a, b, count):
    """Time of `count` turns of y'' + 2 a y' + b y = 0 [s]: over it all (y, y') shrink by exp(-a t)."""
    return count * 2 * math.pi / math.sqrt(b - a * a)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("c", [20.0, 100.0])
def test_an_overdamped_oscillator(method, c):
    a = c / (2 * m1)
    kappa = math.sqrt(a * a - k1 / m1)
    at_rest = fixed_block(None, c=c, G=None, t_end=8.0, method=method)
    found = exponents(at_rest, begin=4.0)  # exp(-2 kappa 4) = 1e-57 at most: the directions have settled
    slow = -(k1 / m1) / (a + kappa)
    np.testing.assert_allclose(found.exponents, [slow, -(a + kappa)], rtol=1e-12)


@pytest.mark.parametrize("c", [0.02, 2.0])
def test_two_blocks_without_friction(c):
    """(y, u) shrinks by exp(-a t) with a = c (1/m1 + 1/m2) / 2; the common velocity stays."""
    a, b = c * MOBILITY / 2, k1 * MOBILITY
    settled = 40.0 / a
    t_end = settled + turns(a, b, 50)
    two = scene(harmonic(3.5, 0.07), c=c, N=None, k2=None, G=None, t_end=t_end)
    found = exponents(two, begin=settled)
    assert found.span == (settled, t_end)
    np.testing.assert_allclose(found.exponents, [0.0, -a, -a], rtol=0, atol=ROUNDING * (1 + a))


def test_the_motor_alone():
    """V9: 0 for the angle, -M0 / (Omega0 (J + m3 e^2)) for the speed; the heavy block swings undamped."""
    rate = 0.005 / (2 * math.pi * 5.5 * (0.001 + 0.03 * 0.11**2))
    heavy = fixed_block(motor(5.5), m1=1e30, k1=1e31, c=0.0, G=None, t_end=600.0)
    found = exponents(heavy, begin=400.0)  # exp(-rate 400) = 6e-19
    # the swing shakes the rotor: m3 e times its acceleration over J + m3 e^2 tilts the directions to and fro
    np.testing.assert_allclose(found.exponents[3], -rate, rtol=1e-5)
    np.testing.assert_allclose(found.exponents[:3], 0.0, atol=1e-5)
    assert sum(found.exponents) == pytest.approx(-rate, rel=1e-12)


# The largest exponent against the growth of the distance between two runs (Benettin et al. 1976). Every few
# tenths of a second the second run is pulled back along the line to the first and starts afresh, so nothing
# of the tangent flow is used. Both are followed along one and the same orbit.


KICK = 1e-9  # of a velocity [m/s]: far above rounding, and its square far below
RATE, ARM = 26.0, 0.11  # to compare displacements [1/s] and angles [m] with velocities
SCALES = {"x1": RATE, "v1": 1.0, "x2": RATE, "v2": 1.0, "phi": ARM * RATE, "phidot": ARM}


def orbit(scene, num, den):
    """States every num / den [s]."""
    samples = run(replace(scene, every_num=num, every_den=den)).samples
    names = [name for name in SCALES if name in samples]
    return [{name: float(samples[name][i]) for name in names} for i in range(len(samples["time"]))]


def advanced(scene, state, length):
    """The state `length` [s] after `state`, from which a run starts afresh at phase 0 of the source."""
    ended = run(replace(scene, **state, t_end=length, every_num=1000, every_den=1)).events
    return {name: float(ended[name][-1]) for name in state}


def pulled_back(state, other):
    """Difference of two states pulled back to the size KICK, and the logarithm of its size over KICK.

    A shift of both blocks, which never fades, is taken out: the exponents are those of the rest.
    """
    apart = {name: other[name] - value for name, value in state.items()}
    apart["x1"], apart["x2"] = apart["x1"] - apart["x2"], 0.0
    size = np.sqrt(sum((apart[name] * SCALES[name]) ** 2 for name in apart)) / KICK
    return {name: value / size for name, value in apart.items()}, float(np.log(size))


def growth(scene, num, den):
    """Logarithm of the distance's growth since the start, every num / den [s]."""
    states = orbit(scene, num, den)
    difference, _ = pulled_back(states[0], {name: value + KICK for name, value in states[0].items()})
    sums = [0.0]
    for state, after in pairwise(states):
        kicked = {name: value + difference[name] for name, value in state.items()}
        difference, grown = pulled_back(after, advanced(scene, kicked, num / den))
        sums.append(sums[-1] + grown)
    return np.array(sums)


@pytest.mark.parametrize(
    ("name", "num", "den"), [("I-A-eq211", 2, 7), ("I-B-eq211", 4, 11), ("I-C-eq211", 4, 13), ("II-B", 1, 4)]
)
def test_chaotic_motion(name, num, den):
    """Over the later part of the run, when both have turned into the direction of fastest growth."""
    scene = paper(name)
    begin, end = 100 * num, 400 * num  # in units of 1 / den: before it settles
    sums = growth(replace(scene, t_end=end / den), num, den)
    theirs = (sums[-1] - sums[100]) / ((end - begin) / den)
    found = exponents(replace(scene, t_end=end / den), count=1, begin=begin / den)
    # the two begin their spans up to a step apart: a growth by a factor of two, over 75 s
    assert found.exponents[0] == pytest.approx(theirs, abs=0.01)
    assert theirs > 0.3


# Floquet multipliers of the forced bilinear oscillator of Shaw & Holmes (J. Sound Vib. 90, 1983). Their
# conditions for a motion that enters and leaves the second spring once per period are solved here by matrix
# exponentials; the exponents are the logarithms of the multipliers per time.


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
