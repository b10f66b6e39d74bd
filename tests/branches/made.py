"""Branches for tests, from orbits that are known to 22 digits."""

from functools import cache

from tests.orbits.truths import STORED, TRUTHS
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch

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
    """The frequency of a truth [Hz], its period [s], its word, and its state without x2."""
    stored = next(one for one in STORED if one["name"] == name)
    return float(next(iter(stored["free_parameter"].values())))


def nearest(branch, kind, value):
    """The special point of a kind nearest to a value of the parameter."""
    return min((one for one in branch.specials if one.kind == kind), key=lambda s: abs(s.parameter - value))
