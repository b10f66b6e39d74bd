"""How a run can fail inside an engine, and the sentence that tells it."""

from collections.abc import Sequence
from typing import Any

from vibsim.engine.state import State

REASONS = {
    "accumulation": (
        "more than 64 events at one instant: the motion cannot be continued at double precision",
        "make stops softer or friction smaller, or change the start values slightly",
    ),
    "standstill": (
        "50,000 steps brought the run no further: the motion cannot be continued at double precision",
        "change the start values slightly, or make stops softer or friction smaller",
    ),
    "crushed": (
        "bodies are caught between rigid stops whose ends close on each other",
        "make one of them elastic, or leave the bodies more room (a wider gap, a smaller motion of the base)",
    ),
    "undecided": (
        "which frictions and stops hold cannot be decided at double precision",
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
    "precision": (
        "more than 1000 digits would be needed to know the end of the run",
        "end it earlier: digits are lost in proportion to its length",
    ),
}
MOST_NUMBERS = 4  # of displacements and of velocities, told in the sentence


class Stopped(Exception):
    """A run was told to stop while it decided what follows an event."""


class EngineError(Exception):
    """A run that failed inside an engine: `reason` and the `state` reached; cause, time, state and remedy in
    one line. parts: names of those that take part in it, if they are known.

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
        values = f"x = {_listed(state.x)} m, v = {_listed(state.v)} m/s"
        super().__init__(f"t = {state.t!s} s: {cause} ({values}); {remedy}")

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle, as between processes."""
        return type(self), (self.reason, self.state, self.parts)


def _listed(numbers: Sequence[object]) -> str:
    shown = [str(number) for number in numbers[:MOST_NUMBERS]]
    return ", ".join(shown + ["..."] * (len(numbers) > MOST_NUMBERS))
