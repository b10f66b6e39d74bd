"""Events that are crossed almost tangentially: there a disturbance is small only as long as it is tiny.

Where an event function h is crossed at the rate h', the motion goes beyond by about h'^2 / (2 |h''|) before
it can turn. A disturbance larger than that misses the event, and first order (the tangent flow) says nothing
of it. Crossings are judged by the square of their rate over that of the whole motion, about their share of
the depth of the deepest one. A share below CLOSE counts as a tangency.
"""

from vibsim.events.saltation import stopping_share
from vibsim.physics.disturbance import natural_rate
from vibsim.physics.modes import EVENT_KINDS

CLOSE = 1e-6  # a rate of 1/1000 of the largest
CONTACT_SWITCHES = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]


class Tangencies:
    """Counts close crossings and keeps the closest."""

    def __init__(self, scene, kit):
        self.scene, self.rate = scene, natural_rate(scene, kit)
        self.fastest = kit.number(0)  # largest |v1 - v2| + rate |y| at an event or the end of a step [m/s]
        self.nothing = kit.number(1), kit.number(0)
        self.forget()

    def forget(self):
        """Begin to count anew."""
        self.count = 0
        self.closest, self.time = self.nothing

    def pass_by(self, state):
        """Learn how fast the blocks move against each other."""
        speed = abs(state.v1 - state.v2) + self.rate * abs(state.x1 - state.x2)
        self.fastest = speed if speed > self.fastest else self.fastest

    def judge(self, kind, state, sliding, contact):
        """Judge the event of `kind` at `state`; sliding: friction mode before it."""
        if kind in CONTACT_SWITCHES and self.fastest > 0:
            rate = (state.v1 - state.v2) / self.fastest
        elif kind == EVENT_KINDS["stick_begin"]:
            rate = stopping_share(self.scene, state, contact, sliding)
        else:
            return
        share = rate * rate
        if share < CLOSE:
            self.count += 1
        if share < self.closest:
            self.closest, self.time = share, state.t
