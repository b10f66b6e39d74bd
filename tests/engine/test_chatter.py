"""Energy and momentum across ends of infinite sequences of impacts: closed forms and sums of their hops."""

from math import sqrt

import numpy as np
import pytest
from mpmath import mp

from tests.engine.impacts import GRAVITY as G
from tests.engine.impacts import METHODS, column, scene, times
from tests.engine.runs import run
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    EVENT_KINDS,
    EXTENSION,
    GROUND,
    Body,
    Force,
    Friction,
    Harmonic,
    Motor,
    RigidStop,
    Scene,
)

RETURNED = 0.03  # of the last hops, which return within the rounding of displacements
WATCHED = 100  # roundings of displacements, within which impacts are found
everywhere = pytest.mark.parametrize("method", METHODS)


def ended(scene):
    """(totals, time of the only end of chatter [s]) of a run; the ledgers close to rounding."""
    result = run(scene, momentum=True)
    totals = result.totals
    (end,) = result.events["t"][result.events["kind"] == EVENT_KINDS["chatter"]]
    assert totals["chatters"] == totals["rests"] == 1 and totals["uncertified"] == 0
    for residual in ("energy_residual_relative", "momentum_residual_relative"):
        assert abs(totals[residual]) < 1e-14
    return totals, end


@everywhere
@pytest.mark.parametrize("e", (0.3, 0.5, 0.8, 0.95))
def test_a_ball_that_bounces_to_rest_leaves_all_its_energy_in_the_floor(method, e):
    """It lost m g h to the stop and m g t of momentum to the ground, at rest or not; sqrt(2 h / g) (1 + e) /
    (1 - e) after it was let go.
    """
    m, h, t_end = 2.0, 0.3, 12.0
    floor = RigidStop("floor", 0, GROUND, 0.0, EXTENSION, e)
    ball, weight = Body("ball", m, h, 0.0), Force("weight", 0, -m * G, ())
    scene = Scene((ball,), (), (floor,), (), (weight,), t_end=t_end, every_num=1, every_den=5, method=method)
    totals, end = ended(scene)
    rounding = 4 * totals["impacts"] * 2.0**-53  # of a sum of as many losses
    assert totals["loss.stops.floor"] == pytest.approx(m * G * h, rel=rounding)
    assert totals["work.forces.weight"] == pytest.approx(m * G * h, rel=rounding)
    assert totals["impulse.ground"] == pytest.approx(m * G * t_end, rel=rounding)
    assert totals["energy_end"] == totals["momentum_end"] == 0
    assert end + totals["chatter_time"] == pytest.approx(np.sqrt(2 * h / G) * (1 + e) / (1 - e), rel=rounding)
    assert totals["chatter_distance"] == pytest.approx(totals["chatter_speed"] ** 2 / (2 * G), rel=1e-6)
    assert m * totals["chatter_speed"] ** 2 / 2 < 2.0**-53 * m * G * h


@everywhere
def test_free_bodies_that_hop_on_each_other_lose_what_moved_them_apart(method):
    """Forces press two bodies onto each other, ground and base are far: the stop takes the energy of their
    relative motion, and momentum is that of the forces, as if nothing had been struck.
    """
    bodies = Body("a", 1.0, 0.0, 0.2), Body("b", 0.6, 0.01, 0.0)
    stop = RigidStop("between", 0, 1, 0.0, COMPRESSION, 0.5)
    forces = Force("left", 0, 2.0, ()), Force("right", 1, -1.5, ())
    scene = Scene(bodies, (), (stop,), (), forces, t_end=0.5, every_num=1, every_den=50, method=method)
    totals, _ = ended(scene)
    reduced, closing = 1.0 * 0.6 / 1.6, 2.0 / 1.0 + 1.5 / 0.6
    assert totals["loss.stops.between"] == pytest.approx(reduced * (0.2**2 / 2 + closing * 0.01), rel=1e-14)
    assert totals["momentum_end"] == pytest.approx(0.2 + 0.5 * 0.5, rel=1e-14)
    assert totals["impulse.ground"] == totals["impulse_base"] == 0


@everywhere
@pytest.mark.parametrize("e", (0.4, 0.8, 1.0))
def test_what_an_end_by_friction_leaves_out_is_bounded_in_the_ledgers(method, e):
    """Hops rise at F + N and return at F - N, each lower than the one before by e^2 (F - N) / (F + N). The
    end leaves out those below some 1e-14 m: the ledgers have the sums of all but for what `chatter_distance`
    says.
    """
    m, F, N, d = 0.5, 3.0, 0.5, 0.02
    stop, rub = RigidStop("wall", 0, GROUND, d, COMPRESSION, e), Friction("f", 0, GROUND, N, N, 0.0)
    scene = Scene(
        (Body("a", m, 0.0, 0.0),), (), (stop,), (rub,), (Force("F", 0, F, ()),),
        t_end=2.0, every_num=1, every_den=50, method=method,
    )  # fmt: skip
    totals, end = ended(scene)
    up, down = (F + N) / m, (F - N) / m
    approach, share = np.sqrt(2 * down * d), e * np.sqrt(down / up)
    heights = (e * approach) ** 2 / (2 * up) / (1 - share**2)  # of all hops
    w = e * approach * share ** (totals["impacts"] - 1)  # behind the last impact
    assert totals["chatter_speed"] == pytest.approx(w, rel=RETURNED)
    assert totals["chatter_distance"] == pytest.approx(totals["chatter_speed"] ** 2 / (2 * up), rel=1e-12)
    lasting = (w / up) * (1 + np.sqrt(up / down)) / (1 - share)
    assert totals["chatter_time"] == pytest.approx(lasting, rel=RETURNED)
    hops = e * approach / up * (1 + np.sqrt(up / down)) / (1 - share)
    assert end + lasting == pytest.approx(approach / down + hops, abs=RETURNED * lasting)
    left_out = 2 * (1 + 2 * RETURNED) * totals["chatter_distance"] / (1 - share**2)  # m, of the way
    rubbed = N * (d + 2 * heights)
    rounding = WATCHED * totals["impacts"] * 2.0**-53 * F * d
    assert 0 <= rubbed - totals["loss.friction.f"] + rounding <= N * left_out + 2 * rounding
    assert 0 <= totals["loss.stops.wall"] - (F * d - rubbed) + rounding <= F * left_out + 2 * rounding
    assert totals["energy_end"] == 0
    assert totals["impulse.ground"] == pytest.approx(-F * scene.t_end, rel=1e-14)


def hops_on_table(e, height, amplitude, omega):
    """(loss in stops per kg [J], impulse of the table per kg [N s], its work per kg [J], when the ball rests
    [s]) of a ball that is let go above a shaken table: flight by flight, in 40 digits.
    """
    with mp.workdps(40):
        e, g, height, a, omega = mp.mpf(e), mp.mpf(G), mp.mpf(height), mp.mpf(amplitude), mp.mpf(omega)

        def table(t):
            return a * mp.sin(omega * t), a * omega * mp.cos(omega * t)

        t, x, v = mp.mpf(0), height, mp.mpf(0)
        loss = impulse = work = mp.mpf(0)
        wait = mp.sqrt(2 * height / g)
        while True:
            for _ in range(60):  # Newton's method from beside the touch; the table is slower than the ball
                X, V = table(t + wait)
                step = (x + v * wait - g * wait**2 / 2 - X) / (v - g * wait - V)
                wait -= step
                if abs(step) < mp.mpf(10) ** -36:
                    break
            t, (x, V) = t + wait, table(t + wait)
            u = (v - g * wait) - V  # closing
            loss += (1 - e**2) * u**2 / 2
            impulse -= (1 + e) * u
            work -= (1 + e) * u * V
            v = V - e * u
            wait = 2 * (-e * u) / (g - a * omega**2 * mp.sin(omega * t))
            if wait < mp.mpf(10) ** -30:
                return loss, impulse, work, t


@everywhere
@pytest.mark.parametrize(("e", "height"), ((0.4, 0.05), (0.7, 0.013)))
def test_a_ball_comes_to_rest_on_a_shaken_table(method, e, height):
    """A omega^2 < g: it stays. Impulse and work of the table from then on are those that carry it."""
    m, amplitude, cycles, t_end = 0.7, 2e-3, 7.0, 2.0
    omega = 2 * np.pi * cycles
    base = (Harmonic(amplitude, omega, cycles, 0.0, 0.0),)
    table = RigidStop("table", 0, BASE, 0.0, EXTENSION, e)
    ball, weight = Body("ball", m, height, 0.0), Force("weight", 0, -m * G, ())
    scene = Scene(
        (ball,), (), (table,), (), (weight,), base, t_end=t_end, every_num=1, every_den=50, method=method
    )
    totals, end = ended(scene)
    loss, impulse, work, rests = hops_on_table(e, height, amplitude, omega)
    assert end == pytest.approx(float(rests), rel=1e-14)
    (X, V), (X_end, V_end) = (
        (amplitude * mp.sin(omega * t), amplitude * omega * mp.cos(omega * t)) for t in (rests, t_end)
    )
    impulse += G * (t_end - rests) + V_end - V
    work += G * (X_end - X) + (V_end**2 - V**2) / 2
    assert totals["loss.stops.table"] == pytest.approx(float(m * loss), rel=1e-13)
    assert totals["impulse_base"] == pytest.approx(float(m * impulse), rel=1e-13)
    assert totals["work_base"] == pytest.approx(float(m * work), abs=1e-13 * m * G * height)
    assert totals["work.forces.weight"] == pytest.approx(float(m * G * (height - X_end)), rel=1e-13)


# Ends of infinite sequences of impacts that friction or a rotor takes part in, by closed forms.


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
    found = run(of, most=1000)
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
    found = run(carried(1.0, 1.0, 1.0, 0.5, 1.0, method), most=500)
    left_out = found.totals["chatter_time"]
    assert left_out < 1e-5
    assert times(found, "rest_begin") + left_out == pytest.approx([1 + sqrt(3)], abs=0.02 * left_out)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)


@pytest.mark.parametrize(("e", "m", "F"), ((0.05, 0.01, 0.05), (0.2, 0.1, 1.0), (0.2, 0.01, 1.0)))
def test_hops_in_which_a_light_body_is_caught_end_certified(e, m, F):
    """It slips faster than four times the speed of the hop, and comes to rest on the other within it."""
    found = run(carried(1.0, e, m, 0.5, F, "auto"), most=500)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)
