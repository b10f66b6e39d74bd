"""The ordinary oddities of a non-smooth motion, each in the smallest scene that shows it.

The closed form takes an event function for zero once it is within its rounding bound eps (16 + w t) x
magnitudes, so event times stand up to that bound over the slope of the function before the exact ones.
"""

import math

import numpy as np
import pytest

from tests.engine.runs import run
from tests.scenes import NO_SOURCE, fixed_block, harmonic, scene
from vibsim.engine.trajectory import open_trajectory

EPS = 2.0**-53
K1, M1, M2 = 200.0, 0.297, 2.94

both = pytest.mark.parametrize("method", ["closed_form", "taylor"])


def pushed(force):
    """A constant force on block 1 [N]: a harmonic source without amplitude."""
    return {**harmonic(1.0, 0.0), "F0": force}


@both
def test_contact_lost_in_the_moment_of_sticking(method):
    """Block 2, slowed by the stop and by friction, comes to rest just when the stop lets go of it."""
    # g'' = -w^2 g - N / m2 with g(0) = 0, g'(0) = r leaves at T = 2 atan(r w m2 / N) / w with g'(T) = -r;
    # v2(0) such that v2(T) = v2(0) - N T / m2 - (k2 / m2) int g = 0, where int g = (2 r - N T / m2) / w^2.
    k2, N, r = 12400.0, 3.0, 0.05
    w = math.sqrt(k2 * (1 / M1 + 1 / M2))
    T = 2 * math.atan(r * w * M2 / N) / w
    v2 = N * T / M2 + k2 / M2 * (2 * r - N * T / M2) / w**2
    together = scene(k1=0.0, c=0.0, N=N, G=0.0, v1=v2 - r, v2=v2, t_end=0.5, method=method)
    result = run(together)
    assert sorted(result.kinds) == ["contact_end", "stick_begin"]
    # rounding bound of v2 over its slope N / m2: 19 eps x 0.1 m/s / (1 m/s^2)
    np.testing.assert_allclose(result.times, T, rtol=0, atol=2e-16)
    # all momentum lost to friction while sliding: m1 v1 + m2 v2 falls by N T
    v1 = (M1 * (v2 - r) + M2 * v2 - N * T) / M1
    assert result.final("v1") == pytest.approx(v1, rel=1e-12)
    assert result.final("v2") == 0.0
    assert result.events["contact"][-1] == 0
    assert result.events["friction"][-1] == 0


@both
def test_the_gap_closes_just_as_block_2_halts(method):
    """v2 = 1 - t and x2 = t - t^2 / 2 reach 0 and G = 1/2 together at t = 1, all of it exact in binary."""
    exact = scene(m1=1.0, m2=1.0, k1=0.0, c=0.0, k2=1.0, G=0.5, N=1.0, v2=1.0, t_end=3.0, method=method)
    result = run(exact)
    assert result.kinds in (
        ["stick_begin"],
        ["contact_begin", "stick_begin"],
    )  # the gap has a double root there
    np.testing.assert_allclose(result.times, 1.0, rtol=0, atol=1e-7)  # sqrt(19 eps)
    assert result.final("x2") == pytest.approx(0.5, abs=1e-15)
    assert result.final("v2") == 0.0


@both
def test_start_in_stick(method):
    """|S| < N: block 2 stays and block 1 swings on its spring alone, about the point where block 2 stands."""
    held = scene(c=0.0, k2=None, G=None, N=2.0, x1=0.005, t_end=3.0, method=method)
    result = run(held)
    assert result.kinds == []
    assert set(result.samples["friction"]) == {0}
    t = result.samples["time"]
    np.testing.assert_allclose(
        result.samples["x1"], 0.005 * np.cos(math.sqrt(K1 / M1) * t), rtol=0, atol=1e-15
    )
    assert not result.samples["x2"].any()


@both
@pytest.mark.parametrize(
    ("change", "slips"),
    [
        ({"v1": 0.01}, True),  # S' = k1 v1 > 0
        ({"v1": -0.01}, False),
        (pushed(1.5), True),  # S' = 0, S'' = k1 (F0 - S) / m1 > 0
        (pushed(0.5), False),
        (pushed(1.0), False),  # in balance: stays for ever
    ],
)
def test_start_at_the_edge_of_the_friction_band(method, change, slips):
    """S = k1 x1 = 200 x 0.005 = N exactly: the first derivative of S that is not zero decides."""
    source = change if "source" in change else None
    more = {} if source else change
    edge = scene(source, c=0.0, k2=None, G=None, N=1.0, x1=0.005, t_end=0.002, method=method, **more)
    result = run(edge)
    assert result.events["friction"][0] == (1 if slips else 0)
    assert result.kinds == []
    assert (result.final("x2") > 0) == slips


@both
@pytest.mark.parametrize("sign", (1, -1))
def test_start_at_rest_without_gap(method, sign):
    """G = 0: whether the run starts in contact is settled by the force that begins to act, at third order."""
    driven = fixed_block(harmonic(3.0, sign * 0.5), k2=12400.0, G=0.0, c=0.0, t_end=0.1, method=method)
    result = run(driven)
    # contact while -x1 >= 0: a force to the left presses
    assert result.events["contact"][0] == (0 if sign > 0 else 1)
    assert np.all(result.samples["contact"][1:5] == (0 if sign > 0 else 1))


@both
def test_rest_without_gap_and_force_stays_free(method):
    result = run(scene(G=0.0, t_end=1.0, method=method))
    assert result.kinds == []
    assert result.events["contact"].tolist() == [0, 0]


@both
def test_start_preloaded(method):
    """G < 0: in contact at x = 0; x1 = xe (1 - cos w t) with xe = k2 |G| / (k1 + k2), until x1 = |G|."""
    k2, G = 12400.0, -0.001
    preloaded = fixed_block(k2=k2, G=G, c=0.0, t_end=0.05, method=method)
    result = run(preloaded)
    w, xe = math.sqrt((K1 + k2) / M1), k2 * 0.001 / (K1 + k2)
    assert result.events["contact"][0] == 1
    assert result.kinds[0] == "contact_end"
    assert result.times[0] == pytest.approx(math.acos(1 - 0.001 / xe) / w, rel=1e-14)


@both
def test_preload_in_balance_rests(method):
    balance = 12400.0 * 0.001 / 12600.0
    result = run(fixed_block(k2=12400.0, G=-0.001, c=0.0, x1=balance, t_end=1.0, method=method))
    assert result.kinds == []
    np.testing.assert_allclose(result.samples["x1"], balance, rtol=4 * EPS)


@both
def test_release_from_stick_follows_the_jerk(method):
    """Where friction gives way, v2 = S' t^2 / (2 m2): a zero of second order, which is not found again."""
    swinging = scene(c=0.0, k2=None, G=None, N=1.0, v1=0.3, t_end=0.06, method=method)
    result = run(swinging)
    assert result.kinds[0] == "stick_end"
    row = result.row(1)
    w = math.sqrt(K1 / M1)
    assert row["t"] == pytest.approx(math.asin(1.0 / (K1 * 0.3 / w)) / w, rel=1e-14)
    jerk = K1 * 0.3 * math.cos(w * row["t"]) / M2
    late = row["t"] + 1e-6 * np.array([1.0, 2.0, 4.0])
    tau = late - row["t"]
    v2 = open_trajectory(swinging.as_parts(), resume=row).state_at(late)["v2"]
    # next term: S'' t^3 / (6 m2), 1e-5 of the first; the closed form rounds v2 to eps of v1, 3e-17 / 1e-11
    np.testing.assert_allclose(v2, jerk * tau**2 / 2, rtol=1e-4)
    if method == "taylor":
        np.testing.assert_allclose(v2[1:] / v2[:-1], 4.0, rtol=1e-4)


@both
def test_reversal_without_stick(method):
    """A spring force above N throws block 2 back at v2 = 0: slip + to slip -."""
    thrown = scene(m1=1e30, c=0.0, k2=None, G=None, N=1.0, x2=0.05, v2=0.1, t_end=0.1, method=method)
    result = run(thrown)
    assert result.kinds == ["reversal"]
    assert result.events["friction"].tolist() == [1, -1, -1]
    # m2 x2'' = -k1 x2 - N: x2 + N / k1 on a circle
    w, centre = math.sqrt(K1 / M2), 1.0 / K1
    assert result.times[0] == pytest.approx(math.atan2(0.1 / w, 0.05 + centre) / w, rel=1e-14)
    assert result.events["x2"][1] == pytest.approx(math.hypot(0.05 + centre, 0.1 / w) - centre, rel=1e-14)


@both
@pytest.mark.parametrize("k2", (1e6, 1e9, 1e12))
def test_short_contacts_are_not_stepped_over(method, k2):
    """Two zeros within one step: a contact of half a period of sqrt(k2 / m1), down to 1.7 us."""
    bouncing = fixed_block(k2=k2, G=0.0, c=0.0, v1=-1.0, t_end=2.0, method=method)
    result = run(bouncing)
    w, wc = math.sqrt(K1 / M1), math.sqrt((K1 + k2) / M1)
    period = math.pi / w + math.pi / wc
    begins = result.times[result.events["kind"][1:-1] == 1]
    # starts in contact: the n-th contact begins after n periods
    np.testing.assert_allclose(begins, period * np.arange(1, len(begins) + 1), rtol=0, atol=1e-13)
    assert len(begins) == math.floor(2.0 / period)


@both
def test_exact_double_root_changes_nothing(method):
    """Amplitude = gap: whether the touch is seen or not, the motion goes on as if there were no stop."""
    touching = fixed_block(k2=12400.0, G=0.01, c=0.0, x1=0.01, t_end=2.0, method=method)
    result = run(touching)
    t = result.samples["time"]
    # a contact of depth eps X lasts sqrt(8 eps) / w and changes v by k2 times both: 1e-22; rounding is all
    np.testing.assert_allclose(
        result.samples["x1"], 0.01 * np.cos(math.sqrt(K1 / M1) * t), rtol=0, atol=1e-13
    )


@both
def test_start_at_the_rest_distance(method):
    """x1 - x2 equals the rest distance: in violation at once when it grows, not when it shrinks."""
    w = math.sqrt(K1 / M1)
    for v1, violated in ((0.1, 1), (-0.1, 0)):
        near = fixed_block(x1=0.001, v1=v1, rest_distance=0.001, G=None, c=0.0, t_end=0.3, method=method)
        result = run(near)
        assert result.kinds[0] == ("violation_end" if violated else "violation_begin")
        # x1 = X cos(w t - p): back at 0.001 at 2 p / w, or at (2 pi - 2 |p|) / w
        p = math.atan2(0.1 / w, 0.001)
        assert result.times[0] == pytest.approx((2 * p if violated else 2 * math.pi - 2 * p) / w, rel=1e-13)
        assert (result.totals["first_violation_time"] == 0.0) == bool(violated)


@both
@pytest.mark.parametrize("c", (0.0, 0.5))
def test_a_block_without_spring_meets_the_stop(method, c):
    """k1 = 0 and no source: the path x1 = v t, or v tau (1 - exp(-t / tau)) with a damper, tau = m1 / c."""
    flying = fixed_block(k1=0.0, c=c, k2=100.0, G=0.001, v1=-1.0, t_end=0.1, method=method)
    result = run(flying)
    assert result.kinds[0] == "contact_begin"
    arrival = 0.001 if c == 0 else -math.log1p(-0.001 * c / M1) * M1 / c
    assert result.times[0] == pytest.approx(arrival, rel=1e-14)


@both
def test_violation_stops_the_run(method):
    w = math.sqrt(K1 / M1)
    stopping = fixed_block(
        v1=0.1, rest_distance=0.001, stop_on_violation=True, G=None, c=0.0, t_end=9.0, method=method
    )
    result = run(stopping)
    assert result.kinds == ["violation_begin"]
    crossing = math.asin(0.001 * w / 0.1) / w
    assert result.events["t"][-1] == pytest.approx(crossing, rel=1e-14)
    assert result.totals["violations"] == 1
    assert result.totals["first_violation_time"] == result.events["t"][-1]
    assert result.samples["time"][-1] < crossing
    row = open_trajectory(stopping.as_parts(), resume=result.row(-1)).state_at(
        np.array([result.events["t"][-1]])
    )
    assert row["x1"][0] == pytest.approx(0.001, abs=1e-17)


def test_what_a_scene_has_not_got_is_not_modelled():
    bare = run(fixed_block({**NO_SOURCE, "source": "none"}, x1=0.01, G=None, t_end=0.1))
    assert list(bare.samples) == ["time", "x1", "v1"]
    assert bare.kinds == []
    assert np.isnan(bare.totals["grazing_margin"])
