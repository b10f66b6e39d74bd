"""A scene at one instant: depths and rates of its parts, forces of ties and accelerations in any mode."""

from collections.abc import Sequence

from vibsim.evidence.peers.equations.compiled import Compiled
from vibsim.physics.parts import RigidStop


class Instant:
    """The parts of a scene at the time t [s] and in `state`, whose velocities may be changed."""

    def __init__(self, compiled: Compiled, t: float, state: list[float]):
        self.compiled, self.t, self.state = compiled, t, state
        self.switches = compiled.switches
        self._parts = compiled.parts(t, state)

    def look_again(self) -> None:
        """Take note of changed velocities."""
        self._parts = self.compiled.parts(self.t, self.state)

    def depth(self, i: int) -> float:
        """Depth of stop i [m]."""
        return self._parts[2 * i]

    def rate(self, i: int) -> float:
        """Its rate [m/s]; of a friction the velocity of slip."""
        return self._parts[2 * i + 1]

    def contact_force(self, i: int) -> float:
        """k g + c g' of elastic stop i [N]."""
        part = self.switches[i].part
        return float(part.k * self.depth(i) + part.c * self.rate(i))

    def balance(self, states: Sequence[str]) -> tuple[float, ...]:
        """d state/dt, and behind it the force in each part that can tie [N], were the parts in `states`."""
        parameters = self.compiled.parameters(states)
        rates: tuple[float, ...] = self.compiled.balance(self.t, self.state, parameters)
        return rates

    def tie_force(self, i: int, values: Sequence[float]) -> float:
        """The force in part i [N], from a `balance`."""
        return values[self.compiled.ties.index(i) - len(self.compiled.ties)]

    def second_rate(self, i: int, values: Sequence[float]) -> float:
        """Second rate of the depth of a rigid stop, of x_P - x_Q of a friction, from a `balance` [m/s^2]."""
        total = self.compiled.of_base[i] * self.compiled.base_acceleration(self.t)
        for body, sign in self.compiled.rows[i]:
            total += sign * values[2 * body + 1]
        return float(-total if isinstance(self.switches[i].part, RigidStop) else total)

    def halt(self, parts: Sequence[int]) -> None:
        """Take the rates of these parts to zero, or what rounding left of them."""
        rigid = (isinstance(self.switches[i].part, RigidStop) for i in parts)
        rates = [-self.rate(i) if stop else self.rate(i) for i, stop in zip(parts, rigid, strict=True)]
        if any(rates):
            for body, row in enumerate(self.compiled.halts(parts)):
                self.state[2 * body + 1] += sum(a * rate for a, rate in zip(row, rates, strict=True))
            self.look_again()
