"""The flow of a run: closed form in the modes that have one, Taylor series in the others."""

from vibsim.engine.certificate import Certificate
from vibsim.engine.closed_form import ClosedForm
from vibsim.engine.taylor import Taylor


class Flow:
    """Enters each mode by the flow that suits it; `scene.method` may demand one of them.

    least_order : of the Taylor series, where more derivatives are asked for than the scene's order has
    """

    def __init__(self, scene, kit, certificate=None, least_order=0):
        self.certificate = certificate or Certificate(kit)
        self.taylor = Taylor(scene, kit, self.certificate, least_order)
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

    def __getattr__(self, name):
        return getattr(self.now, name)
