"""Peers without events: they converge to the truth, at the low order that a step across a switch leaves."""

import numpy as np
import pytest

from tests.evidence.peers.made import error, known
from tests.scenes import scene
from vibsim.evidence.peers.solvers import (
    EventlessSolver,
    RungeKutta4,
    SignChanges,
    TimeLimit,
    depths_of,
    eventless_motion,
)

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
