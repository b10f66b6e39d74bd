"""The largest exponent against the growth of the distance between two runs (Benettin et al. 1976).

Every few tenths of a second the second run is pulled back along the line to the first and starts afresh, so
nothing of the tangent flow is used. Both are followed along one and the same orbit.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.scenes import paper
from tests.tangent.bundles import exponents
from tests.trajectories import run

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
