"""Blows of rigid stops by the Newton-Moreau law, by trying which of them pass on an impulse.

With g' the rates of depth of the stops that touch, L their impulses and A = D G^-1 D' (D the rows of g', G
the masses, the rotor among them):  g'(after) = g' - A L,  L >= 0,  w = g'(after) + e g' <= 0,  L w = 0.
"""

from collections.abc import Sequence
from itertools import combinations
from math import sin

import numpy as np

from vibsim.evidence.peers.automaton.instant import Instant
from vibsim.evidence.peers.equations.tied_bodies import masses, rows_of
from vibsim.physics.parts import Scene

ROUNDING = 1e-12  # of the largest rate: what counts as zero
MOST_STOPS = 12  # that touch at once, of which all sets are tried


def blow(at: Instant, touching: Sequence[int], rates: Sequence[float]) -> list[float]:
    """Change the velocities of `at` by a blow of the rigid stops `touching`, whose depths change by `rates`
    [m/s]; the impulse of each [N s]. Raises ArithmeticError where no impulses obey the law.
    """
    if len(touching) == 1 and at.compiled.scene.motor is None:
        impulses = _of_one_stop(at, touching[0], rates[0])
    else:
        impulses = _of_several(at, touching, rates)
    at.look_again()
    return impulses


def _of_one_stop(at: Instant, i: int, rate: float) -> list[float]:
    """Newton's law: the ends part with e times the speed at which they met."""
    row, own = at.compiled.rows[i], at.compiled.masses
    impulse = (1 + at.switches[i].part.e) * rate / sum(1 / own[body] for body, _ in row)
    for body, sign in row:
        at.state[2 * body + 1] += sign * impulse / own[body]
    return [impulse]


def _of_several(at: Instant, touching: Sequence[int], rates: Sequence[float]) -> list[float]:
    scene, switches = at.compiled.scene, [at.switches[i] for i in touching]
    rotor = [0.0] * scene.has_motor
    rows = np.array([[*row, *rotor] for row in -rows_of(scene, switches)[0]])
    mobility = np.linalg.inv(_mass_matrix(scene, at.state))
    e = np.array([float(switch.part.e) for switch in switches])
    impulses = _impulses(rows @ mobility @ rows.T, np.array(rates), e)
    velocities = [*range(1, 2 * len(scene.bodies), 2), *([2 * len(scene.bodies) + 1] if rotor else [])]
    for place, step in zip(velocities, (-mobility @ rows.T @ impulses).tolist(), strict=True):
        at.state[place] += step
    passed: list[float] = impulses.tolist()
    return passed


def _mass_matrix(scene: Scene, state: Sequence[float]) -> np.ndarray:
    """Of the bodies, and of the rotor behind them, whose unbalance ties it to its body."""
    matrix = np.diag(masses(scene))
    if scene.motor is None:
        return matrix
    p, n = scene.motor, len(scene.bodies)
    matrix = np.pad(matrix, ((0, 1), (0, 1)))
    matrix[n, n] = p.J + p.m3 * p.e**2
    matrix[p.on, n] = matrix[n, p.on] = -p.m3 * p.e * sin(state[2 * n])
    return matrix


def _impulses(A: np.ndarray, rates: np.ndarray, e: np.ndarray) -> np.ndarray:
    """L of the law, trying all sets of stops that pass on an impulse, small ones first."""
    closing, count = (1 + e) * rates, len(rates)
    slack = ROUNDING * np.abs(rates).max()
    if count > MOST_STOPS:
        raise ArithmeticError(f"{count} stops touch at once, of which {MOST_STOPS} can be tried in all sets")
    for size in range(count + 1):
        for members in map(list, combinations(range(count), size)):
            L = np.zeros(count)
            if members:
                L[members] = np.linalg.lstsq(A[np.ix_(members, members)], closing[members], rcond=None)[0]
            w = closing - A @ L
            if (np.abs(w[members]) <= slack).all() and (w <= slack).all() and (L >= 0).all():
                return L
    raise ArithmeticError("no impulses obey the law of impact: a body is held from both sides")
