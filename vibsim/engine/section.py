"""The stroboscopic section: the exact state at the end of every period of what drives a scene, read off the
flow as it passes.

A period ends at t = k T of forces and base, and where the angle of a motor, or of the rotor that turns a
scene, passes 2 pi k forwards. Reading it changes no trajectory.
"""

from collections.abc import Iterator
from math import ceil, floor
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.flows.flow import Flow
from vibsim.physics.numbers import TWO_PI, TWO_PI_LO, N
from vibsim.physics.parts import Scene
from vibsim.physics.rates import common_period, turning_rotor

ITERATIONS = 60
LAST_PERIOD = 2**53  # behind it whole numbers of periods are no doubles


def has_section(scene: Scene[N]) -> bool:
    """Whether the scene has a motor, sources with a common period, or a rotor that its torque drives."""
    return scene.motor is not None or common_period(scene) is not None or turning_rotor(scene) is not None


class StroboscopicSection(Generic[N]):
    """Gathers `states` over the stretches of a run."""

    def __init__(self, scene: Scene[N], flow: Flow[N]) -> None:
        self.rotor = turning_rotor(scene)
        self.turning = scene.motor is not None or self.rotor is not None
        self.period = None if self.turning else common_period(scene)
        self.flow, self.next = flow, 1
        self.states: list[State[N]] = []

    def skip_to(self, t: N) -> None:
        """Begin with the first period that ends after t."""
        if self.period is not None:
            self.next = max(1, int(float(t) * self.period.cycles / self.period.turns))
            while self.period.end(self.next) <= t and self.next < LAST_PERIOD:
                self.next += 1

    def gather(self, start: State[N], end: N) -> Iterator[N]:
        """Section points within (start.t, end], on the stretch that the flow has just done from the state
        `start`; a generator, which yields the time of each.
        """
        if self.turning:
            yield from self._gather_turns(start, end)
        elif self.period is not None:
            exact = self.flow.kit.number
            t = exact(self.period.end(self.next))
            while t <= end and self.next < LAST_PERIOD:
                self.states.append(self.flow.state_at(t))
                yield t
                self.next += 1
                t = exact(self.period.end(self.next))

    def _gather_turns(self, start: State[N], end: N) -> Iterator[N]:
        """Forward passages of phi through whole turns, by bisection safeguarded Newton steps."""
        first = start.phase if self.rotor is None else start.x[self.rotor] - self._whole_turns(start)
        last = self._angle(end, start)
        most = 1 if self.rotor is None else max(1, ceil(float(last) / TWO_PI))
        for turn in range(most + 1):
            target = turn * TWO_PI + turn * TWO_PI_LO
            if first < target <= last:
                t = self._passage(start, end, target)
                self.states.append(self.flow.state_at(t))
                yield t

    def _passage(self, start: State[N], end: N, target: float) -> N:
        """Time at which the rotor angle, counted in the turn of `start`, passes `target`."""
        low, high = start.t, end
        t = low + (high - low) / 2
        for _ in range(ITERATIONS):
            state = self.flow.state_at(t)
            error = self._angle_of(state, start) - target
            if error < 0:
                low = t
            else:
                high = t
            speed = state.w if self.rotor is None else state.v[self.rotor]
            ahead = t - error / speed if speed > 0 else low
            if not low < ahead < high:
                ahead = low + (high - low) / 2
            if ahead == t or not low < ahead < high:
                return high
            t = ahead
        return high

    def _angle(self, t: N, start: State[N]) -> N:
        return self._angle_of(self.flow.state_at(t), start)

    def _angle_of(self, state: State[N], start: State[N]) -> N:
        """The angle of a state, counted in the turn of `start`."""
        if self.rotor is not None:
            return state.x[self.rotor] - self._whole_turns(start)
        return state.phase + (state.turns - start.turns) * TWO_PI

    def _whole_turns(self, start: State[N]) -> N:
        """The angle of a rotor that lies behind the turn it is in [rad]."""
        assert self.rotor is not None
        turns = floor(float(start.x[self.rotor]) / TWO_PI)
        exact = self.flow.kit.number
        return exact(turns) * exact(TWO_PI) + exact(turns) * exact(TWO_PI_LO)
