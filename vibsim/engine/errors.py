"""How a run can fail inside an engine, and the sentence that reports it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic

from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Scene

# The state of a scene: bodies and rotor at one instant.


@dataclass
class State(Generic[N]):
    """Displacements x [m] and velocities v [m/s] of the bodies, rotor angle [rad] and speed w [rad/s] at time
    t [s].

    The rotor angle is phase + 2 pi turns with the phase kept within one turn, so that a run of many turns
    loses no digits. Time lies on the grid of its number type and the other values belong to that very
    instant.
    """

    t: N
    x: list[N]
    v: list[N]
    phase: N
    turns: N
    w: N

    def copy(self) -> "State[N]":
        return State(self.t, list(self.x), list(self.v), self.phase, self.turns, self.w)

    def rounded(self) -> "State[float]":
        """The same in doubles."""
        x, v = [float(value) for value in self.x], [float(value) for value in self.v]
        return State(float(self.t), x, v, float(self.phase), float(self.turns), float(self.w))


def start_of(scene: Scene[N], kit: Kit[N]) -> State[N]:
    """The state of a scene at t = 0."""
    zero = kit.number(0)
    phase, turns, w = zero, zero, zero
    if scene.motor is not None:
        phase, turns = kit.reduce_angle(scene.motor.phi)
        w = scene.motor.phidot
    x, v = [body.x for body in scene.bodies], [body.v for body in scene.bodies]
    return State(zero, x, v, phase, turns, w)


REASONS = {
    "accumulation": (
        "more than 64 events at one instant: the motion cannot be continued at this precision",
        "make stops softer or friction smaller, or change the start values slightly",
    ),
    "standstill": (
        "50,000 steps or more brought the run no further: the motion cannot be continued at this precision",
        "change the start values slightly, or make stops softer or friction smaller",
    ),
    "crushed": (
        "bodies are caught between rigid stops whose ends close on each other",
        "make one of them elastic, or leave the bodies more room (a wider gap, a smaller motion of the base)",
    ),
    "undecided": (
        "which frictions and stops hold cannot be decided at this precision",
        "change the start values or one of their limits slightly",
    ),
    "entangled": (
        "bodies hold each other by friction in more than 4095 ways of parting them",
        "have fewer of them rub on each other (twelve can, each on each other one)",
    ),
    "diverged": (
        "the state is no longer finite",
        "check the parameters for values far outside each other's scale",
    ),
    "singular": (
        "the motion comes to a singularity of a formula: no step is short enough for it",
        "look where the formula is infinite, or changes faster than time can be resolved",
    ),
    "domain": (
        "what stands under a root in a formula becomes negative",
        "write the formula so that it is defined there, with max(0, ...) or where(...)",
    ),
    "torn": (
        "the displacement of the base jumps, which no spring or stop on it can follow",
        "let base.x rise within a time, as h*min((t - t1)/rise, 1) does; it may have kinks",
    ),
    "held": (
        "a formula jumps so that the motion is held at its switch",
        "use a part of section friction for dry friction, or a smooth law such as tanh(v/v0)",
    ),
    "precision": (
        "more than 1000 digits would be needed to know the end of the run",
        "end it earlier: digits are lost in proportion to its length",
    ),
}
MOST_NUMBERS = 4  # of displacements and of velocities, given in the sentence


class Stopped(Exception):
    """A run was told to stop while it decided what follows an event."""


class EngineError(Exception):
    """A run that failed inside an engine: `reason` and the `state` reached; cause, time, state and remedy in
    one line, in doubles. parts: names of those that take part in it, if they are known.

    >>> import vibsim
    >>> try:
    ...     vibsim.simulate("II-B", overrides={"x1": "1e300 m"})
    ... except vibsim.EngineError as error:
    ...     print(error.reason)
    diverged
    """

    def __init__(self, reason: str, state: State[Any], parts: str = "") -> None:
        cause, remedy = REASONS[reason]
        cause += f": {parts}" if parts else ""
        self.reason, self.state, self.parts = reason, state, parts
        shown = state.rounded()
        values = f"x = {_listed(shown.x)} m, v = {_listed(shown.v)} m/s"
        super().__init__(f"t = {shown.t} s: {cause} ({values}); {remedy}")

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle, as between processes: the state in doubles, as numbers of words have no pickle."""
        return type(self), (self.reason, self.state.rounded(), self.parts)


def _listed(numbers: Sequence[float]) -> str:
    shown = [str(number) for number in numbers[:MOST_NUMBERS]]
    return ", ".join(shown + ["..."] * (len(numbers) > MOST_NUMBERS))
