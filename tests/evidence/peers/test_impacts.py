"""Impacts by the Newton-Moreau law: closed forms, and what it keeps."""

from dataclasses import replace
from math import sin
from types import SimpleNamespace

import numpy as np
import pytest

from tests.scenes import paper
from vibsim.cases import load_case
from vibsim.evidence.peers.automaton import Instant, _impulses, consistent_states, impact
from vibsim.evidence.peers.equations import Compiled, start_of
from vibsim.physics.parts import COMPRESSION, GROUND, RigidStop


def at(scene, state):
    return Instant(Compiled(scene), 0.0, state)


def test_one_ball_meets_two_that_touch():
    instant = at(load_case("gallery/three-balls").scene(), [0.1, 1.0, 0.0, 0.0, 0.0, 0.0])
    impulses = impact(instant, [0, 1], [instant.rate(0), instant.rate(1)])
    assert instant.state[1::2] == pytest.approx([-1 / 3, 2 / 3, 2 / 3], rel=1e-14)
    assert impulses == pytest.approx([4 / 3, 2 / 3], rel=1e-14)


def test_one_stop_turns_the_rate_round():
    instant = at(load_case("gallery/pile-driver").scene(), [1.0, 4.0, 0.0, 1.0])
    before = instant.rate(0)
    impact(instant, [0], [before])
    assert instant.rate(0) == pytest.approx(-0.6 * before, rel=1e-14)
    assert 250 * instant.state[1] + 750 * instant.state[3] == pytest.approx(250 * 4 + 750, rel=1e-14)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_rotor_takes_part_by_its_mass_matrix(e):
    """The impulse acts on the body alone: J' w - m3 e sin(phi) v is kept; at e = 1 the energy is, too."""
    stop = RigidStop("wall", 0, GROUND, 0.0, COMPRESSION, e)
    scene = replace(paper("II-B").as_parts(), stops=(stop,))
    p, phi = scene.motor, 0.7
    inertia, coupling = p.J + p.m3 * p.e**2, p.m3 * p.e * sin(phi)
    instant = at(scene, [0.0, 2.0, 0.1, -1.0, phi, 30.0])

    def kept():
        _, v1, _, _, _, w = instant.state
        return inertia * w - coupling * v1

    def energy():
        _, v1, _, _, _, w = instant.state
        masses = np.array([[scene.bodies[0].m + p.m3, -coupling], [-coupling, inertia]])
        return float(np.array([v1, w]) @ masses @ np.array([v1, w]) / 2)

    before, full = kept(), energy()
    impact(instant, [0], [2.0])
    assert instant.state[1] == pytest.approx(-e * 2.0, abs=1e-15) and instant.state[3] == -1.0
    assert kept() == pytest.approx(before, rel=1e-14)
    lost = 1 - energy() / full
    if e == 1:
        assert abs(lost) < 1e-13
    else:
        assert lost > 0


def test_a_body_held_from_both_sides_is_refused():
    scene = load_case("gallery/impact-pair").scene()
    instant = at(scene, start_of(scene))
    with pytest.raises(ArithmeticError, match="no impulses obey the law"):
        impact(instant, [0, 1], [1.0, 1.0])


def test_no_more_is_tried_than_can_be():
    """Of thirty frictions at rest, 3^30 combinations; of thirteen stops that touch, 2^13 sets."""
    friction = SimpleNamespace(states=("stick", "forward", "backward"), part=None)
    at = SimpleNamespace(switches=[friction] * 30)
    with pytest.raises(ArithmeticError, match="205891132094649 combinations of the parts at rest, of which"):
        consistent_states(at, ["stick"] * 30, range(30))
    with pytest.raises(ArithmeticError, match="13 stops touch at once"):
        _impulses(np.eye(13), np.ones(13), np.zeros(13))
