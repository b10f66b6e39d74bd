"""Equations of motion with the switches left inside: what is written down when nobody looks for events.

An elastic stop acts wherever its depth is positive, and friction follows a function of the velocity of slip:
sgn as printed in Eq. (2.7), or tanh(v / width), which smooths it (then bodies creep instead of sticking).
Rigid stops cannot be written so.
"""

from collections.abc import Callable, Sequence
from typing import Any

from vibsim.evidence.peers.equations.compiled import state_count
from vibsim.evidence.peers.equations.mode_equations import ModeEquations, parameters_of
from vibsim.evidence.peers.equations.of_motion import Equations, Number
from vibsim.evidence.peers.equations.straight_line import Tape
from vibsim.evidence.peers.equations.switches import switches_of
from vibsim.physics.parts import AT_FORCE, Friction, Scene, Stop

Motion = Callable[[float, Sequence[float]], tuple[float, ...]]


def eventless_motion(scene: Scene, width: float | None = None) -> Motion:
    """d state/dt at (t, state), whatever the mode there; width of tanh [m/s], None for sgn."""
    tape = Tape(state_count(scene))
    at = Equations(scene, tape, tape.t, tape.states)
    switches = switches_of(scene)
    flags: list[Number] = []
    for switch in switches:
        slides = isinstance(switch.part, Friction)
        flags += _slipping(tape, at, switch.part, width) if slides else _in_contact(tape, at, switch.part)
        flags += [0.0] * (len(switch.states) - 2)
    untied = parameters_of(scene, [switch.states[0] for switch in switches])[len(flags) :]
    return tape.function(ModeEquations(scene, tape, tape.t, tape.states, [*flags, *untied]).rates)


def _slipping(tape: Tape, at: Equations, part: Friction, width: float | None) -> list[Number]:
    """How much it slips forwards and backwards, 0 to 1."""
    slip = at.slip_velocity(part)
    sign = tape.sgn(slip) if width is None else tape.tanh(slip / width)
    return [tape.where(slip, sign, 0.0), tape.where(slip, 0.0, -sign)]


def _in_contact(tape: Tape, at: Equations, part: Stop) -> list[Number]:
    """0 for free, and whether it acts."""
    acts: Any = 1.0
    if part.release == AT_FORCE:
        acts = tape.where(at.contact_force(part), 1.0, 0.0)
    return [0.0, tape.where(at.depth(part), acts, 0.0)]
