"""Sticking takes a direction: it is counted, and the exponent of that direction is minus infinity."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import paper, scene
from tests.tangent.bundles import exponents
from tests.trajectories import ENGINES, run

m1, m2, k1 = 0.297, 2.94, 200.0


def resting(method, **changes):
    """Block 2 stuck from the start to the end, block 1 vibrating with |S| < N."""
    period = 2 * math.pi / math.sqrt(k1 / m1 - (0.5 / m1) ** 2)
    fields = {"N": 10.0, "c": 1.0, "k2": None, "G": None, "x1": 0.01, "t_end": 20 * period}
    return scene(None, **{**fields, **changes}, method=method)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", ["closed_form", "taylor"])
def test_a_block_that_never_moves(method, engine):
    found = exponents(resting(method), engine)
    np.testing.assert_allclose(found.exponents[:2], -1.0 / (2 * m1), rtol=1e-12)
    assert found.exponents[2] == -math.inf
    assert found.rank_losses == 1
    assert abs(found.volume_residual) < 1e-11  # of the two directions that are left


def test_fewer_exponents_than_the_rank_leaves_are_all_finite():
    found = exponents(resting("closed_form"), count=2)
    assert np.all(np.isfinite(found.exponents)) and found.rank_losses == 1
    assert math.isnan(found.volume_residual)  # a bundle that is not complete spans no volume


def test_every_sticking_in_the_span_counts():
    case = paper("I-A", t_end=30.0)
    found, events = exponents(case, begin=10.0), run(case).events
    begin = found.span[0]
    stuck = int(events["friction"][events["t"] <= begin][-1] == 0)
    sticks = int(np.count_nonzero(events["kind"][events["t"] > begin] == 4))
    assert found.rank_losses == sticks + stuck > 20
    assert found.exponents[2] == -math.inf and np.all(np.isfinite(found.exponents[:2]))


def test_a_sticking_before_the_span_leaves_all_directions():
    case = paper("I-B", t_end=30.0)  # starts stuck, then slips for good
    assert exponents(case).rank_losses == 1
    later = exponents(case, begin=10.0)
    assert later.rank_losses == 0 and np.all(np.isfinite(later.exponents))


def test_a_span_that_begins_at_rest_counts_it():
    case = paper("I-A", t_end=30.0)
    events = run(case).events
    stick = int(np.flatnonzero((events["kind"] == 4) & (events["t"] > 10.0))[0])
    since, until = events["t"][stick], events["t"][stick + 1]
    found = exponents(replace(case, t_end=float(until)), begin=float(since + until) / 2)
    assert since < found.span[0] < until
    assert found.rank_losses == 1 and found.exponents[2] == -math.inf
