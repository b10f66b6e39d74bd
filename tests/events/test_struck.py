"""Rigid impacts of a body that carries a motor, and of several bodies at once, drawn at random, in 40 digits:
events, ends of chatter, states and displacements of certified runs.
"""

import random

import pytest

from tests.events.struck import at_once, with_motor
from tests.events.whole_runs import judge, wrong_by_digits

pytest.importorskip("flint")


def draws(make, seeds):
    return (make(random.Random(seed)) for seed in seeds)


def test_a_motor_under_rigid_impacts():
    judge(wrong_by_digits, draws(with_motor, range(6)))


def test_several_bodies_struck_at_once():
    judge(wrong_by_digits, draws(at_once, range(10)))


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_a_motor_under_many_rigid_impacts():
    judge(wrong_by_digits, draws(with_motor, range(1000)))


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_several_bodies_struck_at_once_often():
    judge(wrong_by_digits, draws(at_once, range(2000)))
