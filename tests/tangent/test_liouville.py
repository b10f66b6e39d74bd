"""V10: a volume grows by the integral of the trace and by the determinants at the events."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, MOTORS, paper
from tests.tangent.bundles import totals
from tests.trajectories import run

# a series of order 20 is cut off at 1.65**20 / 20! = 9e-15 of the disturbance; rounding adds some eps times
# the spread of the vectors, which free masses shear by the length of a piece
PER_PIECE = 400 * 2.0**-53


def bound(found, span=0.0):
    """Of the residual of a run of `span` [s]."""
    return PER_PIECE * found["tangent_pieces"] * max(1.0, span / found["tangent_pieces"]) ** 2


def methods(name):
    return ("taylor",) if name in MOTORS else ("closed_form", "taylor")


@pytest.mark.parametrize(("name", "method"), [(n, m) for n in CASE_NAMES for m in methods(n)])
def test_the_nine_cases(name, method):
    found = totals(paper(name, t_end=300.0, method=method))
    assert abs(found["volume_residual"]) <= bound(found)
    assert found["impacts"] > 500 and found["reversals"] > 50


@settings(max_examples=150)
@given(scenes(sources=("none", "harmonic"), features=False))
def test_random_ideal_scenes_by_closed_form(scene):
    found = totals(scene)
    assert abs(found["volume_residual"]) <= bound(found, scene.t_end)


@settings(max_examples=150)
@given(scenes(features=False))
def test_random_scenes_by_taylor(scene):
    found = totals(replace(scene, method="taylor"))
    assert abs(found["volume_residual"]) <= bound(found, scene.t_end)


def test_free_masses_over_one_long_piece():
    """The longest step of a series, 100 s and more: the unit square becomes a sliver of 1 by 400."""
    free = replace(paper("I-A"), k1=0.0, c=0.0, k2=None, G=None, N=None, source="none", A=None, F0=None)
    still = replace(free, omega=None, cycles=None, cycles_lo=None, x1=0.0, v1=0.0, x2=0.0, v2=0.0)
    one = replace(still, m1=1.0, m2=1.0, t_end=400.0, every_num=133333334, every_den=10**6, method="taylor")
    found = totals(one)
    assert found["tangent_pieces"] <= 4
    assert abs(found["volume_residual"]) <= bound(found, one.t_end) < 1e-8


def test_impacts_and_reversals_by_hand():
    """det = exp(-int c (1/m1 + 1/m2) dt) times the (|S| - N) / (|S| + N) of the reversals."""
    scene = paper("I-B", t_end=20.0)
    result = run(scene)
    first = int(np.flatnonzero(result.events["friction"] != 0)[0])  # it starts stuck
    assert np.all(result.events["friction"][first:] != 0)
    turned = {name: column[result.events["kind"] == 3] for name, column in result.events.items()}
    y = turned["x1"] - turned["x2"]
    force = 200.0 * y + 0.001 * (turned["v1"] - turned["v2"]) + 12400.0 * np.minimum(y + 0.001, 0.0)
    jumps = np.log((np.abs(force) - scene.N) / (np.abs(force) + scene.N))
    slipping = 20.0 - float(result.events["t"][first])
    expected = -0.001 * (1 / 0.297 + 1 / 2.94) * slipping + np.sum(jumps)
    growth = totals(scene, resume=result.row(first))["growth"]
    assert len(jumps) > 100 and np.count_nonzero(result.events["kind"] == 1) > 90
    # a jump is known to the rounding of S, eps |S|, over |S| - N > 0.01 N; there are 200 of them
    assert np.sum(growth[-1, 1:]) == pytest.approx(expected, abs=1e-10)
