"""The state of the system and the mode it moves in."""

from dataclasses import dataclass
from typing import Any


@dataclass
class State:
    """Displacements [m], velocities [m/s], rotor angle [rad] and speed [rad/s] at time t [s].

    The rotor angle is phase + 2 pi turns with the phase kept within one turn, so that a run of many turns
    loses no digits. Time lies on the grid of its number type and the other values belong to that very
    instant.
    """

    t: Any
    x1: Any
    v1: Any
    x2: Any
    v2: Any
    phase: Any
    turns: Any
    w: Any


@dataclass(frozen=True)
class Mode:
    """contact 0 free, 1 contact; friction +1 slip +, 0 stick, -1 slip -; violated: blocks closer than the
    rest distance allows.

    Without friction `friction` stays +1 and means nothing.
    """

    contact: int
    friction: int
    violated: int = 0
