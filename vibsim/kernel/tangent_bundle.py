"""The tangent bundle of a run: K disturbances carried through modes and events, and how fast they grow.

Disturbances are orthonormalised (modified Gram-Schmidt) at every event and step; what they grow by there adds
up to the exponents (Benettin et al. 1980), the largest first. Event times lie on the grid of doubles and v2
keeps its residue at a reversal, while the saltation matrices are those of the exact event: the difference is
of the size of rounding.

Sticking takes dv2 from every disturbance: a rank loss, counted. A complete bundle has one disturbance less
from then on. Its last one is replaced by dv2 alone, orthogonal to the others, and has the exponent minus
infinity over every span with a rank loss in it.

A complete bundle checks itself (Liouville, V10): the logarithm of its volume must grow by the integral of the
trace of the equations of motion and by the logarithms of the determinants at the events. Sticking, where the
determinant is 0, is left out on both sides.
"""

from math import inf
from typing import Any

from vibsim.events.saltation import reversal_factor
from vibsim.events.tangencies import Tangencies
from vibsim.flows.closed_form_tangent import ClosedFormTangent
from vibsim.flows.taylor_tangent import TaylorTangent
from vibsim.physics.disturbance import COMPONENTS, DV2, DY, components, dimension, natural_rate
from vibsim.physics.modes import EVENT_KINDS

TANGENTS = {"closed_form": ClosedFormTangent, "taylor": TaylorTangent}
SPANS = 100  # that the growth is recorded in


class TangentBundle:
    """Carries `count` disturbances over the stretches of a run; none of it where `count` is 0.

    begin : time [s] from which growth counts. `rows` holds (t, logarithm of each one's growth since then) at
    `begin`, at the ends of SPANS equal spans from there to t_end, each at the next event or step behind it.
    """

    def __init__(self, scene, kit, flow, count=0, begin=0.0):
        self.scene, self.kit, self.count = scene, kit, count
        if count == 0:
            return
        self.flow: Any = TANGENTS[flow.method](scene, kit, flow)
        self.complete = count == dimension(scene)
        self.begin = kit.number(begin)
        self.weights = self._weights()
        self.tangencies = Tangencies(scene, kit)
        self.residual = kit.number(0)  # growth of the logarithm of the volume that nothing explains
        self.rows, self.next_row, self.losses, self.pieces = [], 0, 0, 0
        self.sums = [kit.number(0)] * count

    def _weights(self):
        """Weights of the squared components: each is measured as a velocity [m/s], dy by the natural rate, dw
        by the arm e, dphi by both.
        """
        scene, kit = self.scene, self.kit
        rate = natural_rate(scene, kit)
        arm = scene.e if scene.has_motor else kit.number(1)
        one = kit.number(1)
        return [rate * rate, one, one, (arm * rate) * (arm * rate), arm * arm]

    def open(self, state, mode):
        """Disturbances at the start: a general one, then one component each, dv2 last."""
        if self.count == 0:
            return
        zero, one = self.kit.number(0), self.kit.number(1)
        present = components(self.scene)
        general = [one if k in present else zero for k in range(COMPONENTS)]
        others = [k for k in present if k not in (DY, DV2)] + ([DV2] if DV2 in present else [])
        units = [[one if k == other else zero for k in range(COMPONENTS)] for other in others]
        self.vectors = [general, *units][: self.count]
        self.renormalise()
        self.sums = [zero] * self.count
        self.stuck = self.scene.has_friction and mode.friction == 0
        if self.stuck:
            self._lose_rank()
        self._record(state.t)

    def gather(self, start, end, state):
        """Carry the disturbances over the stretch from the state `start` to `state` at the time `end`.

        A generator, which yields how far it is [s] after every piece.
        """
        if self.count == 0:
            return
        t = start.t
        while t < end:
            ahead = self.flow.piece_end(t, end, self._mark())
            self.flow.prepare(t, ahead)
            self.vectors = [self.flow.moved(vector) for vector in self.vectors]
            volume = self.renormalise()
            if self.complete:
                self.residual = self.residual + (volume - self.flow.log_volume(t, ahead))
            self.pieces += 1
            t = ahead
            self._record(t)
            yield t
        self.tangencies.pass_by(state)

    def cross(self, kind, state, before):
        """Take the event of `kind` at `state`; before: the mode that ends there."""
        if self.count == 0 or kind is None:
            return
        self.tangencies.judge(kind, state, before.friction, before.contact)
        if kind == EVENT_KINDS["reversal"]:
            factor = reversal_factor(self.scene, state, before.contact)
            for vector in self.vectors:
                vector[DV2] = vector[DV2] * factor
            if self.complete and factor > 0:
                self.residual = self.residual - self.kit.log(factor)
        elif kind == EVENT_KINDS["stick_begin"]:
            self._lose_rank()
        self.stuck = kind == EVENT_KINDS["stick_begin"] or (self.stuck and kind != EVENT_KINDS["stick_end"])

    def _lose_rank(self):
        """Sticking: dv2 of every disturbance becomes 0."""
        zero = self.kit.number(0)
        self.losses += 1
        for vector in self.vectors:
            vector[DV2] = zero
        if self.complete:
            self.vectors[-1] = [zero, zero, self.kit.number(1), zero, zero]
        self.renormalise()

    def renormalise(self):
        """Orthonormalise, add to the growth; returns the logarithm of the volume that they spanned."""
        volume = self.kit.number(0)
        for i, vector in enumerate(self.vectors):
            for other in self.vectors[:i]:
                overlap = self._product(other, vector)
                vector = [a - overlap * b for a, b in zip(vector, other, strict=True)]
            size = self.kit.sqrt(self._product(vector, vector))
            growth = -inf
            if size > 0:
                vector = [self.kit.exact(a / size) for a in vector]
                growth = self.kit.log(size)
            self.vectors[i] = vector
            self.sums[i] = self.sums[i] + growth
            volume = volume + growth
        return volume

    def _product(self, a, b):
        total = self.weights[0] * (a[0] * b[0])
        for k in range(1, COMPONENTS):
            total = total + self.weights[k] * (a[k] * b[k])
        return total

    def _mark(self):
        """Time [s] of the next row."""
        if self.next_row >= SPANS:
            return self.scene.t_end
        return self.begin + (self.scene.t_end - self.begin) * self.next_row / SPANS

    def _record(self, t):
        """Keep a row where one is due at t [s]."""
        if self.next_row > SPANS or t < self._mark():
            return
        if self.next_row == 0:
            self.sums = [self.kit.number(0)] * self.count
            self.losses = 1 if self.stuck else 0
            self.tangencies.forget()
        self.rows.append((t, *self.sums))
        while self.next_row <= SPANS and self._mark() <= t:
            self.next_row += 1

    def entries(self):
        """(count, complete, rows, rank losses, pieces, volume residual, tangencies: count, closest, its time,
        largest speed), or None where nothing is carried; see `tangent_totals`.
        """
        if self.count == 0:
            return None
        near = self.tangencies
        judged = near.count, near.closest, near.time, near.fastest
        return self.count, self.complete, self.rows, self.losses, self.pieces, self.residual, judged
