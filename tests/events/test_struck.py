"""Rigid impacts of a body that carries a motor, and of several bodies at once, drawn at random, in 40 digits:
events, ends of chatter, states and displacements of certified runs.
"""

import math
import random

import pytest

from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run
from tests.events.coincidences import harmonic
from tests.events.struck import at_once, with_motor
from tests.events.whole_runs import finished, in_batches, judge, settled_until, wrong_by_digits
from vibsim.physics.parts import COMPRESSION, EXTENSION, GROUND, Body, Force, Friction, RigidStop, Scene


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


def test_a_last_hop_against_forces_that_cancel_leaves_out_a_known_time():
    """Friction holds a within the hop, and b goes on under forces whose sum is 0 but for the radius of its
    number: dividing by that, what the hop left out was no number in 40 digits, and the run had no totals.
    """
    forces = tuple(Force(name, 1, 0.0, (harmonic(A, 5.0, 1.0),)) for name, A in (("to", 1.0), ("fro", -1.0)))
    scene = Scene(
        (Body("a", 0.25, 1.0, 1e-100), Body("b", 1.0, 1.0, 0.0)),
        (),
        (RigidStop("s", 0, 1, 0.0, COMPRESSION, 0.75, True),),
        (Friction("f", 0, GROUND, 0.25, 0.25, 0.0),),
        forces,
        t_end=0.1,
        every_num=1,
        every_den=50,
    )
    for totals in (run(scene).totals, truth(exact_parts(scene), 40)[-1]):
        assert totals["rests"] == 1
        assert totals["chatter_time"] == pytest.approx(2 * 0.75e-100 / 1.0 / (1 - 0.75), rel=1e-14)


def test_rounding_orders_hops_on_two_stops_shortly_before_they_end():
    """A certified run in doubles strikes stop 1 at 0.39227565 s once more than 40 digits do: from 1e-16 at
    the start errors have grown to a tenth of a hop there. So they have where times of events are moved by
    one unit in the last place. A single ball's hops keep their order.
    """
    scene = at_once(random.Random(983))
    run = finished(scene)
    assert run.totals["uncertified"] == 0
    assert 0.392 < settled_until(scene, run) < 0.3922713
    ball = Scene(
        (Body("ball", 1.0, 0.1, 0.0),),
        (),
        (RigidStop("floor", 0, GROUND, 0.0, EXTENSION, 0.5),),
        (),
        (Force("weight", 0, -9.81, ()),),
        t_end=1.0,
        every_num=1,
        every_den=50,
    )
    assert settled_until(ball, finished(ball)) == math.inf


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
