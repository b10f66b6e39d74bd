"""The energy ledger: what the source puts in, what damper and friction take out, and what is stored.

    work = int F v1 dt (ideal source) or int M0 (1 - w / Omega0) w dt (motor)
    viscous loss = int c (v1 - v2)^2 dt,  friction loss = N int |v2| dt = N |Delta x2| while block 2 slides
    one way stored = kinetic energy of blocks and rotor + k1 y^2 / 2 + k2 g^2 / 2 in contact
The integrals are taken stretch by stretch by Gauss-Legendre quadrature of the flow itself, to round-off, so
that stored - stored(0) - work + losses is zero but for rounding: a check on every run (first law).
"""

from vibsim.physics.forces import gap_function, motor_torque, source_force
from vibsim.physics.gauss_nodes import NODES, WEIGHTS


def stored_energy(scene, state, mode):
    """Kinetic and elastic energy [J] of `state` in `mode`; the unbalanced mass moves with velocity
    (v1 - e w sin phi, e w cos phi), Eqs. (2.8)-(2.10).
    """
    y = state.x1 - state.x2
    energy = scene.m1 * (state.v1 * state.v1) / 2 + scene.k1 * (y * y) / 2
    if scene.has_block2:
        energy = energy + scene.m2 * (state.v2 * state.v2) / 2
    if mode.contact:
        gap = gap_function(scene, y)
        energy = energy + scene.k2 * (gap * gap) / 2
    return energy


class EnergyLedger:
    """Sums work and losses over the stretches of a run; does nothing when not wanted."""

    def __init__(self, scene, kit, flow, wanted):
        self.scene, self.kit, self.flow, self.wanted = scene, kit, flow, wanted
        self.work = self.viscous = self.friction = self.start = self.stored = kit.number(0)

    def open(self, state, mode):
        """Energy at the start."""
        self.start = self.stored = self.energy(state, mode)

    def energy(self, state, mode):
        """Stored energy [J], rotor included."""
        scene, kit = self.scene, self.kit
        energy = stored_energy(scene, state, mode)
        if scene.has_motor:
            spin = scene.e * state.w
            energy = energy + scene.m3 * (state.v1 * state.v1) / 2
            energy = energy + (scene.J + scene.m3 * scene.e * scene.e) * (state.w * state.w) / 2
            energy = energy - scene.m3 * (state.v1 * (spin * kit.sin(state.phase)))
        return energy

    def gather(self, start, end, state, mode):
        """Add the stretch from the state `start` to `state` at the time `end`.

        A generator, which yields how far it is [s] after every piece; the sums change when all are done.
        """
        if not self.wanted:
            return
        tau, last = start.t - self.flow.t0, end - self.flow.t0
        sums = self.work, self.viscous
        while tau < last:
            piece = self.flow.longest_piece(tau)
            ahead = tau + piece if piece < last - tau else last
            sums = self._integrated(sums, tau, ahead - tau)
            tau = ahead
            yield self.flow.t0 + tau
        self.work, self.viscous = sums
        if self.scene.has_friction and mode.friction != 0:
            loss = self.scene.N * (mode.friction * (state.x2 - start.x2))
            self.friction = self.friction + loss
        self.stored = self.energy(state, mode)

    def _integrated(self, sums, tau, length):
        """The sums of work and viscous loss with those of one piece. The nodes lie where they should, not on
        the time grid, whose rounding would show in the sums.
        """
        scene = self.scene
        work = viscous = self.kit.number(0)
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            offset = tau + node * length
            state = self.flow.state_after(offset)
            u = state.v1 - state.v2
            viscous = viscous + weight * (u * u)
            work = work + weight * self._power(state, offset)
        return sums[0] + length * work, sums[1] + length * (scene.c * viscous)

    def _power(self, state, tau):
        """Power of the source [W]."""
        scene, kit = self.scene, self.kit
        if scene.has_motor:
            return motor_torque(scene, state.w) * state.w
        if scene.source != "harmonic":
            return kit.number(0)
        anchor = kit.turn_angle(scene.cycles, scene.cycles_lo, self.flow.t0)
        sine = kit.sin(anchor + kit.turn_angle(scene.cycles, scene.cycles_lo, tau))
        return source_force(scene, sine) * state.v1

    def entries(self):
        """(energy at the start, energy now, work, viscous loss, friction loss) [J], or None when not
        wanted.
        """
        if not self.wanted:
            return None
        return self.start, self.stored, self.work, self.viscous, self.friction
