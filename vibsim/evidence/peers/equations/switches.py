"""The parts of a scene that have states: stops and frictions, and which states each of them has."""

from dataclasses import dataclass
from typing import Any

from vibsim.physics.parts import AT_FORCE, Friction, RigidStop, Scene

FREE, CONTACT, LIFTED = "free", "contact", "lifted"  # of an elastic stop; lifted: deep, its damper would pull
OPEN, REST = "open", "rest"  # of a rigid stop
FORWARD, BACKWARD, STICK = "forward", "backward", "stick"  # of a friction
TIES = (REST, STICK)


@dataclass(frozen=True)
class Switch:
    """A part that has states.

    number : of the part among all stops and frictions, as files count them
    """

    number: int
    part: Any
    states: tuple[str, ...]

    @property
    def tie(self) -> str | None:
        """The state in which it ties its ends; None for an elastic stop."""
        return next((state for state in self.states if state in TIES), None)

    @property
    def direction(self) -> int:
        """Sign of the force on P that counts as positive: the push of a rigid stop, else along the axis."""
        return self.part.sense if isinstance(self.part, RigidStop) else 1


def switches_of(scene: Scene) -> tuple[Switch, ...]:
    """Stops, then frictions; those without any force are no parts of the motion."""
    parts = enumerate([*scene.stops, *scene.frictions])
    return tuple(Switch(i, part, _states(part)) for i, part in parts if not _is_idle(part))


def _is_idle(part: Any) -> bool:
    return isinstance(part, Friction) and not any((*part.limits, *part.starts))


def _states(part: Any) -> tuple[str, ...]:
    if isinstance(part, Friction):
        return FORWARD, BACKWARD, STICK
    if isinstance(part, RigidStop):
        return OPEN, REST
    return (FREE, CONTACT, LIFTED) if part.release == AT_FORCE else (FREE, CONTACT)
