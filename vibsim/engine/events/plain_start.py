"""The mode of a start that leaves no doubt: no depth, no sliding velocity anywhere near zero.

`Automaton.initial` says the signs of these; here they are told without asking the rest.
Newton's method for orbits begins motions by the thousand.
"""

from collections.abc import Callable

from vibsim.engine.modes.rows import Joined
from vibsim.engine.modes.status import BACKWARD, CONTACT, FORWARD, OPEN, Status
from vibsim.engine.modes.ties import Edge
from vibsim.engine.state import State
from vibsim.physics.parts import AT_FORCE, RigidStop, Scene

# of the sizes that a depth or a velocity is the difference of: rounding is a thousandth of it
NEAR = 2.0**-40


class PlainStart:
    """Tells the modes of plain starts of a scene; `known` says whether it can have any."""

    def __init__(self, scene: Scene, ends: Callable[[Joined], Edge]) -> None:
        self.known = not (
            scene.base
            or scene.clearances
            or any(
                isinstance(stop, RigidStop) or (stop.c != 0 and stop.release == AT_FORCE)
                for stop in scene.stops
            )
        )
        self.stops = [(*ends(stop), stop.sense, stop.gap) for stop in scene.stops]
        self.frictions = [(*ends(friction), friction.belt) for friction in scene.frictions]
        self._modes: dict[tuple[int, ...], Status] = {}

    def status(self, state: State) -> Status | None:
        """The mode of `state`, or None where a sign is not plain."""
        x, v = (*state.x, 0.0, 0.0), (*state.v, 0.0, 0.0)  # ground and base rest
        stops: list[int] = []
        frictions: list[int] = []
        for P, Q, sense, gap in self.stops:
            one, other = x[P], x[Q]
            depth = -(sense * (one - other)) - gap
            if abs(depth) <= NEAR * (abs(one) + abs(other) + abs(gap)):
                return None
            stops.append(CONTACT if depth > 0 else OPEN)
        for P, Q, belt in self.frictions:
            one, other = v[P], v[Q]
            rate = (one - other) - belt
            if abs(rate) <= NEAR * (abs(one) + abs(other) + abs(belt)):
                return None
            frictions.append(FORWARD if rate > 0 else BACKWARD)
        key = *stops, *frictions
        status = self._modes.get(key)
        if status is None:
            status = self._modes[key] = Status(tuple(stops), tuple(frictions), ())
        return status
