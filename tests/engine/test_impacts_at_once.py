"""Impacts of bodies that touch others, or that are struck at several stops."""

import random
from fractions import Fraction
from math import pi, sqrt

import numpy as np
import pytest

from tests.engine.impacts import METHODS, scene, times
from tests.engine.runs import run
from vibsim.cases import load_case
from vibsim.engine.events.impacts.newton_moreau import Contact, Masses, impact
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import (
    COMPRESSION,
    EVENT_KINDS,
    EVENT_NAMES,
    EXTENSION,
    GROUND,
    Body,
    Clearance,
    Link,
    RigidStop,
    Scene,
    Stop,
)
from vibsim.results.simulation import simulate


@pytest.mark.parametrize("method", METHODS)
def test_three_balls(method):
    """One ball meets two that touch: (1, 0, 0) becomes (-1/3, 2/3, 2/3) by the Newton-Moreau law."""
    bodies = [Body("a", 1.0, -1.0, 1.0), Body("b", 1.0, 0.0, 0.0), Body("c", 1.0, 0.0, 0.0)]
    stops = (RigidStop("ab", 0, 1, 0.0, COMPRESSION, 1.0), RigidStop("bc", 1, 2, 0.0, COMPRESSION, 1.0))
    result = run(scene(bodies, method, stops=stops, t_end=3.0), ledger=True, momentum=True)
    assert result.events["kind"].tolist() == [0, EVENT_KINDS["impact"], EVENT_KINDS["transmitted"], 8]
    after = [result.samples[f"v_{name}"][-1] for name in "abc"]
    assert after == pytest.approx([-1 / 3, 2 / 3, 2 / 3], rel=1e-15)
    assert after[1] == after[2]
    assert result.totals["transmitted"] == 1 and result.totals["rests"] == 0
    assert result.events["before_v_a"][1] == 1.0
    assert abs(result.totals["energy_residual"]) < 1e-15


@pytest.mark.parametrize("method", METHODS)
def test_body_crushed_between_walls_that_close(method):
    """Two heavy walls close on a light ball, e = 0.5: bounces without end in a finite time, then all move as
    one with the momentum of all.
    """
    bodies = [Body("l", 100.0, 0.0, 1.0), Body("ball", 1.0, 0.3, 0.0), Body("r", 100.0, 1.0, -1.0)]
    stops = (RigidStop("a", 0, 1, 0.0, COMPRESSION, 0.5), RigidStop("b", 1, 2, 0.0, COMPRESSION, 0.5))
    result = run(scene(bodies, method, stops=stops, t_end=3.0), ledger=True, momentum=True)
    gaps = result.samples["x_ball"] - result.samples["x_l"], result.samples["x_r"] - result.samples["x_ball"]
    assert min(gap.min() for gap in gaps) > -1e-15
    assert abs(result.totals["momentum_residual"]) < 1e-13
    assert abs(result.totals["energy_residual"]) < 1e-12
    assert result.totals["impacts"] < 200


TWINS = """
bodies: {b0: 0.4219724961127288 kg, b1: 2.0205722265529866 kg}
links: {l0: {between: [b0, ground], k: 3.6852853323265524 N/m}}
stops:
  e0: {between: [b0, ground], gap: 0 m, acts: compression, k: 41.89811667208198 N/m,
       c: 3.0324650071085157 N s/m, release: force}
  r0: {between: [b0, b1], gap: 0.3840759458734341 m, acts: extension, law: rigid, e: 0.6857331400718227}
  r1: {between: [b1, b0], gap: 0.3840759458734341 m, acts: compression, law: rigid, e: 1}
forces:
  F0: {on: b0, F0: 0.3192555741973109 N, terms: [
    {A: 1.757050347108766 N, omega: 0.7522050619787632 rad/s, phase: 1.5564601660430661 rad},
    {A: 0.746216967915518 N, omega: 3.466427862742015 rad/s, phase: 0.6990039361402913 rad}]}
  F1: {on: b1, A: 1.6663167018169944 N, omega: 1.5828024589444487 rad/s, phase: 4.618052510749918 rad}
initial: {b0: {x: -0.3632700009731692 m}, b1: {x: -0.0791940550997351 m, v: 0.48860002047161166 m/s}}
run: {t_end: 2.5 s, every: 0.5 s}
"""


def test_a_stop_that_rounding_leaves_open_where_its_twin_is_struck_is_struck(tmp_path):
    """Two stops with the same ends and gap: the law of impacts takes the larger e. The closed form tells the
    first zero with a depth of 9e-15 m, and the other stop was taken to be open by as much.
    """
    path = tmp_path / "twins.yaml"
    path.write_text(TWINS)
    events = simulate(load_case(path), trust=False).events
    struck = events["kind"] == EVENT_KINDS["impact"]
    behind, before = (
        events[f"{prefix}v_b1"][struck] - events[f"{prefix}v_b0"][struck] for prefix in ("", "before_")
    )
    assert struck.sum() == 1
    assert behind == pytest.approx(-before, rel=1e-13)


def test_a_body_that_stands_at_one_stop_and_is_struck_through_another_does_not_pass():
    """At t = 0 b2 stands at the wall, about to part from it, when b3 strikes it: both stops take part."""
    bodies = (
        Body("b0", 0.40644332916521275, -0.00133, 0.0),
        Body("b1", 0.3953666200681279, 0.0, 0.0),
        Body("b2", 2.2594357702209775, 0.0, 0.0),
        Body("b3", 0.4518559443749224, -0.0018, 0.01872389221539517),
    )
    stops = (
        Stop("s0", 1, 0, -0.002, EXTENSION, 74.19245410465113, 0.0),
        RigidStop("r0", 2, 3, -0.0018, EXTENSION, 0.3, True),
        RigidStop("r2", 2, GROUND, 0.0, COMPRESSION, 0.3, True),
    )
    links = (Link("l0", 2, 0, 22.354231116646613, 0.0),)
    scene = Scene(bodies, links, stops, t_end=0.07957747154594767, every_num=1, every_den=40)
    assert run(scene).samples["x_b2"].max() < 1e-16


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("away", [0.0, 0.125])
@pytest.mark.parametrize("side", [1, -1])
def test_a_impact_closes_what_just_touched(method, away, side):
    """c strikes b, which touches a spring at a: both go on with half of what b gets and swing about it until
    they part. Where the impact was at the start, b went through the spring.
    """
    speed, rate = 0.75, sqrt(2 * 40.0)
    bodies = [Body("a", 1.0, 0.0, 0.0), Body("b", 1.0, 0.0, 0.0), Body("c", 1.0, side * away, -side * 1.0)]
    stops = (Stop("ab", 1, 0, 0.0, side, 40.0, 0.0), RigidStop("bc", 2, 1, 0.0, side, 0.5))
    limit = Clearance("limit", *((GROUND, 1) if side > 0 else (1, GROUND)), 0.0)
    result = run(scene(bodies, method, stops=stops, clearances=(limit,), t_end=away + 0.5, every_den=32))
    told = [EVENT_NAMES[kind] for kind in result.events["kind"].tolist()]
    assert told == ["start", "impact", "contact_begin", "violation_begin", "contact_end", "end"]
    assert times(result, "contact_begin") == pytest.approx([away], abs=1e-15)
    assert times(result, "contact_end") == pytest.approx([away + pi / rate], rel=1e-13)
    t = np.clip(result.samples["time"] - away, 0, pi / rate)
    late = np.maximum(result.samples["time"] - away - pi / rate, 0)
    b = -side * (speed / 2 * t + speed / 2 / rate * np.sin(rate * t))
    a = -side * (speed / 2 * t - speed / 2 / rate * np.sin(rate * t) + speed * late)
    np.testing.assert_allclose(result.samples["x_b"], b, rtol=0, atol=1e-14)
    np.testing.assert_allclose(result.samples["x_a"], a, rtol=0, atol=1e-14)
    assert result.totals["uncertified"] <= (0 if away == 0 else 2)


def test_a_heavy_body_strikes_a_light_one_before_a_wall_to_rounding():
    """The light one, which rests, passes impulses that are large beside its momentum and cancel; speeds
    behind were 50 roundings off. The heavy one returns with e of its speed, in exact numbers.
    """
    rng = random.Random(5)
    for _ in range(200):
        light, heavy = rng.uniform(0.05, 0.2), rng.uniform(2, 20)
        e, other, v = rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95), rng.uniform(0.01, 1)
        contacts = [Contact(0, 0, 2, -1, e), Contact(1, 1, 0, -1, other)]
        bodies, before = Masses([1 / light, 1 / heavy, 0.0, 0.0]), [0.0, v, 0.0, 0.0]
        after, _, passed = impact(Doubles, bodies, contacts, before, 0.0)
        assert [one.stop for one in passed] == [0, 1]
        assert abs(Fraction(after[1]) + Fraction(other) * Fraction(v)) <= 2 * Doubles.eps * v
        assert abs(after[0]) <= 2 * Doubles.eps * v
