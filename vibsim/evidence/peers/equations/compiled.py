"""The equations of a scene as Python functions of time, state and parameters."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vibsim.evidence.peers.equations.mode_equations import ModeEquations, parameter_count, parameters_of
from vibsim.evidence.peers.equations.of_motion import Equations
from vibsim.evidence.peers.equations.straight_line import Tape
from vibsim.evidence.peers.equations.switches import switches_of
from vibsim.evidence.peers.equations.tied_bodies import masses, rows_of
from vibsim.physics.parts import Friction, Scene


class Compiled:
    """`motion`: d state/dt; `balance`: the same and, behind it, the force in each part that can tie [N];
    `parts`: depth and rate of each stop, 0 and the velocity of slip of each friction.

    ties : which parts can tie; masses [kg]; rows, of_base : the bodies, and the share of the base, in the
    displacement of each part's ends
    """

    def __init__(self, scene: Scene):
        self.scene, self.switches = scene, switches_of(scene)
        self._sizes = state_count(scene), parameter_count(scene)
        self.ties = [i for i, switch in enumerate(self.switches) if switch.tie]
        self.masses = masses(scene).tolist()
        rows, of_base = rows_of(scene, self.switches)
        self.of_base = of_base.tolist()
        self.rows = [[(body, sign) for body, sign in enumerate(row) if sign] for row in rows.tolist()]
        self.parts = self._displacements()
        self._base = self._base_motion()
        tape, equations = self._equations()
        self.motion = tape.function(equations.rates)
        self.balance = tape.function([*equations.rates, *equations.ties])
        self._ends: dict[tuple[int, str], list[Callable[..., Any]]] = {}
        self._parameters: dict[tuple[str, ...], list[float]] = {}
        self._halts: dict[tuple[int, ...], list[list[float]]] = {}

    def _equations(self) -> tuple[Tape, ModeEquations]:
        tape = Tape(*self._sizes)
        return tape, ModeEquations(self.scene, tape, tape.t, tape.states, tape.parameters)

    def _displacements(self) -> Callable[..., tuple[float, ...]]:
        """Depth and rate of each stop; 0 and the velocity of slip of each friction."""
        tape = Tape(self._sizes[0])
        at, values = Equations(self.scene, tape, tape.t, tape.states), []
        for part in (switch.part for switch in self.switches):
            slides = isinstance(part, Friction)
            values += [0.0, at.slip_velocity(part)] if slides else [at.depth(part), at.depth_rate(part)]
        return tape.function(values)

    def _base_motion(self) -> Callable[..., tuple[float, ...]]:
        tape = Tape(self._sizes[0])
        return tape.function(Equations(self.scene, tape, tape.t, tape.states).base)

    def base_acceleration(self, t: float) -> float:
        """X'' [m/s^2]."""
        return self._base(t, [0.0] * self._sizes[0])[2] if self.scene.base else 0.0

    def ends(self, i: int, state: str) -> list[Callable[..., Any]]:
        """The event functions of part i in a state, each as a tuple of one."""
        if (i, state) not in self._ends:
            count = len(self._equations()[1].ends(i, state))
            self._ends[i, state] = [self._end(i, state, place) for place in range(count)]
        return self._ends[i, state]

    def _end(self, i: int, state: str, place: int) -> Callable[..., Any]:
        tape, equations = self._equations()
        return tape.function([equations.ends(i, state)[place]])

    def parameters(self, states: Sequence[str]) -> list[float]:
        """Those of the mode of these states. Raises ArithmeticError where its ties are not unique."""
        key = tuple(states)
        if key not in self._parameters:
            self._parameters[key] = parameters_of(self.scene, states)
        return self._parameters[key]

    def halts(self, parts: Sequence[int]) -> list[list[float]]:
        """What takes unit rates of the displacements of these parts to zero, masses weighing: change of the
        velocity of each body (bodies, parts).
        """
        key = tuple(parts)
        if key not in self._halts:
            rows = rows_of(self.scene, [self.switches[i] for i in parts])[0]
            through = rows.T / np.array(self.masses)[:, None]
            self._halts[key] = (-through @ np.linalg.pinv(rows @ through)).tolist()
        return self._halts[key]


def state_count(scene: Scene) -> int:
    """How many states a scene has: displacement and velocity of each body, angle and speed of a rotor."""
    return 2 * len(scene.bodies) + 2 * scene.has_motor


def start_of(scene: Scene) -> list[float]:
    """The state at t = 0: x, v of each body in turn (, phi, phidot) [m, m/s, rad, rad/s]."""
    state = [float(value) for body in scene.bodies for value in (body.x, body.v)]
    motor = scene.motor
    return state if motor is None else [*state, float(motor.phi), float(motor.phidot)]
