"""Branches for tests, from orbits that are known to 22 digits."""

from functools import cache
from math import acos, pi, sqrt

import numpy as np

from tests.orbits.truths import STORED, TRUTHS
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.words import LETTERS

CAPTURED = "II-B c=0.03 captured n=1 (2 impacts/turn)"
PERIOD_5 = "I-A attractor, period 5"
RESONANT = "I-C attractor, period 1"
KEYS = {"I": "excitation.omega", "II": "excitation.Omega0"}


def orbit_of(name):
    """The vibsim orbit of a truth, with its case."""
    of = TRUTHS[name]
    if name == CAPTURED:
        case = load_case("II-B", {"c": "0.03", "excitation.Omega0": "5 Hz"})
    else:
        case = load_case(name[:3])
    return find_orbit(case.scene(), of.state, of.n, case=case)


@cache
def branch_of(name, span):
    """A branch through a truth."""
    return continue_branch(orbit_of(name), KEYS[name.partition("-")[0]], span)


def parameter(name):
    """The frequency of a truth [Hz]."""
    stored = next(one for one in STORED if one["name"] == name)
    return float(next(iter(stored["free_parameter"].values())))


def nearest(branch, kind, value):
    """The special point of a kind nearest to a value of the parameter."""
    return min((one for one in branch.specials if one.kind == kind), key=lambda s: abs(s.parameter - value))


KINDS = {letter: kind for kind, letter in LETTERS.items()}


def word(letters):
    """The events, of the first part each, that these letters stand for."""
    return tuple((KINDS[letter], 0) for letter in letters)


def assert_changes_are_listed(branch):
    """Between two points the index changes by what the special points between them say."""
    changes = np.diff(branch["index"])
    for special in branch.specials:
        changes[special.between[0]] -= special.jump
    assert not changes.any() and "unresolved" not in {one.kind for one in branch.specials}


K1, K2 = 200.0, 12400.0  # of the paper's machine [N/m]


def machine_rates(m1):
    """Natural rates of the machine without and with the stop [rad/s], m1 the mass of block 1 [kg]."""
    mass = 1 / (1 / m1 + 1 / 2.94)
    return sqrt(K1 / mass), sqrt((K1 + K2) / mass)


def free_frequency(a, G=1e-3, m1=0.297):
    """Frequency of the machine with the free amplitude a before its stop at G [m]: docs/branches.md."""
    w1, w2 = machine_rates(m1)
    if a <= G:
        return w1 / (2 * pi)
    d, V = G * K1 / (K1 + K2), a * w1 * sqrt(1 - (G / a) ** 2)
    return 1 / (2 * (acos(-G / a) / w1 + acos(d / sqrt(d**2 + (V / w2) ** 2)) / w2))
