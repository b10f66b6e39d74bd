"""What a peer's run comes to."""

from dataclasses import dataclass

import numpy as np

from vibsim.physics.parts import Scene


@dataclass
class Attempt:
    """One run of one method.

    Attributes
    ----------
    states : x, v of each body in turn (, phi, phidot) at the first of the instants asked for
        (reached, states)
    t_reached : time until which it ran [s]
    steps : steps taken
    evaluations : right-hand sides evaluated; None for a method that evaluates series instead
    events : (time [s], kind code) of the events that it reports, ascending
    kinds : names of the kinds of event that it can report at all
    stopped : whether the time limit ended it
    """

    states: np.ndarray
    t_reached: float
    steps: int
    evaluations: int | None
    events: list[tuple[float, int]]
    kinds: tuple[str, ...]
    stopped: bool = False


EVERY_KIND = ("contact_begin", "contact_end", "reversal", "stick_begin", "stick_end")
RIGID_KINDS = ("impact", "rest_begin", "rest_end")
CONTACTS = ("contact_begin", "contact_end")


def kinds_of(scene: Scene) -> tuple[str, ...]:
    """The kinds of event that are compared: those of rigid stops only where there are such."""
    return EVERY_KIND + RIGID_KINDS if scene.rigid_stops else EVERY_KIND
