"""What an event does to a small disturbance: the saltation matrix.

A disturbed motion meets the event function h a little earlier or later, and moves by the other vector field
for so long: S = I + (f+ - f-) n^T / (n^T f-), with n = grad h and f-, f+ the vector fields before and after
(Aizerman & Gantmakher 1958; Mueller 1995). In this model no field depends on time where it jumps.
    contact switch   the impact spring is slack at g = 0: f+ = f-, so S = I
    stick release    |S| = N on both sides: f+ = f-, so S = I
    reversal         only a2 jumps, n = grad v2: dv2 is multiplied by a2+ / a2- = (|S| - N) / (|S| + N)
    sticking         a2+ = 0: dv2 becomes 0, whatever a2-; a direction is lost (rank loss)
Friction acts on block 2 alone, so a1 and dw/dt never jump.
"""

from vibsim.physics.forces import transmitted_force


def reversal_factor(scene, state, contact):
    """By what dv2 is multiplied where block 2 turns round at `state` without sticking [-]."""
    force = abs(transmitted_force(scene, state.x1 - state.x2, state.v1 - state.v2, contact))
    return (force - scene.N) / (force + scene.N)


def stopping_share(scene, state, contact, sliding):
    """Deceleration of block 2 where it sticks at `state`, over the largest with which it can [-].

    sliding: +1 or -1, the direction it comes from. It is (N - sliding S) / (2 N): 0 where the motion just
    touches v2 = 0, which a disturbed one may miss.
    """
    force = transmitted_force(scene, state.x1 - state.x2, state.v1 - state.v2, contact)
    return (scene.N - sliding * force) / (2 * scene.N)
