"""Energy and momentum across ends of infinite sequences of impacts: closed forms and sums of their hops."""

from math import sqrt

import numpy as np
import pytest
from mpmath import mp

from tests.engine.impacts import GRAVITY as G
from tests.engine.impacts import METHODS, column, times
from tests.engine.runs import run, scene_of

RETURNED = 0.03  # of the last hops, which return within the rounding of displacements
WATCHED = 100  # roundings of displacements, within which impacts are found
everywhere = pytest.mark.parametrize("method", METHODS)


def ended(scene):
    """(totals, time of the only end of chatter [s]) of a run; the ledgers close to rounding."""
    result = run(scene, momentum=True)
    totals = result.totals
    (end,) = times(result, "chatter")
    assert totals["chatters"] == totals["rests"] == 1 and totals["uncertified"] == 0
    for residual in ("energy_residual_relative", "momentum_residual_relative"):
        assert abs(totals[residual]) < 1e-14
    return totals, end


PRESSED = """
bodies: {a: 1 kg, b: 0.6 kg}
stops: {between: {between: [a, b], gap: 0 m, acts: compression, law: rigid, e: 0.5}}
forces: {left: {on: a, F0: 2 N}, right: {on: b, F0: -1.5 N}}
initial: {a: {v: 0.2 m/s}, b: {x: 1 cm}}
run: {t_end: 0.5 s, every: 20 ms}
"""


@everywhere
def test_free_bodies_that_hop_on_each_other_lose_what_moved_them_apart(method):
    """The stop takes the energy of their relative motion; momentum is that of the forces on both."""
    totals, _ = ended(scene_of(PRESSED, method=method))
    reduced, closing = 1.0 * 0.6 / 1.6, 2.0 / 1.0 + 1.5 / 0.6
    assert totals["loss.stops.between"] == pytest.approx(reduced * (0.2**2 / 2 + closing * 0.01), rel=1e-14)
    assert totals["momentum_end"] == pytest.approx(0.2 + 0.5 * 0.5, rel=1e-14)
    assert totals["impulse.ground"] == totals["impulse_base"] == 0


# A force presses a body that rubs on the ground to a wall.
RUBBING = """
bodies: {a: 0.5 kg}
stops: {wall: {between: [a, ground], gap: 2 cm, acts: compression, law: rigid, e: 0.8}}
friction: {f: {between: [a, ground], N: 0.5 N, mu: 1}}
forces: {F: {on: a, F0: 3 N}}
run: {t_end: 2 s, every: 20 ms}
"""


@everywhere
@pytest.mark.parametrize("e", (0.4, 0.8, 1.0))
def test_what_an_end_by_friction_leaves_out_is_bounded_in_the_ledgers(method, e):
    """Hops rise at F + N and return at F - N, each lower than the one before by e^2 (F - N) / (F + N). The
    end leaves out those below some 1e-14 m: the ledgers have the sums of all but for what `chatter_distance`
    says.
    """
    m, F, N, d = 0.5, 3.0, 0.5, 0.02
    totals, end = ended(scene_of(RUBBING, {"wall.e": e}, method=method))
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
    assert totals["impulse.ground"] == pytest.approx(-F * 2.0, rel=1e-14)


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


ON_TABLE = """
bodies: {ball: 0.7 kg}
stops: {table: {between: [ball, base], gap: 0 m, acts: extension, law: rigid, e: 0}}
forces: {weight: {on: ball, F0: -6.867 N}}
base: {a: 2 mm, omega: 7 Hz}
run: {t_end: 2 s, every: 20 ms}
"""


@everywhere
@pytest.mark.parametrize(("e", "height"), ((0.4, 0.05), (0.7, 0.013)))
def test_a_ball_comes_to_rest_on_a_shaken_table(method, e, height):
    """A omega^2 < g: it stays. Impulse and work of the table from then on are those that carry it."""
    m, amplitude, t_end, omega = 0.7, 2e-3, 2.0, 2 * np.pi * 7.0
    totals, end = ended(scene_of(ON_TABLE, {"table.e": e, "ball.x": height}, method=method))
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


TURNING = """
bodies: {a: 0.3 kg, b: 0.31 kg}
stops: {face: {between: [a, FACE], gap: 1 cm, acts: compression, law: rigid, e: 0.5}}
friction: {rub: {between: [a, FACE], N: 0.1 N, mu: 1}}
forces: {A: {on: a, F0: 1 N}, B: {on: b, F0: -1 N}}
motor: {on: a, m3: 0.14 kg, e: 2 cm, J: 2.4e-4 kg m^2, M0: 0.007 N m, Omega0: 20 rad/s}
initial: {a: {v: -0.2 m/s}, b: {v: 0.3 m/s}, motor: {phi: 1 rad, phidot: 15 rad/s}}
run: {t_end: 0.6 s, every: 250 ms}
"""


@pytest.mark.parametrize("wall", (False, True))
def test_rotor_takes_part_in_the_end_of_chatter(wall):
    """Friction ends the hops at some 1e-7 m/s: momenta of the line and of the rotor's angle are kept."""
    text, m3, e, J = TURNING.replace("FACE", "ground" if wall else "b"), 0.14, 0.02, 2.4e-4
    result = run(scene_of(text, {"B.F0": 0 if wall else -1}), momentum=True)
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
    changes = {"bodies.a": m, "wall.gap": x, "wall.e": e, "f.N": N, "F.F0": F, "a.x": x, "a.v": v}
    found = run(scene_of(RUBBING, changes, method=method, t_end=1), most=1000)
    a, b = (F + N) / m, (F - N) / m
    expected = e * v * (1 / a + 1 / sqrt(a * b)) / (1 - e * sqrt(b / a))
    left_out = found.totals["chatter_time"]
    unit = np.spacing(expected)
    late = left_out * (0.01 if method == "taylor" else 0.01 + 2.2 * 32 / (4 * 1024))
    assert times(found, "rest_begin") + left_out == pytest.approx([expected], abs=late + 16 * unit)
    assert 0 < left_out < 10 * sqrt(2 * 1024 * 2.0**-53 * 2 * x / a) + 16 * unit
    assert found.totals["uncertified"] == 0


# A body that hops on the ground, with 1 m/s at first, and one rubbing on it that a force presses down.
CARRIED = """
bodies: {a: 1 kg, b: 1 kg}
stops: {floor: {between: [ground, a], gap: -1 m, acts: compression, law: rigid, e: 1}}
friction: {f: {between: [a, b], N: 4 N, mu: 0.5}}
forces: {F: {on: b, F0: -1 N}}
initial: {a: {x: 1 m, v: -1 m/s}, b: {x: 1 m, v: -1 m/s}}
run: {t_end: 10 s, every: 5 ms}
"""


@pytest.mark.parametrize("method", METHODS)
def test_hops_that_a_friction_stops_on_their_way_end_without_loss_in_the_stop(method):
    """Two equal bodies rub with 2 N, 1 N presses down: the lower one hops against 2 m/s^2, both come to rest
    on each other after 2 w / 3, at the height 2 w^2 / 9, and fall with w / 3 and 1/2 m/s^2: they strike at
    w / sqrt 3, and the sequence ends after 1 + sqrt 3 of its first speed. With e = 1 it went on by rounding.
    """
    found = run(scene_of(CARRIED, method=method), most=500)
    left_out = found.totals["chatter_time"]
    assert left_out < 1e-5
    assert times(found, "rest_begin") + left_out == pytest.approx([1 + sqrt(3)], abs=0.02 * left_out)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)


@pytest.mark.parametrize(("e", "m", "F"), ((0.05, 0.01, 0.05), (0.2, 0.1, 1.0), (0.2, 0.01, 1.0)))
def test_hops_in_which_a_light_body_is_caught_end_certified(e, m, F):
    """It slips faster than four times the speed of the hop, and comes to rest on the other within it."""
    found = run(scene_of(CARRIED, {"floor.e": e, "bodies.b": m, "F.F0": -F}), most=500)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)
