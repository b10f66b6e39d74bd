"""The peers' equations against the forces of the paper, written apart from them, and Newton's laws."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.evidence.peers.made import error, known
from tests.scenes import fixed_block, paper, scene
from vibsim.cases import load_case
from vibsim.evidence.peers.equations import Compiled, Equations, start_of
from vibsim.evidence.peers.solvers import (
    EventlessSolver,
    RungeKutta4,
    SignChanges,
    TimeLimit,
    depths_of,
    eventless_motion,
)
from vibsim.evidence.peers.straight_line import NAMES, OperationLog
from vibsim.physics.two_blocks import transmitted_force

STATES = st.lists(st.floats(-1, 1), min_size=6, max_size=6)
FLOATS = SimpleNamespace(**NAMES)


def motion(made, t, state, *states):
    """d state/dt with the parts in `states`."""
    compiled = Compiled(made.as_parts())
    return compiled.motion(t, state, compiled.parameters(states))


@given(state=STATES, contact=st.booleans(), sign=st.sampled_from([1, -1]))
def test_gap_and_force(state, contact, sign):
    made = scene(stop_sign=sign)
    x1, v1, x2, v2 = state[:4]
    parts = made.as_parts()
    at = Equations(parts, FLOATS, 0.0, state[:4])
    assert at.depth(parts.stops[0]) == pytest.approx(-sign * (x1 - x2) - made.G, abs=1e-15)
    _, a1, _, a2 = motion(made, 0.0, state[:4], "contact" if contact else "free", "forward")
    force = transmitted_force(made, x1 - x2, v1 - v2, contact)
    assert -made.m1 * a1 == pytest.approx(force, rel=1e-13, abs=1e-11)
    assert made.m2 * a2 + made.N == pytest.approx(force, rel=1e-13, abs=1e-11)


@given(state=STATES)
def test_motor(state):
    made = paper("II-B")
    phi, w = 10 * state[4], 40 * state[5]
    rates = motion(made, 0.0, [*state[:4], phi, w], "free", "backward")
    force = transmitted_force(made, state[0] - state[2], state[1] - state[3], False)
    unbalance = made.m3 * made.e
    coupling, torque = unbalance * math.sin(phi), made.M0 * (1 - w / made.Omega0)
    inertias = [[made.m1 + made.m3, -coupling], [-coupling, made.J + unbalance * made.e]]
    # Eqs. (2.9), (2.10)
    a1, dw = np.linalg.solve(inertias, [unbalance * w * w * math.cos(phi) - force, torque])
    a2 = (force + made.N) / made.m2
    np.testing.assert_allclose(rates, [state[1], a1, state[3], a2, w, dw], rtol=1e-12, atol=1e-10)


def test_ideal_source_and_none():
    made, state = paper("I-B"), [1e-4, 2.0, 0.0, 0.0]
    force = transmitted_force(made, 1e-4, 2.0, False)
    driving = made.A * math.sin(made.omega * 0.3) + made.F0  # A sin(omega t), Eq. (2.3)
    _, a1, _, _ = motion(made, 0.3, state, "free", "forward")
    assert a1 == pytest.approx((driving - force) / made.m1, rel=1e-14)
    assert motion(scene(), 0.3, state, "free", "forward")[1] == pytest.approx(-force / made.m1, rel=1e-14)


def test_a_block_on_the_ground_alone():
    assert start_of(fixed_block(x1=1e-3).as_parts()) == [1e-3, 0.0]


def test_ties_share_momentum_and_carry_what_is_left():
    """Two bodies that stick to each other move as one: the accelerations of the sum of masses and forces."""
    made = load_case("gallery/stack-of-blocks").scene()
    compiled = Compiled(made)
    values = compiled.balance(0.01, start_of(made), compiled.parameters(["forward", "stick", "forward"]))
    lower, middle, upper = values[1:6:2]
    table, lid = made.frictions[0].forward, made.frictions[2].forward
    assert lower == pytest.approx(middle, rel=1e-14)
    assert (3 + 2) * lower == pytest.approx(lid - table, rel=1e-13)
    assert upper == pytest.approx(-lid, rel=1e-14)
    of_seat = values[7]  # on the middle block
    assert of_seat == pytest.approx(2 * middle - lid, rel=1e-13)


def test_ties_that_share_a_force_are_refused():
    made = load_case("hard/pressed-on-a-stop").scene()
    compiled = Compiled(made)
    with pytest.raises(ArithmeticError, match="hold the same bodies at once: their forces are not unique"):
        compiled.parameters([switch.tie for switch in compiled.switches])


def test_a_tape_computes_what_floats_do():
    tape = OperationLog(2)
    a, b = tape.states
    values = [a + 2, 2 - a, -a * b / (1 / b), tape.sin(a), tape.exp(-b), tape.where(a - b, a, b)]
    function = tape.function([*values, tape.tanh(a)])
    expected = [2.5, 1.5, -0.5 * 9, math.sin(0.5), math.exp(-3.0), 3.0, math.tanh(0.5)]
    assert function(0.0, [0.5, 3.0]) == pytest.approx(expected, rel=1e-15)


STEPS = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4)
RELEASE = 1e-3  # m


def free_vibration(made, times):
    """x1 [m] of two blocks on a spring, released from x1 = RELEASE at rest: elementary."""
    total = made.m1 + made.m2
    rate = np.sqrt(made.k1 * total / (made.m1 * made.m2))
    return RELEASE * (made.m1 + made.m2 * np.cos(rate * times)) / total


def smooth(**changes):
    """Two blocks and a spring: no stop, no friction, no damper, no source."""
    return scene(k2=None, G=None, N=None, c=0.0, x1=RELEASE, **changes)


def test_order_four_on_a_smooth_scene():
    made, times = smooth(), np.linspace(0, 2.0, 11)
    errors = []
    for step in STEPS:
        attempt = RungeKutta4(made.as_parts(), step).run(times, TimeLimit())
        errors.append(np.abs(attempt.states[:, 0] - free_vibration(made, times)).max())
        assert attempt.steps == round(2.0 / step) and attempt.evaluations == 4 * attempt.steps
    order, _ = np.polyfit(np.log(STEPS), np.log(errors), 1)
    assert order == pytest.approx(4, abs=0.2)


def test_the_step_divides_the_sampling_interval():
    attempt = RungeKutta4(smooth().as_parts(), 3e-3).run(np.array([0.0, 0.01, 0.02]), TimeLimit())
    assert attempt.steps == 8  # 4 steps of 2.5 ms each


def test_what_is_no_longer_finite_is_a_failure():
    with pytest.raises(ArithmeticError, match=r"no longer finite at \d"):
        RungeKutta4(smooth(k1=1e9).as_parts(), 0.1).run(np.linspace(0, 200.0, 11), TimeLimit())


# Peers without events: they converge to the truth, at the low order that a step across a switch leaves.


CONTACTS = (1, 2)


def test_smoothed_friction_errs_in_proportion_to_its_width():
    truth = known("II-B", "8 s")
    widths = (1e-4, 1e-5, 1e-6)
    errors = []
    for width in widths:
        attempt = EventlessSolver(truth.scene, "LSODA", 1e-9, 1e-12, width).run(truth.times, TimeLimit())
        errors.append(error(attempt, truth))
    order, _ = np.polyfit(np.log(widths), np.log(errors), 1)
    assert order == pytest.approx(1, abs=0.2)


def test_contacts_are_read_off_the_steps():
    truth = known("II-B", "8 s")
    attempt = RungeKutta4(truth.scene, 5e-4).run(truth.times, TimeLimit())
    contacts = truth.events[np.isin(truth.events[:, 1], CONTACTS)]
    assert [kind for _, kind in attempt.events] == contacts[:, 1].tolist()
    np.testing.assert_allclose([t for t, _ in attempt.events], contacts[:, 0], atol=5e-4)


def test_solve_ivp_at_its_defaults_is_scipys_own():
    from scipy.integrate import solve_ivp

    made = known("I-C", "2 s").scene
    times = known("I-C", "2 s").times
    attempt = EventlessSolver(made, "RK45", 1e-3, 1e-6).run(times, TimeLimit())
    plain = solve_ivp(eventless_motion(made), (0, times[-1]), [0.0] * 4, t_eval=times)
    np.testing.assert_array_equal(attempt.states, plain.y.T)
    assert attempt.evaluations == plain.nfev


@pytest.mark.parametrize(
    ("width", "v2", "share"),
    [
        (None, -2e-300, -1.0),
        (None, 0.0, 0.0),
        (None, 3.0, 1.0),
        (1e-3, 1e-3, np.tanh(1.0)),
        (1e-3, -1.0, -1.0),
    ],
)
def test_sgn_and_tanh(width, v2, share):
    made = scene(c=0.0)
    a2 = eventless_motion(made.as_parts(), width)(0.0, [0.0, 0.0, 0.0, v2])[3]
    assert a2 == pytest.approx(-share * made.N / made.m2, rel=1e-14)


def test_sign_changes_are_timed_on_the_chord():
    changes = SignChanges(depths_of(scene().as_parts()), [0.0] * 4)  # G is 1 mm
    for t, x2 in ((1.0, 0.9e-3), (2.0, 1.3e-3), (3.0, 1.2e-3), (4.0, 0.8e-3)):
        changes.look(t, [0.0, 0.0, x2, 0.0])
    assert changes.events == [(pytest.approx(1.25), 1), (pytest.approx(3.5), 2)]


def test_without_a_stop_there_are_no_contacts():
    changes = SignChanges(depths_of(scene(k2=None, G=None).as_parts()), [0.0] * 4)
    changes.look(1.0, [0.0, 0.0, 1.0, 0.0])
    assert changes.events == []
