"""Special points against 22 digits of them, and what is known of the branches that they lie on."""

import numpy as np
import pytest

from tests.branches.made import (
    CAPTURED,
    PERIOD_5,
    RESONANT,
    assert_changes_are_listed,
    branch_of,
    nearest,
    parameter,
)
from tests.orbits.truths import TRUTHS
from vibsim.orbits.branches.inspection import inspect
from vibsim.orbits.branches.node import Node
from vibsim.orbits.words import cyclic

LOWER = "3.47:3.53 Hz"
# truth, branch, its span, kind
POINTS = [
    ("I-A n=5 isola fold", PERIOD_5, LOWER, "fold"),
    ("I-A n=5 isola PD", PERIOD_5, LOWER, "doubling"),
    ("I-A n=5 grazing rsurrbrerrrrrbrerr>rsurberbrerrrrrbrerr", PERIOD_5, LOWER, "grazing"),
    ("I-C n=1 PD", RESONANT, "3.8:6.6 Hz", "doubling"),
    ("II-B c=0.03 captured branch NS", CAPTURED, "4.9:6 Hz", "neimark-sacker"),
    ("II-B c=0.03 captured branch fold", CAPTURED, "4.9:6 Hz", "fold"),
]


@pytest.mark.parametrize(("name", "through", "span", "kind"), POINTS)
def test_special_points(name, through, span, kind):
    """To 1e-11 of the parameter, as asked; 1e-13 of it is what rounding of the map leaves at the worst."""
    of, value = TRUTHS[name], parameter(name)
    special = nearest(branch_of(through, span), kind, value)
    assert special.parameter == pytest.approx(value, rel=1e-13 if kind != "neimark-sacker" else 1e-12)
    assert special.period == pytest.approx(of.period, rel=1e-11)
    scale = np.abs(of.unknowns).max()
    np.testing.assert_allclose(special.orbit.state, of.unknowns, rtol=0, atol=1e-7 * scale)


def test_the_saddle_on_the_captured_branch():
    """The branch goes on beyond its fold: at 5 Hz it passes the known saddle."""
    of = TRUTHS["II-B c=0.03 saddle on the captured branch, n=1"]
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    distance = np.abs(branch["parameter"] - 5) + 10 * (branch["index"] == 0)
    i = int(np.argmin(distance))
    assert branch["index"][i] == 1 and distance[i] < 0.2
    assert cyclic(branch.points[i].orbit.word) == branch.specials[-1].orbit.word
    assert abs(branch["phidot"][i] - of.unknowns[-1]) < 0.2


def test_the_neimark_sacker_point_before_the_fold():
    """8e-5 Hz apart: what the ends of one step do not tell, the index check finds."""
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    kinds = [one.kind for one in branch.specials]
    assert kinds == ["neimark-sacker", "fold"]
    assert [one.jump for one in branch.specials] == [2, -1]
    torus, fold = branch.specials
    assert branch["stable"][: torus.between[1]].all() and not branch["stable"][fold.between[1] :].any()
    family = branch.plan.family()
    ends = [branch.points[i] for i in (torus.between[0], fold.between[1])]
    one, other = (Node.of(family(np.array(p.unknowns)), np.array(p.tangent), 0) for p in ends)
    within = [each.node.parameter for each in inspect(family, one, other)]  # one step over both of them
    assert within == pytest.approx([torus.parameter, fold.parameter], rel=1e-11)


@pytest.mark.parametrize(
    ("name", "span"), [(CAPTURED, "4.9:6 Hz"), (PERIOD_5, LOWER), (RESONANT, "3.8:6.6 Hz")]
)
def test_between_two_points_the_index_changes_by_what_is_listed(name, span):
    assert_changes_are_listed(branch_of(name, span))


def test_words_change_where_it_is_listed():
    branch = branch_of(PERIOD_5, LOWER)
    for i, (before, after) in enumerate(zip(branch.points, branch.points[1:], strict=False)):
        words = [before.orbit.word]
        for special in branch.specials:
            if special.between == (i, i + 1) and special.before != special.after:
                assert special.before == words[-1]
                words.append(special.after)
        assert words[-1] == after.orbit.word


def test_points_are_orbits_of_equal_residual():
    branch = branch_of(PERIOD_5, LOWER)
    assert branch["residual"].max() < 1e-12
    assert (np.diff(branch["arclength"]) > 0).all()


@pytest.mark.slow
def test_the_isola_closes():
    """I-A's orbits of five periods form a closed curve, stable between a doubling and a fold, and between
    another such pair within 2e-7 Hz.
    """
    branch = branch_of(PERIOD_5, "3:4 Hz")
    assert branch.closed and branch.ends == ("closed", "closed")
    fold = nearest(branch, "fold", 3.5188)
    doubling = nearest(branch, "doubling", 3.4835)
    assert branch["parameter"].max() <= fold.parameter and branch["parameter"].min() > 3.2172
    values = branch["parameter"][branch["stable"]]
    inside = (values > doubling.parameter) & (values < fold.parameter)
    lower = [one for one in branch.specials if abs(one.parameter - 3.2172413) < 2e-7]
    assert inside.sum() > 5 and (inside | (abs(values - 3.2172413) < 2e-7)).all()
    assert {"fold", "grazing", "doubling"} <= {one.kind for one in lower}


def test_the_top_of_a_resonance_is_followed_in_some_hundred_points():
    """I-C: an orbit of 90 m/s, where a billionth of the frequency turns its phase; it folds there, and the
    branch goes back and on to the end of the range.
    """
    branch = branch_of(RESONANT, "5:8 Hz")
    assert branch.ends == ("end of the range", "end of the range")
    assert len(branch) < 600 and branch["v1"].max() > 80
    assert [one.kind for one in branch.specials[:1]] == ["fold"]
    assert branch.specials[0].jump == 1 and "unresolved" not in {one.kind for one in branch.specials}
