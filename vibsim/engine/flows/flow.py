"""The flow of a run: closed form in the modes that have one, Taylor series in the others.

Short hops on a rigid stop are taken by Taylor series, which count depths from where the hop begins: the last
ones of an infinite sequence of impacts are lower than the rounding of displacements, in which the closed form
looks for the next impact.
"""

from math import inf

from vibsim.engine.events.certificate import Certificate
from vibsim.engine.flows.closed_form import ClosedForm
from vibsim.engine.flows.taylor import Taylor
from vibsim.engine.modes.rows import STRIKE


class Flow:
    """Enters each mode by the flow that suits it; `scene.method` may demand one of them.

    order : of the Taylor series; that of the scene, unless derivatives at a state are all that is asked for
    """

    def __init__(self, scene, kit, certificate=None, order=None):
        self.kit = kit
        self.certificate = certificate or Certificate(kit)
        self.taylor = Taylor(scene, kit, self.certificate, order)
        self.closed = ClosedForm(scene, kit, self.certificate)
        self.method = scene.method
        self.now = self.taylor

    def suits(self, rows):
        """The flow for the mode of `rows`."""
        if self.method == "taylor" or not self.closed.covers(rows):
            return self.taylor
        return self.closed

    def enter(self, state, rows, known):
        self.now = self.suits(rows)
        self.now.enter(state, rows, known)
        if self.now is self.closed and self._hops(rows, known):
            self.now = self.taylor
            self.now.enter(state, rows, known)

    def meeting(self, event, end):
        """How long after its start the flow reaches the zero of the STRIKE `event` that it found at the time
        `end` [s], which lies on the grid of time: the zero itself does not.
        """
        tau = end - self.now.t0
        value, slope = self.now.value_and_slope(event, tau)
        if not slope < 0:
            return tau
        step = self.kit.exact(value / slope)
        return tau - step if abs(step) <= self.kit.next_after(end, inf) - end else tau

    def _hops(self, rows, known):
        """Whether a rigid stop that was struck here will be again within the window of the closed form."""
        for event in rows.events:
            if event.kind == STRIKE and known.get(event.key, 0) == 1:
                _, speed, drive = self.closed.derivatives(event, 2)
                if drive < 0 and 2 * speed < -drive * rows.modal.window:
                    return True
        return False

    def __getattr__(self, name):
        return getattr(self.now, name)
