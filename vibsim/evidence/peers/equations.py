"""The equations of motion as the paper prints them, for the peers: plain floats, nothing rearranged.

A readable twin: it shares no line with the kernels, only the numbers of the scene.
"""

from collections.abc import Sequence
from math import cos, sin

from vibsim.physics.two_blocks import TwoBlocks

State = Sequence[float]  # x1, v1, x2, v2 [m, m/s] and, with a motor, phi, phidot [rad, rad/s]


class Equations:
    """Forces and rates of one scene. Block 2 stays where it is while `fixed`; N is 0 without friction.

    `evaluations` counts the right-hand sides evaluated.
    """

    def __init__(self, scene: TwoBlocks):
        self.scene = scene
        self.fixed = not scene.has_block2
        self.N = scene.N if scene.has_friction else 0.0
        self.evaluations = 0
        self._source = {"none": self._free, "harmonic": self._ideal, "motor": self._motor}[scene.source]

    def start(self) -> list[float]:
        """State at t = 0."""
        p = self.scene
        state = [p.x1, p.v1, *((0.0, 0.0) if self.fixed else (p.x2, p.v2))]
        return [*state, p.phi, p.phidot] if p.has_motor else state

    def gap(self, state: State) -> float:
        """Gap function g = x2 - x1 - G [m], or its mirror image: contact while g >= 0."""
        p = self.scene
        return p.stop_sign * (state[2] - state[0]) - p.G

    def gap_rate(self, state: State) -> float:
        """dg/dt [m/s]."""
        return self.scene.stop_sign * (state[3] - state[1])

    def force(self, state: State, contact: bool) -> float:
        """S = F_s1 + F_d (+ F_s2 in contact) [N], Eqs. (2.4)-(2.6)."""
        p, x1, v1, x2, v2 = self.scene, state[0], state[1], state[2], state[3]
        S = p.k1 * (x1 - x2) + p.c * (v1 - v2)
        return S + p.k2 * (x1 - x2 + p.stop_sign * p.G) if contact else S

    def rates(self, t: float, state: State, S: float, a2: float) -> tuple[float, ...]:
        """d state/dt where block 1 passes on the force S [N] and block 2 is accelerated by a2 [m/s^2]."""
        self.evaluations += 1
        return self._source(t, state, S, a2)

    def _free(self, t, state, S, a2):
        return state[1], -S / self.scene.m1, state[3], a2

    def _ideal(self, t, state, S, a2):
        """Eqs. (2.1)-(2.3)."""
        p = self.scene
        return state[1], (p.A * sin(p.omega * t) + p.F0 - S) / p.m1, state[3], a2

    def _motor(self, t, state, S, a2):
        """Eqs. (2.8)-(2.10): two linear equations for a1 and dw/dt, by Cramer's rule."""
        p, phi, w = self.scene, state[4], state[5]
        #   (m1 + m3) a1 - m3 e sin(phi) dw = m3 e w^2 cos(phi) - S
        #   -m3 e sin(phi) a1 + (J + m3 e^2) dw = M0 (1 - w / Omega0)
        mass, inertia = p.m1 + p.m3, p.J + p.m3 * p.e**2
        coupling = p.m3 * p.e * sin(phi)
        thrust = p.m3 * p.e * w**2 * cos(phi) - S
        torque = p.M0 * (1.0 - w / p.Omega0)
        determinant = mass * inertia - coupling**2
        a1 = (inertia * thrust + coupling * torque) / determinant
        dw = (mass * torque + coupling * thrust) / determinant
        return state[1], a1, state[3], a2, w, dw
