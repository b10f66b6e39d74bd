"""Equations written once for numbers of any kind, turned into straight-line Python functions.

A `Tape` hands out numbers that note down what is done with them. What scipy's solvers call again and again is
then a list of assignments to local variables: no loop over parts is left in it.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

NAMES: dict[str, Any] = {
    "sin": math.sin,
    "cos": math.cos,
    "exp": math.exp,
    "tanh": math.tanh,
    "sgn": lambda v: math.copysign(1.0, v) if v else 0.0,
}


class Tape:
    """A number kit whose numbers are local variables of a function of time, state and parameters."""

    def __init__(self, states: int, parameters: int = 0):
        self.t = Noted(self, "t")
        self.states = [Noted(self, f"s{i}") for i in range(states)]
        self.parameters = [Noted(self, f"p{i}") for i in range(parameters)]
        self._lines = _unpacked("state", self.states) + _unpacked("parameters", self.parameters)

    def note(self, text: str) -> "Noted":
        """The variable that is assigned `text`."""
        name = f"a{len(self._lines)}"
        self._lines.append(f"{name} = {text}")
        return Noted(self, name)

    def sin(self, a: Any) -> "Noted":
        return self.note(f"sin({_text(a)})")

    def cos(self, a: Any) -> "Noted":
        return self.note(f"cos({_text(a)})")

    def exp(self, a: Any) -> "Noted":
        return self.note(f"exp({_text(a)})")

    def tanh(self, a: Any) -> "Noted":
        return self.note(f"tanh({_text(a)})")

    def sgn(self, a: Any) -> "Noted":
        """-1, 0 or 1."""
        return self.note(f"sgn({_text(a)})")

    def where(self, a: Any, yes: Any, no: Any) -> "Noted":
        """`yes` where a >= 0, else `no`."""
        return self.note(f"{_text(yes)} if {_text(a)} >= 0.0 else {_text(no)}")

    def function(self, values: Sequence[Any]) -> Callable[..., Any]:
        """The function (t, state, parameters) that returns the tuple of `values`."""
        answer = "".join(f"{_text(value)}, " for value in values)
        lines = ["def function(t, state, parameters=()):", *self._lines, f"return ({answer})"]
        scope: dict[str, Any] = {}
        exec("\n    ".join(lines), dict(NAMES), scope)
        function: Callable[..., Any] = scope["function"]
        return function


class Noted:
    """A number of a tape."""

    def __init__(self, tape: Tape, name: str):
        self.tape, self.name = tape, name

    def __add__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} + {_text(other)}")

    def __radd__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} + {self.name}")

    def __sub__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} - {_text(other)}")

    def __rsub__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} - {self.name}")

    def __mul__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} * {_text(other)}")

    def __rmul__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} * {self.name}")

    def __truediv__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} / {_text(other)}")

    def __rtruediv__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} / {self.name}")

    def __neg__(self) -> "Noted":
        return self.tape.note(f"-{self.name}")


def _text(value: Any) -> str:
    return value.name if isinstance(value, Noted) else repr(float(value))


def _unpacked(called: str, names: Sequence[Noted]) -> list[str]:
    return ["".join(f"{each.name}, " for each in names) + f"= {called}"] if names else []
