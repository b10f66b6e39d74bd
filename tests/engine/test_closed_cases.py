"""Motions whose course is known in closed form, by mechanics alone."""

from dataclasses import replace
from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest

from tests.engine.runs import run
from vibsim.physics.parts import (
    AT_FORCE,
    BASE,
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Force,
    Friction,
    Harmonic,
    Link,
    Scene,
    Stop,
)

METHODS = ("auto", "taylor")


def scene(bodies, method="auto", **parts):
    return Scene(tuple(bodies), method=method, **{"t_end": 10.0, "every_den": 20, **parts})


def harmonic(amplitude, frequency, phase=0.0):
    return Harmonic(amplitude, 2 * pi * frequency, frequency, 0.0, phase)


@pytest.mark.parametrize("method", METHODS)
def test_modes_of_a_chain_of_three(method):
    """Equal masses between two walls by equal springs: normal frequencies 2 w sin(j pi / 8) (Rayleigh)."""
    w, amplitude = 3.0, 0.01
    shape = [sin(j * pi / 4) for j in (1, 2, 3)]
    bodies = [Body(f"b{j}", 1.0, amplitude * s, 0.0) for j, s in enumerate(shape)]
    ends = [(GROUND, 0), (0, 1), (1, 2), (2, GROUND)]
    links = tuple(Link(f"l{i}", P, Q, w * w, 0.0) for i, (P, Q) in enumerate(ends))
    result = run(scene(bodies, method, links=links))
    rate = 2 * w * sin(pi / 8)
    for j, s in enumerate(shape):
        expected = amplitude * s * np.cos(rate * result.samples["time"])
        assert np.abs(result.samples[f"x_b{j}"] - expected).max() < 1e-14


@pytest.mark.parametrize("method", METHODS)
def test_shaken_base_moves_a_mass_as_theory_says(method):
    """x'' + w^2 x = w^2 X, X = a sin(nu t), from rest: x = a (sin nu t - nu/w sin w t) / (1 - nu^2 / w^2)."""
    w, nu, a = 5.0, 2 * pi * 0.6, 0.002
    parts = {"links": (Link("l", 0, BASE, 2 * w * w, 0.0),), "base": (harmonic(a, 0.6),)}
    result = run(scene([Body("m", 2.0, 0.0, 0.0)], method, **parts))
    t = result.samples["time"]
    expected = a * (np.sin(nu * t) - nu / w * np.sin(w * t)) / (1 - (nu / w) ** 2)
    assert np.abs(result.samples["x_m"] - expected).max() < 1e-14


@pytest.mark.parametrize("method", METHODS)
def test_block_on_a_belt_sticks_where_the_spring_pulls_as_hard_as_friction(method):
    """Coulomb friction on a belt: after it sticks, it is carried to x = N / k and slips from there for good
    around its equilibrium, the amplitude being belt speed / w.
    """
    k, N, belt = 4.0, 1.0, 0.3
    parts = {"links": (Link("l", 0, GROUND, k, 0.0),), "frictions": (Friction("f", 0, GROUND, N, N, belt),)}
    result = run(scene([Body("m", 1.0, 0.0, belt)], method, **parts))
    kinds, times = result.events["kind"].tolist(), result.events["t"]
    assert kinds[:2] == [0, 5]  # start, stick_end
    assert times[1] == pytest.approx(N / k / belt, rel=1e-14)
    after = result.samples["time"] > times[1]
    t = result.samples["time"][after] - times[1]
    expected = N / k + belt / sqrt(k) * np.sin(sqrt(k) * t)
    before_next = result.samples["time"][after] < (times[2] if len(times) > 3 else 10.0)
    assert np.abs(result.samples["x_m"][after] - expected)[before_next].max() < 1e-13


@pytest.mark.parametrize("method", METHODS)
def test_body_rubbing_on_a_free_body_ends_at_their_common_velocity(method):
    """Momentum is kept: both end at m1 v1 / (m1 + m2), after v1 / (N (1/m1 + 1/m2))."""
    m1, m2, v1, N = 2.0, 3.0, 1.5, 4.0
    parts = {"frictions": (Friction("f", 0, 1, N, N, 0.0),), "t_end": 4.0}
    result = run(scene([Body("a", m1, 0.0, v1), Body("b", m2, 0.0, 0.0)], method, **parts), momentum=True)
    stick = result.events["t"][result.events["kind"] == 4]
    assert stick == pytest.approx([v1 / (N * (1 / m1 + 1 / m2))], rel=1e-15)
    for name in ("v_a", "v_b"):
        assert result.samples[name][-1] == pytest.approx(m1 * v1 / (m1 + m2), rel=1e-15)
    totals = result.totals
    assert totals["loss.friction.f"] == pytest.approx(m1 * m2 * v1**2 / (2 * (m1 + m2)), rel=1e-14)
    assert totals["momentum_start"] == totals["momentum_end"] == m1 * v1
    for name in ("impulse_ground", "impulse_base", "impulse_belt", "impulse_source"):
        assert totals[name] == 0


@pytest.mark.parametrize("method", METHODS)
def test_stack_of_stuck_blocks_moves_as_one_until_its_weakest_tie_gives_way(method):
    """A force F = c t on the lowest of three blocks at rest on each other: they move together from F =
    N_ground on, and the top block slips where its acceleration passes N_top / m_top; here nothing moves but
    by the ramp's constant.
    """
    masses, ground, middle, top = (3.0, 2.0, 1.0), 6.0, 5.0, 0.5
    force = 12.0
    bodies = [Body(name, m, 0.0, 0.0) for name, m in zip("abc", masses, strict=True)]
    frictions = (
        Friction("ground", 0, GROUND, ground, ground, 0.0),
        Friction("middle", 1, 0, middle, middle, 0.0),
        Friction("top", 2, 1, top, top, 0.0),
    )
    drive = (Force("drive", 0, force, ()),)
    result = run(scene(bodies, method, frictions=frictions, forces=drive, t_end=2.0))
    # the top one slips: 0.5 N moves 1 kg at 0.5; the others, 5 kg, at (12 - 6 - 0.5) / 5
    t = result.samples["time"]
    assert np.allclose(result.samples["x_c"], 0.5 * t**2 / 2, rtol=1e-14)
    assert np.allclose(result.samples["x_a"], 1.1 * t**2 / 2, rtol=1e-14)
    assert np.array_equal(result.samples["x_a"], result.samples["x_b"])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("release", ("gap", "force"))
def test_damped_stop_takes_off_as_the_half_wave_says(method, release):
    """A mass thrown at a damped wall: depth g = v/wd exp(-a t) sin(wd t); it opens at g = 0, or at k g + c
    g' = 0. What the mass loses is the stop's loss; let go at zero force, with what the spring holds.
    """
    m, k, c, v = 2.0, 800.0, 12.0, 0.7
    stop = Stop("wall", 0, GROUND, 0.1, COMPRESSION, k, c, release)
    result = run(scene([Body("m", m, 0.0, v)], method, stops=(stop,), t_end=3.0), ledger=True)
    a, wd = c / (2 * m), sqrt(k / m - (c / (2 * m)) ** 2)
    begin, end = result.events["t"][1:3]
    assert result.events["kind"][1:3].tolist() == [1, 2]
    assert begin == pytest.approx(0.1 / v, rel=1e-15)
    # k g + c g' = 0: (k - c a) sin + c wd cos = 0
    angle = pi - np.arctan2(c * wd, k - c * a) if release == AT_FORCE else pi
    duration = angle / wd
    assert end - begin == pytest.approx(duration, rel=1e-13)
    speed = v * exp(-a * duration) * (cos(angle) - a / wd * sin(angle))
    assert result.events["v_m"][2] == pytest.approx(speed, rel=1e-13)
    # free of the wall before its surface is back, or with it
    assert result.samples["wall"].max() == (2 if release == AT_FORCE else 1)
    totals, lost = result.totals, m * (v**2 - result.events["v_m"][2] ** 2) / 2
    assert 0 < lost < m * v**2 / 2
    assert totals["loss.stops.wall"] == totals["loss_stops"] == pytest.approx(lost, rel=1e-13)
    assert totals["energy_end"] == pytest.approx(m * result.events["v_m"][2] ** 2 / 2, rel=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_bilinear_frequency_between_two_stops_with_no_gap(method):
    """Stops on both sides at gap 0 act as one spring: w^2 = k / m."""
    k, m, x = 90.0, 1.6, 0.01
    stops = tuple(
        Stop(name, 0, GROUND, 0.0, sense, k, 0.0)
        for name, sense in (("up", COMPRESSION), ("down", EXTENSION))
    )
    result = run(scene([Body("m", m, x, 0.0)], method, stops=stops))
    expected = x * np.cos(sqrt(k / m) * result.samples["time"])
    assert np.abs(result.samples["x_m"] - expected).max() < 1e-14


@pytest.mark.parametrize("method", METHODS)
def test_two_parallel_springs_move_as_one(method):
    bodies = [Body("m", 1.0, 0.02, 0.0), Body("n", 2.0, 0.0, 0.3)]
    two = (Link("a", 0, 1, 30.0, 0.2), Link("b", 1, 0, 12.0, 0.1), Link("c", 1, GROUND, 20.0, 0.0))
    one = (Link("a", 0, 1, 42.0, 0.30000000000000004), Link("c", 1, GROUND, 20.0, 0.0))
    split, joined = (run(scene(bodies, method, links=links)) for links in (two, one))
    assert np.abs(split.samples["x_m"] - joined.samples["x_m"]).max() < 1e-13


@pytest.mark.parametrize("method", METHODS)
def test_split_body_whose_halves_are_tied_moves_as_one(method):
    """A body cut in two, stuck together by more friction than any force: the motion of the whole."""
    link = Link("l", 0, GROUND, 50.0, 0.0)
    whole = run(scene([Body("m", 3.0, 0.01, 0.2)], method, links=(link,)))
    halves = [Body("m", 1.0, 0.01, 0.2), Body("n", 2.0, 0.0, 0.2)]
    glue = (Friction("glue", 0, 1, 1e6, 1e6, 0.0),)
    split = run(scene(halves, method, links=(link,), frictions=glue))
    assert np.abs(whole.samples["x_m"] - split.samples["x_m"]).max() < 1e-14
    assert split.totals["events"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_parts_of_no_strength_change_nothing(method):
    base = scene([Body("m", 1.0, 0.02, 0.0)], method, links=(Link("l", 0, GROUND, 30.0, 0.5),))
    more = replace(
        base,
        links=(*base.links, Link("z", 0, GROUND, 0.0, 0.0)),
        forces=(Force("none", 0, 0.0, (harmonic(0.0, 2.0),)),),
    )
    assert np.array_equal(run(base).samples["x_m"], run(more).samples["x_m"])


@pytest.mark.parametrize("method", METHODS)
def test_stuck_block_breaks_loose_where_its_force_passes_friction(method):
    """The force A sin(2 pi f t) moves nothing until it passes N: at arcsin(N / A) / (2 pi f), though no
    velocity tells the Taylor flow how fast it changes.
    """
    A, N, f = 1.0, 0.9, 1.0
    parts = {
        "frictions": (Friction("f", 0, GROUND, N, N, 0.0),),
        "forces": (Force("F", 0, 0.0, (harmonic(A, f),)),),
    }
    result = run(scene([Body("m", 1.0, 0.0, 0.0)], method, **parts))
    slips = result.events["t"][result.events["kind"] == 5]
    expected = np.arcsin(N / A) / (2 * pi * f) + np.arange(20) / 2
    assert slips == pytest.approx(expected, rel=1e-14)
    assert result.totals["uncertified"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_body_between_ground_and_moving_base_follows_the_stronger_friction(method):
    """Where the base rests for an instant the body rests against both, but cannot stick to both: the weaker
    friction turns round. X = a sin(nu t), the body starts with the base.
    """
    a, nu, weak, strong = 0.01, pi, 0.02, 5.0

    def rubbing(on_base, on_ground):
        frictions = (
            Friction("b", 0, BASE, on_base, on_base, 0.0),
            Friction("g", 0, GROUND, on_ground, on_ground, 0.0),
        )
        body = [Body("m", 1.0, 0.0, a * nu)]
        return run(scene(body, method, frictions=frictions, base=(harmonic(a, 0.5),), t_end=6.0))

    carried, braked = rubbing(strong, weak), rubbing(weak, strong)
    assert np.abs(carried.samples["x_m"] - a * np.sin(nu * carried.samples["time"])).max() < 1e-15
    assert np.ptp(braked.samples["x_m"][braked.samples["time"] > 0.1]) == 0.0
    for result, part in ((carried, 1), (braked, 0)):
        turns = result.events["kind"] == 3
        assert result.events["t"][turns] == pytest.approx([0.5, 1.5, 2.5, 3.5, 4.5, 5.5], rel=1e-14)
        assert (result.events["part"][turns] == part).all()
        assert result.totals["uncertified"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_body_that_touches_a_stop_at_rest_is_in_contact_as_soon_as_it_is_pushed(method):
    """The table turns round where friction on it then tears the body off the ground, into the stop."""
    limit = 0.01 * (2 * pi) ** 2
    rate = 7.264067453591843
    table = Harmonic(0.00369, rate, rate / (2 * pi), 0.0, 2.0)
    scene = Scene(
        (Body("m", 10**0.006, 0.0, 0.0),),
        stops=(Stop("wall", GROUND, 0, 0.0, EXTENSION, (2 * pi) ** 2, 0.0),),
        frictions=(
            Friction("ground", GROUND, 0, limit, limit / 2, 0.0),
            Friction("table", BASE, 0, limit, limit, 0.0),
        ),
        base=(table,),
        t_end=0.4775,
        method=method,
    )
    result = run(scene, ledger=True)
    turn = (1.5 * pi - 2.0) / rate
    begins = result.events["t"][result.events["kind"] == 1]
    assert begins[0] == pytest.approx(turn, rel=1e-14)
    assert abs(result.totals["energy_residual"]) < 1e-17
