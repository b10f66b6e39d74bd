"""The state of a scene: bodies and rotor at one instant."""

from dataclasses import dataclass
from typing import Generic

from vibsim.physics.arithmetic.numbers import Kit, N
from vibsim.physics.parts import Scene


@dataclass
class State(Generic[N]):
    """Displacements x [m] and velocities v [m/s] of the bodies, rotor angle [rad] and speed w [rad/s] at time
    t [s].

    The rotor angle is phase + 2 pi turns with the phase kept within one turn, so that a run of many turns
    loses no digits. Time lies on the grid of its number type and the other values belong to that very
    instant.
    """

    t: N
    x: list[N]
    v: list[N]
    phase: N
    turns: N
    w: N

    def copy(self) -> "State[N]":
        return State(self.t, list(self.x), list(self.v), self.phase, self.turns, self.w)

    def settled(self, kit: Kit[N]) -> "State[N]":
        """The state as it starts a segment: without what the numbers of the kit carry besides their
        values.
        """
        exact = kit.exact
        x, v = [exact(value) for value in self.x], [exact(value) for value in self.v]
        return State(exact(self.t), x, v, exact(self.phase), exact(self.turns), exact(self.w))


def start_of(scene: Scene[N], kit: Kit[N]) -> State[N]:
    """The state of a scene at t = 0."""
    zero = kit.number(0)
    phase, turns, w = zero, zero, zero
    if scene.motor is not None:
        phase, turns = kit.reduce_angle(scene.motor.phi)
        w = scene.motor.phidot
    x, v = [body.x for body in scene.bodies], [body.v for body in scene.bodies]
    return State(zero, x, v, phase, turns, w).settled(kit)
