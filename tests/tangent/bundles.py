"""Runs with tangent bundles for tests."""

import numpy as np

from tests.trajectories import opened
from vibsim.engine.tangent.lyapunov import exponents_of
from vibsim.engine.tangent.tangent_space import dimension


def totals(scene, engine="auto", count=None, begin=0.0, resume=None):
    """Totals of the run of `scene` with `count` exponents (None: all) from the time `begin` [s]."""
    count = dimension(scene.as_parts()) if count is None else count
    trajectory = opened(scene, engine, resume, tangent=count, tangent_from=begin)
    for _ in trajectory.blocks():
        pass
    return trajectory.totals


def exponents(scene, engine="auto", count=None, begin=0.0):
    """The exponents as `LyapunovExponents`."""
    return exponents_of(totals(scene, engine, count, begin))


def same_bits(one, other):
    """Whether two dicts of totals agree in every bit."""
    return list(one) == list(other) and all(bits(one[name]) == bits(other[name]) for name in one)


def bits(value):
    return np.asarray(value, dtype="f8").tobytes()
