"""The certificate: a run without doubt has every event that the exact flow has, and no other."""

import math
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import strategies as st

from tests.engine.runs import run
from tests.events.whole_runs import ExactFlow, stretches
from tests.random_scenes import always, scenes
from tests.scenes import fixed_block, harmonic, scene

EPS = 2.0**-53
METHODS = ("closed_form", "taylor")
SAME_INSTANT = 1e-13  # of the run: events this close may come in either order
NEAR = 1e-6  # of the run: far more than the square root of rounding, by which a near-grazing event may shift
M1, K1, OMEGA_HZ, G = 0.5, 300.0, 2.5, 0.01
OMEGA = 2 * math.pi * OMEGA_HZ
STIFFNESS = K1 - M1 * OMEGA**2  # dynamic stiffness: steady state x1 = A / STIFFNESS sin(omega t)
around = [(sign, k) for sign in (1, -1) for k in range(1, 13)]

everywhere = pytest.mark.parametrize("method", METHODS)


def steady(excess, **changes):
    """V5, started in its steady state, whose amplitude is G (1 + excess)."""
    reach = G * (1 + excess)
    source = harmonic(OMEGA_HZ, STIFFNESS * reach)
    start = {"m1": M1, "k1": K1, "c": 0.0, "k2": 5000.0, "G": G, "stop_sign": -1, "v1": reach * OMEGA}
    return fixed_block(source, **{**start, "t_end": 0.5, **changes})


@everywhere
@pytest.mark.parametrize(("sign", "k"), around)
def test_grazing_amplitudes(method, sign, k):
    """V5 at amplitudes 1 +- 10^-k: contact where the cosine of the phase is 1 / (1 + 10^-k), or none."""
    result = run(steady(sign * 10.0**-k, method=method))
    assert result.totals["uncertified"] == 0
    if sign < 0:
        assert result.kinds == []
        assert result.totals["grazing_margin"] == pytest.approx(G * 10.0**-k, abs=64 * EPS * G)
        assert math.sin(OMEGA * result.totals["grazing_time"]) == pytest.approx(1, abs=1e-11)
    else:
        assert result.kinds[:2] == ["contact_begin", "contact_end"]
        before_peak = math.acos(1 / (1 + 10.0**-k)) / OMEGA
        # the phase from the peak is sqrt(2 10^-k): an error of 32 eps in x1 shifts it by that over its square
        spread = 32 * EPS / 10.0**-k * before_peak
        assert 0.1 - result.times[0] == pytest.approx(before_peak, abs=spread + 1e-16)


@everywhere
def test_a_touch_below_rounding_is_in_doubt(method):
    result = run(steady(0.0, method=method))
    assert result.totals["uncertified"] > 0
    assert 0.0 <= result.totals["first_uncertified_time"] <= 0.1


@everywhere
@pytest.mark.parametrize("k", range(2, 13, 2))
def test_two_events_within_one_step(method, k):
    """A touch so short that it begins and ends between two steps; a weak stop lets the motion go on."""
    result = run(steady(10.0**-k, method=method, k2=1e-3, t_end=0.15))
    assert result.kinds == ["contact_begin", "contact_end"]
    assert result.totals["uncertified"] == 0
    first, last = result.times
    length = 2 * math.acos(1 / (1 + 10.0**-k)) / OMEGA
    assert last - first == pytest.approx(length, rel=1e-5 + 64 * EPS / 10.0**-k)


@everywhere
@pytest.mark.parametrize(("sign", "k"), around)
def test_release_at_the_peak_of_the_force(method, sign, k):
    """Block 2 sticks while k1 x1 <= N: with N = k1 X (1 + 10^-k) it holds, with 1 - 10^-k it lets go."""
    reach = 0.01
    limit = K1 * reach * (1 + sign * 10.0**-k)
    source = harmonic(OMEGA_HZ, STIFFNESS * reach)
    blocks = {"m1": M1, "m2": 50.0, "k1": K1, "c": 0.0, "k2": None, "G": None, "N": limit}
    stuck = scene(source, **blocks, v1=reach * OMEGA, t_end=0.15, method=method)
    result = run(stuck)
    assert result.totals["uncertified"] == 0
    if sign > 0:
        assert result.kinds == []
    else:
        assert result.kinds[0] == "stick_end"
        before_peak = math.acos(1 - 10.0**-k) / OMEGA
        spread = 32 * EPS / 10.0**-k * before_peak
        assert 0.1 - result.times[0] == pytest.approx(before_peak, abs=spread + 1e-16)


TOUCHES = [(2.0, 100.0, 1), (2.0, 87.3, 1), (1.0, 100.0, 1), (0.7, 87.3, 1), (0.7, 100.0, -1)]


@pytest.mark.parametrize(("m2", "k1", "sense"), TOUCHES)
def test_a_motion_from_rest_that_touches_its_stop_once_a_period(m2, k1, sense):
    """1 - cos of the undamped motion is zero after each period; its rounding is not."""
    source = harmonic(1.0, 0.0, 5.0 * sense)
    blocks = {"m1": 1.0, "m2": m2, "k1": k1, "c": 0.0, "k2": 3000.0, "G": 0.0, "N": None}
    result = run(scene(source, **blocks, t_end=6.0, every_num=1, method="closed_form"))
    assert result.totals["uncertified"] > 0


def test_a_crossing_taken_for_one_above_zero_is_judged_by_all_that_it_may_miss():
    """Blocks apart by the rounding of 0.01 m: by 40 digits block 2 does not come to rest here."""
    omega = 12.24744871391589
    source = {**harmonic(1.0, 0.0, 1.0), "omega": omega, "cycles": omega / (2 * math.pi)}
    blocks = {"m1": 1.0, "m2": 2.0, "k1": 0.0, "c": 0.0, "k2": 400.0, "G": 0.0, "stop_sign": -1, "N": 1.0}
    start = {"x2": 0.01, "rest_distance": None, "t_end": 1.632993161855452}
    result = run(scene(source, **blocks, **start, method="closed_form"))
    assert result.totals["uncertified"] > 0


@pytest.mark.parametrize(("part", "way"), [("rest_distance", 1), ("G", 1), ("G", -1)])
@pytest.mark.parametrize(("x1", "x2", "at", "doubts"), [
    (0.031400000000000004, 0.0001, 0.0313, 1),  # m; 2.9e-18 beyond, for 1.5 ns
    (0.5, 0.25, 0.25, 0),
])  # fmt: skip
def test_a_start_that_rounding_alone_puts_at_a_limit_is_in_doubt(part, way, x1, x2, at, doubts):
    """The distance of the blocks less the limit is 0 in doubles."""
    blocks = {"N": None, "G": None, "k2": None, "stop_sign": 1}
    if part == "G":
        blocks |= {"k2": 100.0, "stop_sign": -way}
    start = scene(**{**blocks, part: at, "x1": way * x1, "x2": way * x2, "t_end": 0.1})
    assert (Fraction(x1) - Fraction(x2) != Fraction(at)) == doubts and x1 - x2 - at == 0
    assert run(start).totals["uncertified"] == doubts


def missed(scene):
    """(stretches of a run that the exact flow from their start passes otherwise, its doubts)."""
    found, doubts = stretches(scene)
    exact, later = ExactFlow(scene), SAME_INSTANT * scene.t_end
    wrong = []
    for stretch, following in pairwise([*found, None]):
        kind, t = exact.first_event(stretch, min(stretch.end + NEAR * scene.t_end, scene.t_end))
        crowd = following is not None and following.end - stretch.end <= later
        if stretch.kind:
            right = impact(kind) == impact(stretch.kind) and abs(t - stretch.end) <= NEAR * scene.t_end
            right = right or (crowd and kind == following.kind)
        else:
            right = kind == "" or stretch.end - t <= later  # one at the very end belongs to the next stretch
        if not right:
            wrong.append((stretch, kind, t))
    return wrong, doubts


def impact(kind):
    """The kind of an event; that of a hop which ends a sequence in doubles, not in more digits, is impact."""
    return "impact" if kind == "chatter" else kind


def assert_none_missed(scene):
    wrong, doubts = missed(scene)
    assert not wrong or doubts > 0, (scene, wrong)


def assert_none_missed_by(scene, method):
    assert_none_missed(replace(scene, method=method))


test_random_scenes = always(
    assert_none_missed_by, scenes(), st.sampled_from(("auto", "taylor")), few=50, many=8000
)
