"""Branches that leave others: at a doubling of the paper's machine, and where they come back."""

import numpy as np
import pytest

from tests.branches.made import CAPTURED, RESONANT, assert_changes_are_listed, branch_of, nearest
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.plan import BranchError

pytestmark = pytest.mark.slow  # branches of doubled orbits, followed whole


@pytest.fixture(scope="module")
def doubled():
    """The orbits of two periods between I-C's two doublings."""
    return continue_branch(branch_of(RESONANT, "3.4:6.6 Hz"), switch="PD2", max_points=400)


def test_a_doubling_opens_and_closes(doubled):
    single = branch_of(RESONANT, "3.4:6.6 Hz")
    low, high = single.special("PD1").parameter, single.special("PD2").parameter
    assert doubled.plan.n == 2 and doubled.ends == ("leaves another branch", "joins the orbits of 1 period")
    first, last = doubled["parameter"][0], doubled["parameter"][-1]
    # quadratic: the first orbit is 2^-8 away from the doubling, scaled by 4 Hz
    assert 0 < high - first < 1e-5 and abs(last - low) < 1e-5
    assert doubled["period"][0] == pytest.approx(2 / first, rel=1e-14)


def test_it_is_stable_at_first(doubled):
    """The doubling of I-C at 4.08 Hz is supercritical: -1 is crossed with falling frequency."""
    single = branch_of(RESONANT, "3.4:6.6 Hz")
    assert single.special("PD2").jump == -1  # unstable below, stable above
    assert doubled["stable"][0]
    near = np.array(single.special("PD2").multipliers)
    other = min(near, key=lambda mu: abs(mu + 0.9714154303758))
    assert min(abs(doubled["multipliers"][0] - other**2)) < 1e-2


def test_special_points_along_it(doubled):
    """Two folds, a pair of Neimark-Sacker points, and two doublings, one of them next to a grazing."""
    kinds = [one.kind for one in doubled.specials if one.jump]
    assert kinds == ["neimark-sacker", "neimark-sacker", "doubling", "doubling", "fold", "fold"]
    grazing = nearest(doubled, "grazing", 4.0739)
    assert 0 < abs(nearest(doubled, "doubling", grazing.parameter).parameter - grazing.parameter) < 1e-6
    assert_changes_are_listed(doubled)


def test_nothing_leaves_a_fold():
    with pytest.raises(BranchError, match="F1 is a fold: branches leave doublings"):
        continue_branch(branch_of(CAPTURED, "4.9:6 Hz"), switch="F1")
    with pytest.raises(BranchError, match="PD7 is not on this branch; its special points are NS1, F1"):
        continue_branch(branch_of(CAPTURED, "4.9:6 Hz"), switch="PD7")
