"""Scenes of kinds that random numbers hardly make: events and motions by closed form, by Taylor series and,
where these differ or at once, in 40 digits; and single ones of them.
"""

import math
import random

import pytest

from tests.engine.impacts import ball
from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run, scene_of
from tests.events.special_scenes import at_once, chain, oddity, with_motor
from tests.events.whole_runs import finished, judge, settled_until, wrong_by_digits, wrong_by_series

FEW = [
    (wrong_by_series, oddity, range(459, 509)),
    (wrong_by_digits, oddity, range(2001, 2005)),
    (wrong_by_series, chain, range(100)),
    (wrong_by_digits, with_motor, range(6, 16)),
    (wrong_by_digits, at_once, range(10)),
]
MANY = [  # and how many of them at a time
    (wrong_by_series, oddity, range(800), 100),
    (wrong_by_digits, oddity, range(2000, 2080), 80),
    (wrong_by_series, chain, range(3000), 250),
    (wrong_by_digits, with_motor, range(1000), 100),
    (wrong_by_digits, at_once, range(2000), 250),
]
BATCHES = [(*what, seeds[i : i + n]) for *what, seeds, n in MANY for i in range(0, len(seeds), n)]


def name(value):
    return getattr(value, "__name__", str(value))


@pytest.mark.parametrize(("wrong", "make", "seeds"), FEW, ids=name)
def test_special_scenes(wrong, make, seeds):
    judge(wrong, make, seeds)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize(("wrong", "make", "seeds"), BATCHES, ids=name)
def test_many_special_scenes(wrong, make, seeds):
    judge(wrong, make, seeds)


def test_bodies_between_which_no_force_acts_go_on_side_by_side():
    """Two of 0.5 kg that rub alike slide on together, but for what rounding leaves between them."""
    totals = run(at_once(random.Random(283))).totals
    assert totals["uncertified"] > 0
    assert totals["events"] < 2000


def test_a_rest_whose_force_only_grazes_zero_goes_on():
    """Behind a plastic blow the force between two is 0, its rate rounding; it rises by 2 t^2 N/s^2."""
    assert run(at_once(random.Random(219))).totals["uncertified"] > 0


def test_a_last_hop_against_forces_that_cancel_leaves_out_a_known_time():
    """Friction holds a within the hop, and b goes on under forces whose sum is 0 but for the radius of its
    number: dividing by that, what the hop left out was no number in 40 digits, and the run had no totals.
    """
    scene = scene_of("""
bodies: {a: 0.25 kg, b: 1 kg}
stops: {s: {between: [a, b], gap: 0 m, acts: compression, law: rigid, e: 0.75}}
friction: {f: {between: [a, ground], N: 0.25 N, mu: 1}}
forces:
  to: {on: b, A: 1 N, omega: 5 rad/s, phase: 1 rad}
  fro: {on: b, A: -1 N, omega: 5 rad/s, phase: 1 rad}
initial: {a: {x: 1 m, v: 1e-100 m/s}, b: {x: 1 m}}
run: {t_end: 0.1 s, every: 20 ms}
""")
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
    of_one = ball(0.5, 0.1, t_end=1)
    assert settled_until(of_one, finished(of_one)) == math.inf
