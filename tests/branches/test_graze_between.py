"""A step of a branch that leads across a graze of a rigid stop."""

import numpy as np
import pytest

from vibsim.branches.curve.node import node_at
from vibsim.branches.plan import plan_from
from vibsim.branches.span import read_span
from vibsim.branches.special.inspection import inspect
from vibsim.cases import load_case
from vibsim.orbits import find_orbit

SCENE = """
name: across
bodies: {a: 0.8746 kg}
links: {l0: {between: [a, ground], k: 69.52 N/m, c: 1.406 N s/m}}
stops: {s0: {between: [a, ground], gap: 0.2423 m, acts: extension, law: rigid, e: 0.49}}
friction:
  f0: {between: [a, ground], N: 0.443 N, belt: 0.762 m/s, law: stribeck hyperbolic, mu_s: 0.4995,
    mu_d: 0.2049, d: 1.884 s/m}
forces:
  p:
    on: a
    terms: [{A: 7.015 N, omega: 0.991 Hz, phase: 119.8 deg}, {A: 4.667 N, omega: 1.982 Hz, phase: 44.72 deg}]
run: {t_end: 60 s, every: 20 ms}
"""
GRAZE = 0.4974312717  # restitution; there a DOP853 of its own turns 5e-9 m before the stop


def test_a_graze_is_told_where_a_step_leads_across_it(tmp_path):
    """Orbits with a second, slow blow have a multiplier of -79 behind it: brackets of orbits do not close in
    on the graze, where it is infinite, and the change was listed as unresolved.
    """
    path = tmp_path / "across.yaml"
    path.write_text(SCENE)
    case = load_case(str(path), {"s0.e": "0.4967508313181038"})
    orbit = find_orbit(case.scene(), {"x_a": 0.046492991, "v_a": -0.64445775}, 2, case=case)
    plan = plan_from(orbit, *read_span(case, "s0.e", "0.4:0.6"))
    family = plan.family()
    one = plan.start(family)
    z = family.unknowns(np.array([0.045826674, -0.64414805]), orbit.period, 0.5274591806299982)
    other = node_at(family, z, None, one, 0.1)
    assert (len(one.word), len(other.word), one.index, other.index) == (5, 6, 0, 1)
    (graze,) = inspect(family, one, other)
    assert graze.kind == "grazing" and graze.jump == 1
    assert graze.node.parameter == pytest.approx(GRAZE, abs=1e-9)
    near = load_case(str(path), {"s0.e": f"{graze.node.parameter - 1e-9!r}"})
    X = graze.node.point.end.X
    assert 0 < find_orbit(near.scene(), {"x_a": X[0], "v_a": X[1]}, 2).margin < 1e-8
