"""Two events closer than rounding tells apart are in doubt; all others come in their order."""

from dataclasses import replace
from itertools import pairwise

import pytest

from tests.engine.runs import run as run_parts
from tests.scenes import fixed_block, scene
from tests.trajectories import ENGINES, run
from vibsim.physics.parts import EVENT_NAMES

METHODS = ("closed_form", "taylor")
everywhere = pytest.mark.parametrize(("engine", "method"), [(e, m) for e in ENGINES for m in METHODS])

# block 2 sticks until the spring of k1 is compressed by N / k1, contact begins at G: one place to 1e-17 m;
# 40 digits find the release 1.1e-16 s before the contact
G = 0.05043153077373398
TWO_AT_ONCE = {
    "m1": 0.5386799582547112,
    "m2": 0.31715090043652544,
    "k1": 9.201611417216393,
    "c": 0.0,
    "k2": 66.06531424243455,
    "G": G,
    "stop_sign": -1,
    "N": 0.14915268771244272 * 0.31715090043652544 * 9.81,
    "x1": 0.02072768885370705,
    "v1": -0.5906976950018936,
    "x2": 0.07413870767124531,
    "v2": 0.25881273829257717,
    "t_end": 6.8985,
}


@everywhere
def test_two_events_at_once_are_in_doubt(engine, method):
    result = run(scene(**TWO_AT_ONCE, method=method), engine)
    happened = pairwise(zip(result.kinds, result.times, strict=True))
    assert [{a, b} for (a, s), (b, t) in happened if t - s < 1e-14] == [{"stick_end", "contact_begin"}]
    assert result.totals["uncertified"] in (1, 2)  # the stretch before both, and that between them


@everywhere
@pytest.mark.parametrize("shift", [1e-9, -1e-9])
def test_two_events_in_short_order_are_not(engine, method, shift):
    """The stop moved by 1e-9 m: further than rounding blurs a place of 0.05 m, a million times."""
    case = scene(**{**TWO_AT_ONCE, "G": G + shift}, method=method)
    result = run(case, engine)
    happened = pairwise(zip(result.kinds, result.times, strict=True))
    near = [(a, b) for (a, s), (b, t) in happened if t - s < 1e-6]
    assert near == [("stick_end", "contact_begin") if shift > 0 else ("contact_begin", "stick_end")]
    assert result.totals["uncertified"] == 0


@everywhere
def test_one_place_under_two_names_is_not_in_doubt(engine, method):
    """Two stops at one place are met at one instant by definition: which is told first is no question."""
    case = fixed_block(c=0.0, k1=300.0, k2=5000.0, G=0.01, v1=-0.5, t_end=0.03, method=method)
    scene = case.as_parts()
    twice = replace(scene, stops=(*scene.stops, replace(scene.stops[0], name="again")))
    result = run_parts(twice, engine)
    assert [EVENT_NAMES[code] for code in result.events["kind"][1:3].tolist()] == ["contact_begin"] * 2
    assert result.events["t"][2] - result.events["t"][1] < 1e-15
    assert result.totals["uncertified"] == 0
