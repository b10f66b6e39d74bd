"""Ends of infinite sequences of impacts that friction or a rotor takes part in, by closed forms."""

from math import sqrt

import numpy as np
import pytest

from tests.engine.impacts import METHODS, column, scene, times
from tests.engine.runs import run
from vibsim.physics.parts import COMPRESSION, GROUND, Body, Force, Friction, Motor, RigidStop, Scene


@pytest.mark.parametrize("wall", (False, True))
def test_rotor_takes_part_in_the_end_of_chatter(wall):
    """Friction ends the hops at some 1e-7 m/s, which come to rest: the momentum of the line is kept, or the
    wall takes it (no ledger has what chatter left out), and that of the rotor's angle is kept.
    """
    m, m3, e, J = 0.3, 0.14, 0.02, 2.4e-4
    bodies = [Body("a", m, 0.0, -0.2), Body("b", 0.31, 0.0, 0.3)]
    forces = (Force("A", 0, 1.0, ()), Force("B", 1, 0.0 if wall else -1.0, ()))
    result = run(
        scene(
            bodies,
            stops=(RigidStop("face", 0, GROUND if wall else 1, 0.01, COMPRESSION, 0.5),),
            frictions=(Friction("rub", 0, GROUND if wall else 1, 0.1, 0.1, 0.0),),
            forces=forces,
            motor=Motor(0, m3, e, J, 0.007, 20.0, 1.0, 15.0),
            t_end=0.6,
        ),
        momentum=True,
    )
    ends = {name: column(result, "chatter", name) for name in result.events}
    assert len(ends["t"])
    speed = np.abs(ends["before_v_a"] - (0.0 if wall else ends["before_v_b"]))
    assert (speed > 1e-8).all()  # large against rounding
    inertia, coupling = J + m3 * e * e, m3 * e * np.sin(ends["phase"])
    before, after = (
        inertia * ends[w] - coupling * ends[v]
        for w, v in (("before_phidot", "before_v_a"), ("phidot", "v_a"))
    )
    assert after == pytest.approx(before, abs=1e-15 * inertia * 20)
    assert wall or abs(result.totals["momentum_residual_relative"]) < 1e-14


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("x", (0.0, 1e-12, 1e-6, 0.00675, 1.0))
def test_chatter_under_friction_ends_and_tells_what_it_left_out(x, method):
    """A body pressed to a wall by F, rubbing with N: it rises against a = (F + N) / m, returns with
    b = (F - N) / m, so speeds shrink by q = e sqrt(b / a), and rest begins after
    e v (1 / a + 1 / sqrt(a b)) / (1 - q). Rounding of x hides the last hops; at x = 0 there is none, and by
    Taylor series returns were 1e-9 s late in hops lower than 1e-15 of the way of the step that they were in.
    Closed form finds returns within 32 roundings of x, in hops of 1024 or more: that is 32 / (4 * 1024) of
    the last hop's time, and 1 / (1 - q) = 2.2 times that of all.
    """
    F, N, m, v, e = 0.9, 0.32, 0.57, 0.04, 0.8
    of = Scene(
        (Body("b", m, x, v),),
        stops=(RigidStop("wall", 0, GROUND, x, COMPRESSION, e, True),),
        frictions=(Friction("f", 0, GROUND, N, N, 0.0),),
        forces=(Force("F", 0, F, ()),),
        t_end=1.0,
        method=method,
    )
    found = run(of, "c", most=1000)
    a, b = (F + N) / m, (F - N) / m
    expected = e * v * (1 / a + 1 / sqrt(a * b)) / (1 - e * sqrt(b / a))
    left_out = found.totals["chatter_time"]
    unit = np.spacing(expected)
    late = left_out * (0.01 if method == "taylor" else 0.01 + 2.2 * 32 / (4 * 1024))
    assert times(found, "rest_begin") + left_out == pytest.approx([expected], abs=late + 16 * unit)
    assert 0 < left_out < 10 * sqrt(2 * 1024 * 2.0**-53 * 2 * x / a) + 16 * unit
    assert found.totals["uncertified"] == 0


def carried(x, e, m, mu, F, method):
    """A body of 1 kg that hops on the ground at x, with 1 m/s at first, and one of m rubbing on it (4 N, mu)
    that a force F presses down.
    """
    return Scene(
        (Body("a", 1.0, x, -1.0), Body("b", m, x, -1.0)),
        stops=(RigidStop("floor", GROUND, 0, -x, COMPRESSION, e, True),),
        frictions=(Friction("f", 0, 1, 4 * mu, 4 * mu, 0.0),),
        forces=(Force("F", 1, -F, ()),),
        t_end=10.0,
        method=method,
    )


@pytest.mark.parametrize("method", METHODS)
def test_hops_that_a_friction_stops_on_their_way_end_without_loss_in_the_stop(method):
    """Two equal bodies rub with 2 N, 1 N presses down: the lower one hops against 2 m/s^2, both come to rest
    on each other after 2 w / 3, at the height 2 w^2 / 9, and fall with w / 3 and 1/2 m/s^2: they strike at
    w / sqrt 3, and the sequence ends after 1 + sqrt 3 of its first speed. With e = 1 it went on by rounding.
    """
    found = run(carried(1.0, 1.0, 1.0, 0.5, 1.0, method), "c", most=500)
    left_out = found.totals["chatter_time"]
    assert left_out < 1e-5
    assert times(found, "rest_begin") + left_out == pytest.approx([1 + sqrt(3)], abs=0.02 * left_out)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)


@pytest.mark.parametrize(("e", "m", "F"), ((0.05, 0.01, 0.05), (0.2, 0.1, 1.0), (0.2, 0.01, 1.0)))
def test_hops_in_which_a_light_body_is_caught_end_certified(e, m, F):
    """It slips faster than four times the speed of the hop, and comes to rest on the other within it."""
    found = run(carried(1.0, e, m, 0.5, F, "auto"), "c", most=500)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)
