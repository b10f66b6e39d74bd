"""The sliding margin of an orbit: how far its reversals are from sticking, and its sticks from sliding on.

Where a sliding velocity comes to zero, a tie there would have to pass some force S for the ends to stay
together. Slip with the forces -forward and +backward on P gives the relative accelerations w+ and w-, which
are linear in the force, so S is where that line is zero. A reversal has |S| above the limit, a stick below
it; an orbit on which the two are equal is at a sliding bifurcation.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np

from vibsim.engine.flows.accelerations import accelerations
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.status import BACKWARD, FORWARD, Status
from vibsim.engine.state import State
from vibsim.engine.tangent.carried import Carried
from vibsim.orbits.returns.word import OF_FRICTION
from vibsim.physics.arithmetic.numbers import Doubles
from vibsim.physics.parts import Scene


def sliding_margin(scene: Scene, carried: Carried) -> float:
    """The smallest distance of |S| from the limit [N] at the zeros of sliding velocities on a motion; inf
    without any.
    """
    maker = RowMaker(scene, Doubles)
    margins = [
        abs(excess(scene, maker, part, t, components, codes))
        for (kind, part), t, components, codes in zip(
            carried.events, carried.times, carried.states, carried.codes.tolist(), strict=True
        )
        if kind in OF_FRICTION and kind != "stick_end"
    ]
    return min((margin for margin in margins if margin == margin), default=inf)


def excess(
    scene: Scene, maker: RowMaker, i: int, t: float, components: np.ndarray, codes: Sequence[int]
) -> float:
    """How far the force S of a tie in place of friction `i` would be beyond its limits at a state [N]; below
    0 where it would hold, NaN where the friction does not move its ends against each other.
    """
    state, status = _state(scene, t, components), _status(scene, codes)
    friction = scene.frictions[i]
    P, Q = maker.ends(friction)
    rates = []
    for sense in (FORWARD, BACKWARD):
        a, _ = accelerations(scene, Doubles, maker.rows(status.with_frictions({i: sense})), state)
        rates.append(a[P] - a[Q])
    (forward, backward), (above, below) = friction.starts, friction.limits
    if rates[0] == rates[1]:
        return float("nan")
    S = -forward - rates[0] * (forward + backward) / (rates[1] - rates[0])
    return max(-S - above, S - below)


def _state(scene: Scene, t: float, components: np.ndarray) -> State:
    n, values = len(scene.bodies), components.tolist()
    rotor = values[2 * n :] or [0.0, 0.0]
    phase, turns = Doubles.reduce_angle(rotor[0])
    return State(t, values[:n], values[n : 2 * n], phase, turns, rotor[1])


def _status(scene: Scene, codes: Sequence[int]) -> Status:
    stops, frictions = len(scene.stops), len(scene.frictions)
    return Status(
        tuple(codes[:stops]), tuple(codes[stops : stops + frictions]), tuple(codes[stops + frictions :])
    )
