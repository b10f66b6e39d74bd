"""Equations written once for numbers of any kind, turned into straight-line Python functions.

An `OperationLog` hands out numbers that note down what is done with them. What scipy's solvers call again and
again is then a list of assignments to local variables: no loop over parts is left in it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibsim.physics.parts import AT_FORCE, BASE, Friction, RigidStop, Scene

NAMES: dict[str, Any] = {
    "sin": math.sin,
    "cos": math.cos,
    "exp": math.exp,
    "tanh": math.tanh,
    "sgn": lambda v: math.copysign(1.0, v) if v else 0.0,
}


class OperationLog:
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

    def __init__(self, tape: OperationLog, name: str):
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


# The parts of a scene that have states: stops and frictions, and which states each of them has.


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


# Accelerations of bodies some of which are tied, and the forces in the ties, from forces: linear algebra.
#
# Bodies with masses M under forces F, tied by rows W of relative displacements, move by
#
#     M a = F + W' T,     W a = -w0 X''
#
# with T the forces in the ties, w0 the share of the base in the rows and X'' its acceleration. All ties are
# solved for at once; no body is merged with another.


DEPENDENT = 1e-10  # of the largest singular value, below which rows of ties are dependent


@dataclass(frozen=True)
class TiedBodies:
    """a = mobility F + base X'' (n) and T = force F + base_force X'' (ties)."""

    mobility: np.ndarray
    base: np.ndarray
    force: np.ndarray
    base_force: np.ndarray


def masses(scene: Scene) -> np.ndarray:
    """Masses of the bodies [kg], the unbalanced mass of a motor with its body (n)."""
    m = np.array([float(body.m) for body in scene.bodies])
    if scene.motor is not None:
        m[scene.motor.on] += scene.motor.m3
    return m


def rows_of(scene: Scene, switches: Sequence[Switch]) -> tuple[np.ndarray, np.ndarray]:
    """Share of each body (ties, n), and of the base (ties), in the displacement of each part's ends, P
    counted in the direction of the part's positive force.
    """
    rows, base = np.zeros((len(switches), len(scene.bodies))), np.zeros(len(switches))
    for i, switch in enumerate(switches):
        for end, sign in ((switch.part.P, switch.direction), (switch.part.Q, -switch.direction)):
            if end >= 0:
                rows[i, end] = sign
            elif end == BASE:
                base[i] = sign
    return rows, base


def tied_bodies(scene: Scene, tied: Sequence[Switch]) -> TiedBodies:
    """The motion of the bodies of `scene` while the parts `tied` hold their ends together.

    Raises ArithmeticError where more parts tie the same bodies than need be: then the forces are not unique.
    """
    W, w0 = rows_of(scene, tied)
    mobility = np.diag(1 / masses(scene))
    compliance = W @ mobility @ W.T
    spread = np.linalg.svd(compliance, compute_uv=False)
    if len(tied) and spread[-1] < DEPENDENT * spread[0]:
        names = " and ".join(switch.part.name for switch in tied)
        raise ArithmeticError(f"{names} hold the same bodies at once: their forces are not unique")
    inverse = np.linalg.inv(compliance)
    force, base_force = -inverse @ W @ mobility, -inverse @ w0
    through = mobility @ W.T
    return TiedBodies(mobility + through @ force, through @ base_force, force, base_force)
