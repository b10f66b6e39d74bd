"""Chains that touch a stop while they rest, shaken or pushed at their other end: at the start as many
derivatives of the touch are zero as twice the bodies between.
"""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from tests.events.special_scenes import harmonic
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Force,
    Friction,
    Link,
    RigidStop,
    Scene,
    Stop,
)

K, OMEGA = 87.3, 7.0
APART = (
    1e-13  # m; behind such a gap the same motion takes an impact or a contact more, and no start is special
)


def chain(count, law, sense, driven_by):
    """A chain of `count` bodies of 1 kg, the last of which touches the ground; the first is driven."""
    bodies = tuple(Body(f"b{i}", 1.0, 0.0, 0.0) for i in range(count))
    first = BASE if driven_by == "base" else GROUND
    links = tuple(Link(f"l{i}", i, i - 1 if i else first, K, 0.0) for i in range(count))
    if law == "rigid":
        stop = RigidStop("stop", count - 1, GROUND, 0.0, sense, 0.5, True)
    else:
        stop = Stop("stop", count - 1, GROUND, 0.0, sense, K, 0.0, at_start=True)
    forces = (Force("push", 0, 1.0, ()),) if driven_by == "force" else ()
    base = (harmonic(0.02, OMEGA, 0.0),) if driven_by == "base" else ()
    return Scene(bodies, links, (stop,), (), forces, base, t_end=2.0, every_num=1, every_den=50)


def run(scene):
    """Totals, and displacements of the last body [m]."""
    trajectory = open_trajectory(scene)
    column = f"x_{scene.bodies[-1].name}"
    x = np.concatenate([block.samples[column] for block in trajectory.blocks()])
    return trajectory.totals, x


@pytest.mark.parametrize("method", ["auto", "taylor"])
@pytest.mark.parametrize("places", list(permutations(range(3))), ids=str)
def test_a_row_that_touches_is_pressed_together_in_whatever_order_its_stops_are_given(places, method):
    """A force on the first of three bodies: the others close their stops behind it, as t^4 and as t^6. Where
    one of these was named before the one that presses it, the body went through it, in a certified run.
    """
    bodies = tuple(Body(f"b{i}", 1.0, 0.0, 0.0) for i in range(3))
    stiff = (64.0, 300.0, 3000.0)
    row = [
        Stop(f"s{i}", i, i + 1 if i < 2 else GROUND, 0.0, COMPRESSION, stiff[i], 0.0, at_start=True)
        for i in range(3)
    ]
    stops = tuple(row[i] for i in places)
    push = (Force("push", 0, 1.0, ()),)
    scene = Scene(bodies, (), stops, (), push, t_end=0.5, every_num=1, every_den=50, method=method)
    totals, x = run(scene)
    matrix = np.diag([stiff[0], stiff[0] + stiff[1], stiff[1] + stiff[2]])
    matrix[[0, 1, 1, 2], [1, 0, 2, 1]] = -np.array(stiff)[[0, 0, 1, 1]]
    squares, modes = np.linalg.eigh(matrix)
    t = np.arange(26)[:, np.newaxis] / 50
    last = (1 - np.cos(np.sqrt(squares) * t)) / squares @ (modes[0] * modes[2])
    assert (totals["events"], totals["uncertified"]) == (0, 0)
    assert abs(x - last).max() < 1e-15


@pytest.mark.parametrize("driven_by", ["base", "force"])
@pytest.mark.parametrize("sense", [EXTENSION, COMPRESSION])
@pytest.mark.parametrize("law", ["elastic", "rigid"])
@pytest.mark.parametrize("count", [2, 3, 5, pytest.param(8, marks=pytest.mark.slow)])
def test_a_chain_leaves_or_presses_the_stop_that_it_touches(count, law, sense, driven_by):
    """By the closed form from order 6 on events of that stop were not looked for, in certified runs."""
    scene = chain(count, law, sense, driven_by)
    totals, x = run(scene)
    rests = law == "rigid" and (count, driven_by) == (2, "force")  # its force is zero once a period
    assert rests or totals["uncertified"] == 0
    gap = scene.stops[0].gap + APART
    _, beside = run(replace(scene, stops=(replace(scene.stops[0], gap=gap, at_start=False),)))
    _, by_series = run(replace(scene, method="taylor"))
    assert abs(x - beside).max() < 10 * APART
    assert abs(x - by_series).max() < 1e-15
    assert abs(x).max() > 1e-4 or rests or (law, sense) == ("rigid", COMPRESSION)


def struck(count, law, sense, hit):
    """A chain at rest, the last of whose bodies touches the ground; a body flies at the first."""
    scene = chain(count, law, sense, "nothing")
    bodies = (*scene.bodies[:-1], Body("hammer", 1.0, -0.1, 1.0), scene.bodies[-1])
    last = len(bodies) - 1
    links = tuple(
        replace(link, P=last if count - 1 == link.P else link.P, name=link.name) for link in scene.links
    )
    if hit == "rigid":
        blow = RigidStop("blow", count - 1, 0, 0.0, COMPRESSION, 0.8, False)
    else:
        blow = Stop("blow", count - 1, 0, 0.0, COMPRESSION, 1e4, 0.0)
    return replace(scene, bodies=bodies, links=links, stops=(blow, replace(scene.stops[0], P=last)))


@pytest.mark.parametrize("hit", ["elastic", "rigid"])
@pytest.mark.parametrize("sense", [EXTENSION, COMPRESSION])
@pytest.mark.parametrize("law", ["elastic", "rigid"])
@pytest.mark.parametrize("count", [3, 4, 6])
def test_a_chain_that_is_struck_leaves_or_presses_the_stop_that_it_touches(count, law, sense, hit):
    """Behind the blow, too, rounding of modal coordinates stood in for derivatives that are zero: runs ended
    with an error, or took up to a thousand events too many.
    """
    scene = struck(count, law, sense, hit)
    totals, x = run(scene)
    blow, wall = scene.stops
    _, beside = run(replace(scene, stops=(blow, replace(wall, gap=wall.gap + APART, at_start=False))))
    by_series, x_by_series = run(replace(scene, method="taylor"))
    assert totals["events"] == by_series["events"] and totals["uncertified"] <= 2
    assert abs(x - beside).max() < 50 * APART
    assert abs(x - x_by_series).max() < 3e-15


@pytest.mark.parametrize("order", [4, 6, 20])
def test_few_terms_of_a_series_hold_no_known_zero(order):
    """The zero is of an order beyond the last of the series."""
    scene = replace(chain(3, "elastic", EXTENSION, "base"), method="taylor", order=order, t_end=0.9)
    totals, x = run(scene)
    _, true = run(chain(3, "elastic", EXTENSION, "base"))
    assert totals["impacts"] == 1
    assert abs(x - true[: len(x)]).max() < 1e-12


def test_a_body_struck_as_the_run_begins_leaves_the_neighbour_that_it_touches():
    """The touch of the two was still taken for one without velocity, and by the closed form no event of the
    whole run was found.
    """
    stops = (
        RigidStop("between", 0, 2, 0.0, EXTENSION, 0.0, True),
        RigidStop("box", 0, BASE, 0.0, 1, 0.5, True),
    )
    scene = Scene(
        tuple(Body(f"b{i}", 1.0, 0.0, 0.0) for i in range(3)),
        (Link("l0", 0, BASE, 100.0, 2.0), Link("l1", 1, 0, 100.0, 0.0), Link("l2", 2, 1, 100.0, 2.0)),
        stops,
        (Friction("floor", 1, GROUND, 0.3, 0.3, 0.0),),
        (),
        (harmonic(0.02, 9.344, 0.0),),
        t_end=2.0,
        every_num=1,
        every_den=50,
    )
    totals, x = run(scene)
    by_series, x_by_series = run(replace(scene, method="taylor"))
    assert (totals["events"], totals["uncertified"]) == (by_series["events"], 0)
    assert totals["impacts"] == by_series["impacts"] > 5
    assert abs(x - x_by_series).max() < 1e-14


def standing(masses, base, links, stops, **parts):
    """Bodies that stand, some of them by a shaken base."""
    bodies = tuple(Body(f"b{i}", m, 0.0, 0.0) for i, m in enumerate(masses))
    shaken = (harmonic(0.02, base, 0.0),)
    return Scene(bodies, links, stops, base=shaken, t_end=2.0, every_num=1, every_den=50, **parts)


STRUCK_SOFTLY = standing(
    (0.5, 1.0, 1.0), 7.0,
    (Link("l0", 0, BASE, 64.0, 0.0), Link("l2", 2, 1, 64.0, 0.0)),
    (Stop("wall", 1, GROUND, 0.0, COMPRESSION, 64.0, 0.0, at_start=True),
     Stop("blow", 0, 1, 0.0, EXTENSION, 64.0, 0.0, at_start=True)),
    frictions=(Friction("f", 0, GROUND, 0.3, 0.3, 0.0),),
)  # fmt: skip
TORN_SOFTLY = standing(
    (1.0, 1.0, 1.0, 1.0, 1.0), 5.0,
    tuple(Link(f"l{P}", P, Q, 100.0, 0.0) for P, Q in ((0, BASE), (1, 0), (3, 2), (4, 3))),
    (RigidStop("touch", 3, 4, 0.0, EXTENSION, 0.8, True),
     Stop("wall", 1, GROUND, 0.0, EXTENSION, 3000.0, 0.0, at_start=True),
     Stop("blow", 1, 2, 0.01, COMPRESSION, 3000.0, 0.0)),
    frictions=(Friction("f", 0, GROUND, 0.3, 0.3, 0.0),),
    forces=(Force("push", 0, 0.0, (harmonic(2.0, 5.0, 0.0),)),),
)  # fmt: skip
RELIEVED_AT_ONCE = standing(
    (0.5, 1.0), 9.344,
    (Link("l0", 0, BASE, 87.3, 0.0), Link("l1", 1, 0, 87.3, 1.746)),
    (Stop("soft", 0, GROUND, 0.0, EXTENSION, 3000.0, 0.0, at_start=True),
     RigidStop("wall", 1, GROUND, 0.0, COMPRESSION, 0.0, True),
     RigidStop("pair", 0, 1, 0.0, COMPRESSION, 0.8, True)),
)  # fmt: skip


@pytest.mark.parametrize("scene", [STRUCK_SOFTLY, TORN_SOFTLY, RELIEVED_AT_ONCE])
def test_what_stood_at_zero_is_set_into_motion_by_a_later_derivative(scene):
    """A contact or a release elsewhere begins with the rounding of where it was met: the derivative before
    the one that moves what stood is rounding, by which ends closed and parted 64 times at one instant.
    """
    _, x = run(scene)
    _, by_series = run(replace(scene, method="taylor"))
    assert abs(x - by_series).max() < 1e-15
