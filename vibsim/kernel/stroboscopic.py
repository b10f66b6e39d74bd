"""The stroboscopic section: the exact state at the end of every excitation period, read off the flow as it
passes.

A period ends at t = k / f of an ideal source, and where phi passes 2 pi k forwards with a motor. Reading it
changes no trajectory.
"""

from vibsim.physics.numbers import TWO_PI, TWO_PI_LO

ITERATIONS = 60
LAST_PERIOD = 2**53  # behind it whole numbers of periods are no doubles


class StroboscopicSection:
    """Gathers `states` over the stretches of a run; gathers nothing when not wanted or without a source."""

    def __init__(self, scene, flow, wanted):
        self.scene, self.flow = scene, flow
        self.wanted = wanted and scene.source != "none"
        self.states = []
        self.period = 1

    def period_end(self, k):
        """End of period k of the ideal source [s]."""
        t = k / self.scene.cycles
        return t - t * (self.scene.cycles_lo / self.scene.cycles)

    def skip_to(self, t):
        """Begin with the first period that ends after t."""
        if self.wanted and not self.scene.has_motor:
            self.period = max(1, int(t * self.scene.cycles))
            while self.period_end(self.period) <= t and self.period < LAST_PERIOD:
                self.period += 1

    def gather(self, start, end):
        """Section points within (start.t, end], on the stretch that the flow has just done from the state
        `start`; a generator, which yields now and then.
        """
        if self.wanted and self.scene.has_motor:
            self._gather_turns(start, end)
        elif self.wanted:
            t = self.period_end(self.period)
            while t <= end and self.period < LAST_PERIOD:
                self.states.append(self.flow.state_at(t))
                self.period += 1
                t = self.period_end(self.period)
                yield

    def _gather_turns(self, start, end):
        """Forward passages of phi through whole turns, by bisection safeguarded Newton steps."""
        first = start.phase
        last = self._angle(end, start)
        for turn in (0, 1):
            target = turn * TWO_PI + turn * TWO_PI_LO
            if first < target <= last:
                self.states.append(self.flow.state_at(self._passage(start, end, target)))

    def _passage(self, start, end, target):
        """Time at which the rotor angle, counted in the turn of `start`, passes `target`."""
        low, high = start.t, end
        t = low + (high - low) / 2
        for _ in range(ITERATIONS):
            state = self.flow.state_at(t)
            error = (state.phase + (state.turns - start.turns) * TWO_PI) - target
            if error < 0:
                low = t
            else:
                high = t
            ahead = t - error / state.w if state.w > 0 else low
            if not low < ahead < high:
                ahead = low + (high - low) / 2
            if ahead == t or not low < ahead < high:
                return high
            t = ahead
        return high

    def _angle(self, t, start):
        state = self.flow.state_at(t)
        return state.phase + (state.turns - start.turns) * TWO_PI
