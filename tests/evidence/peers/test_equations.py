"""The peers' equations against the kernel's forces, which were written apart from them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.scenes import fixed_block, paper, scene
from vibsim.evidence.peers.equations import Equations
from vibsim.physics.forces import gap_function, motor_accelerations, source_force, transmitted_force

STATES = st.lists(st.floats(-1, 1), min_size=6, max_size=6)


@given(state=STATES, contact=st.booleans(), sign=st.sampled_from([1, -1]))
def test_gap_and_force(state, contact, sign):
    made = scene(stop_sign=sign)
    x1, v1, x2, v2 = state[:4]
    equations = Equations(made)
    assert equations.gap(state) == pytest.approx(gap_function(made, x1 - x2), abs=1e-15)
    expected = transmitted_force(made, x1 - x2, v1 - v2, contact)
    assert equations.force(state, contact) == pytest.approx(expected, rel=1e-13, abs=1e-11)


@given(state=STATES, force=st.floats(-100, 100))
def test_motor(state, force):
    made = paper("II-B")
    phi, w = 10 * state[4], 40 * state[5]
    rates = Equations(made).rates(0.0, [*state[:4], phi, w], force, 0.25)
    a1, dw = motor_accelerations(made, force, math.sin(phi), math.cos(phi), w)
    np.testing.assert_allclose(rates, [state[1], a1, state[3], 0.25, w, dw], rtol=1e-12, atol=1e-10)


def test_ideal_source_and_none():
    made = paper("I-B")
    _, a1, _, _ = Equations(made).rates(0.3, [0.0, 2.0, 0.0, 0.0], 0.05, 0.0)
    assert a1 == pytest.approx((source_force(made, math.sin(made.omega * 0.3)) - 0.05) / made.m1, rel=1e-14)
    assert Equations(scene()).rates(0.3, [0.0, 2.0, 0.0, 0.0], 0.05, 0.0)[1] == -0.05 / made.m1


def test_a_fixed_block_stays():
    equations = Equations(fixed_block(x1=1e-3))
    assert equations.start() == [1e-3, 0.0, 0.0, 0.0] and equations.fixed
