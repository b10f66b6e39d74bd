"""Rigid impacts of a body that carries a motor, and of several bodies at once, drawn at random, in 40 digits:
events, ends of chatter, states and displacements of certified runs.
"""

import random

import pytest

from tests.engine.runs import run
from tests.events.struck import at_once, with_motor
from tests.events.whole_runs import in_batches, judge, wrong_by_digits

pytest.importorskip("flint")


def test_a_motor_under_rigid_impacts():
    judge(wrong_by_digits, with_motor, range(6, 16))


def test_several_bodies_struck_at_once():
    judge(wrong_by_digits, at_once, range(10))


def test_bodies_between_which_no_force_acts_go_on_side_by_side():
    """Two of 0.5 kg that rub alike slide on together; what rounding leaves between them ended their rest and
    began it again 64 times at one instant.
    """
    totals = run(at_once(random.Random(283))).totals
    assert totals["uncertified"] > 0
    assert totals["events"] < 2000


def test_a_rest_whose_force_only_grazes_zero_goes_on():
    """Behind a plastic blow the force between two of a row is 0 and its rate -4e-16 N/s, where rounding can
    make 6e-14, while it rises by 2 t^2 N/s^2: that rate ended the rest 64 times at one instant.
    """
    assert run(at_once(random.Random(219))).totals["uncertified"] > 0


@pytest.mark.slow
@pytest.mark.timeout(3600)
@in_batches(range(1000), 100)
def test_a_motor_under_many_rigid_impacts(seeds):
    judge(wrong_by_digits, with_motor, seeds)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@in_batches(range(2000), 250)
def test_several_bodies_struck_at_once_often(seeds):
    judge(wrong_by_digits, at_once, seeds)
